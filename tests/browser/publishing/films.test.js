// Films: a turntable and a sweep from the dialog, played by the browser; progress, cancel, errors.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, shots, usePage } from '../harness.js';
import { rawSocket, say, settled, state } from '../steps.js';

const SIZE = [320, 200];

let raw;

usePage(undefined, async () => {
  await settled(page);
  raw = await rawSocket(page, server.url);
  await say(raw, 'overlay off');  // Films have no marks.
  await settled(page);
});

/** Chooses in the dialog, and does not make the film yet. */
async function choose(kind, pictures, rate, more = {}) {
  await byId('save-menu').click();
  await byId('film-kind').selectOption(kind);
  await byId('film-size').selectOption('free');
  await byId('film-size-width').fill(String(SIZE[0]));
  await byId('film-size-height').fill(String(SIZE[1]));
  await byId('film-samples').selectOption('4');
  await byId('film-pictures').fill(String(pictures));
  await byId('film-rate').fill(String(rate));
  if (more.surface) await byId('film-surface').selectOption(more.surface);
  for (const each of ['degrees', 'from', 'to']) {
    if (more[each] !== undefined) await byId(`film-${each}`).fill(String(more[each]));
  }
}

async function made(...choices) {
  await choose(...choices);
  const [download] = await Promise.all([page.waitForEvent('download'), byId('film-go').click()]);
  const bytes = readFileSync(await download.path());
  return { bytes, name: download.suggestedFilename(),
           url: `data:video/webm;base64,${bytes.toString('base64')}` };
}

/** The machine's own pictures, as data URLs. `{}` in the command stands for their files. */
async function picturesOf(name, count, line) {
  const file = number => path.join(server.folder, `${name}${number}.png`);
  const { ok, error } = await say(raw, line.replace('{}', `${file('{}')} samples=4 size=${
    SIZE.join('x')}`));
  assert.ok(ok, error);
  return Array.from({ length: count }, (_, number) => `data:image/png;base64,${
    readFileSync(file(String(number).padStart(4, '0'))).toString('base64')}`);
}

/**
 * Plays a film on a page of its own, seeks to the middle of each picture, and compares it with all
 * pictures: the mean difference of red, green and blue.
 */
async function played(url, pictures, rate) {
  const blank = await page.context().newPage();
  try {
    return await blank.evaluate(async ({ url, pictures, rate }) => {
      const event = (target, name) => new Promise((done, fail) => {
        target.addEventListener(name, done, { once: true });
        target.addEventListener('error', () => fail(new Error(target.error?.message)),
                                { once: true });
      });
      const pixels = source => {
        const [width, height] = [source.videoWidth ?? source.width,
                                 source.videoHeight ?? source.height];
        const context = new OffscreenCanvas(width, height).getContext('2d');
        context.drawImage(source, 0, 0);
        return context.getImageData(0, 0, width, height).data;
      };
      const video = document.createElement('video');
      video.muted = true;
      video.src = url;
      await event(video, 'loadeddata');
      const sources = [];
      for (const each of pictures) {
        sources.push(pixels(await createImageBitmap(await (await fetch(each)).blob())));
      }
      const differences = [];
      for (let number = 0; number < pictures.length; ++number) {
        const seeked = event(video, 'seeked');
        video.currentTime = (number + 0.5) / rate;
        await seeked;
        const shown = pixels(video);
        differences.push(sources.map(source => {
          let sum = 0;
          for (let at = 0; at < source.length; ++at) {
            sum += at % 4 === 3 ? 0 : Math.abs(source[at] - shown[at]);
          }
          return sum / (source.length * 3 / 4);
        }));
      }
      video.currentTime = 0;
      await video.play();
      await event(video, 'ended');
      return { duration: video.duration, size: [video.videoWidth, video.videoHeight],
               differences };
    }, { url, pictures, rate });
  } finally {
    await blank.close();
  }
}

/** The compressed pixels of a PNG. */
function pixelsOf(url) {
  const bytes = Buffer.from(url.split(',')[1], 'base64');
  return bytes.subarray(bytes.indexOf('IDAT'));
}

/** Each picture of the film is the machine's picture of its place. */
function assertSame({ differences }) {
  differences.forEach((row, number) => {
    assert.ok(row[number] < 2, `picture ${number} differs by ${row[number]} levels`);
    assert.equal(row.indexOf(Math.min(...row)), number, `picture ${number}: ${row}`);
  });
}

async function scene() {
  const { revision, size, background, camera, surfaces } = await state(page);
  return { revision, size, background, camera,
           surfaces: surfaces.map(({ name, isovalue }) => [name, isovalue]) };
}

test('a turntable has the pictures of the machine, and leaves the scene as it was', async () => {
  const before = await scene();
  const { bytes, name, url } = await made('turntable', 7, 5, { degrees: 90 });
  writeFileSync(path.join(shots, 'turntable.webm'), bytes);
  assert.equal(name, 'phantom-pelvis-turntable.webm');
  assert.match(await byId('toast-info').last().innerText(), /7 pictures, 1.4 s/);
  assert.deepEqual(await scene(), before);
  const pictures = await picturesOf('turn', 7, 'orbit 7 {} degrees=90');
  const film = await played(url, pictures, 5);
  assert.deepEqual(film.size, SIZE);
  assert.ok(Math.abs(film.duration - 1.4) < 0.001, String(film.duration));
  assertSame(film);
  // The last picture is the view after the whole turn.
  const { camera } = before;
  assert.ok((await say(raw, `view ${camera.azimuth_deg + 90} ${camera.elevation_deg}`)).ok);
  const [end] = await picturesOf('end', 1, 'orbit 1 {}');
  assert.ok(pixelsOf(end).equals(pixelsOf(pictures[6])));
  await say(raw, 'undo');
});

test('a sweep has the pictures of the machine, and the surface its isovalue again', async () => {
  await settled(page);
  const before = await scene();
  const { name, url } = await made('sweep', 5, 10, { surface: 'bone', from: 100, to: 500 });
  assert.equal(name, 'phantom-pelvis-sweep.webm');
  const now = await scene();
  assert.deepEqual(now.surfaces, before.surfaces);
  assert.deepEqual(now.size, before.size);
  const pictures = await picturesOf('sweep', 5, 'sweep bone 100 500 5 {}');
  assertSame(await played(url, pictures, 10));
});

test('a film in progress is canceled, and leaves no file', async () => {
  await settled(page);
  const before = await scene();
  const film = () => page.evaluate(async token => {
    const response = await fetch(`download/phantom-pelvis-turntable.webm${token}`);
    const digest = await crypto.subtle.digest('SHA-256', await response.arrayBuffer());
    return `${response.status} ${[...new Uint8Array(digest)]}`;
  }, new URL(server.url).search);
  const former = await film();
  assert.match(former, /^200 /);
  await choose('turntable', 10_000, 60, { degrees: 720 });
  await byId('film-go').click();
  await byId('work-what').getByText(/picture \d+ of 10000/).waitFor();
  await byId('cancel').click();
  await byId('toast-error').getByText(/cancel/i).waitFor();
  await byId('toast-error').getByRole('button').click();
  const now = await scene();
  assert.deepEqual([now.size, now.camera, now.surfaces],
                   [before.size, before.camera, before.surfaces]);
  assert.equal(await film(), former, 'the film before it is still there');
  const { bytes } = await made('turntable', 2, 1);
  assert.ok(bytes.length > 1000, 'the machine works on');
});

test('a wrong number is refused in the dialog', async () => {
  for (const [pictures, rate, more, words] of [
    [1, 25, {}, 'Pictures is "1", must be a whole number from 2 to 10000.'],
    [10, 61, {}, 'Pictures per second is "61", must be a number from 1 to 60.'],
    [10, 25, { degrees: 99999 }, 'Degrees is "99999", must be a number from -36000 to 36000.']]) {
    await choose('turntable', pictures, rate, more);
    await byId('film-go').click();
    assert.equal(await byId('film-wrong').innerText(), words);
    await page.keyboard.press('Escape');
  }
});

test('the commands refuse options of another kind of file, and tell the remedy', async () => {
  const errorOf = async line => (await say(raw, line)).error ?? 'none';
  assert.match(await errorOf('orbit 2 download:x.webm delay_ms=50'), /rate=20/);
  assert.match(await errorOf('orbit 2 download:x.gif rate=20'), /delay_ms/);
  assert.match(await errorOf('orbit 2 download:x.webm ground=transparent'), /ground=white/);
  assert.match(await errorOf('orbit 2 download:x.webm rate=61'), /61/);
  assert.match(await errorOf('orbit 2 download:x.avi'), /\.webm/);
});
