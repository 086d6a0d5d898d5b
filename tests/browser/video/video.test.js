// Moving pictures over a slow link: a video, how good and how small it is, and what happens if the
// browser cannot decode it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test, { after as afterAll } from 'node:test';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { slowLink } from './slow_link.js';
import { rawSocket, say, settled, state } from '../steps.js';

const FAST = 1e9, SLOW = 3e6 / 8;  // Bytes per second.
const VIEWS = 10, STEP_DEG = 2.4;
const COMPARED = 3, MOST_TURNS = 8;
const LEAST_PSNR_DB = 30;
const MOST_OF_JPEG = 0.5;          // Bytes of a video frame of those of a JPEG of equal PSNR.

let raw;  // Beside the slow link.

useServer(['phantom:pelvis', 'resample=128x128x96'], false, async () => {
  const page = await (await browser.newContext()).newPage();
  const icon = new URL('icon.svg', server.url);
  icon.search = new URL(server.url).search;
  await page.goto(icon.href);
  raw = await rawSocket(page, server.url);
  await say(raw, 'overlay off');
});

/** Runs before the page's own code: keeps what is shown, and lets decoders fail. */
function prepare() {
  const Plain = globalThis.WebSocket;
  globalThis.bytesOf = new Map();  // Of moving pictures, by revision.
  globalThis.keys = [];            // Of video frames: whether it is a key frame.
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        if (view?.getUint32(0, true) === 0x46523550 && !(view.getUint8(19) & 1)) {
          globalThis.bytesOf.set(view.getUint32(8, true), view.getUint32(40, true));
          if (view.getUint8(16) === 3) globalThis.keys.push((view.getUint8(19) & 8) !== 0);
        }
        take(event);
      });
    }
  };
  globalThis.failures = 0;  // So many of the next frames cannot be decoded.
  const Decoder = globalThis.VideoDecoder;
  if (Decoder) {
    globalThis.VideoDecoder = class extends Decoder {
      decode(chunk) {
        if (globalThis.failures > 0) {
          globalThis.failures -= 1;
          throw new Error('broken by the test');
        }
        super.decode(chunk);
      }
    };
  }
  globalThis.shown = [];
  let frames = 0;
  const look = () => {
    const { pxpl5 } = globalThis;
    if (pxpl5 && pxpl5.frames !== frames) {
      frames = pxpl5.frames;
      const { kind, revision } = pxpl5;
      const canvas = document.querySelector('[data-testid=frame]');
      const { width, height } = canvas;
      const badge = document.querySelector('[data-testid=badge-quality]').textContent;
      globalThis.shown.push({ kind, revision, width, height, badge, pixels: kind === 'vp8'
        ? canvas.getContext('2d').getImageData(0, 0, width, height).data : null });
      globalThis.shown.splice(0, globalThis.shown.length - 40);
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

const links = [];
afterAll(() => links.forEach(link => link.close()));

/** A page behind a link that is slow once the page is loaded. */
async function openBehindLink(script = prepare) {
  const link = await slowLink(server.url, FAST);
  links.push(link);
  // Without warp, the page shows the moving pictures themselves.
  const opened = await openPage(browser, `${link.url}&warp=off`,
                                { script, viewport: { width: 900, height: 560 } });
  await settled(opened.page);
  link.bytes_per_s = SLOW;
  return opened;
}

let azimuth = 0;

/** Turns step by step, each as soon as a picture of the one before is shown, and waits for rest. */
async function turn(page) {
  await page.evaluate(() => { globalThis.shown = []; });
  let settledAt;
  for (let i = 0; i < VIEWS; i++) {
    azimuth = (azimuth + STEP_DEG) % 360;
    const { revision } = await say(raw, `view ${azimuth.toFixed(1)} 10`);
    await page.waitForFunction(wanted => globalThis.pxpl5.revision >= wanted, revision);
    settledAt = revision;
  }
  const { digest } = await settled(page);
  const shown = await page.evaluate(() =>
    globalThis.shown.map(({ pixels, ...rest }) => rest));
  return { revision: settledAt, digest, shown };
}

const kindsOf = shown => shown.filter(({ kind }) => kind !== 'png').map(({ kind }) => kind);

/** Turns until all moving pictures are video, which needs a measured link. */
async function turnUntil(page, kind) {
  for (let i = 0; i < MOST_TURNS; i++) {
    const turned = await turn(page);
    const kinds = kindsOf(turned.shown);
    if (kinds.length > 2 && kinds.every(each => each === kind)) return turned;
  }
  throw new Error(`moving pictures are not ${kind} after ${MOST_TURNS} turns`);
}

/**
 * In the page: how the shown video frame of a revision compares with its exact picture, which is
 * the mean of two layers: all but the transparent surface, and all with this surface opaque.
 */
async function compareVideo({ behind, front, opacity, revision }) {
  const frame = globalThis.shown.find(each => each.revision === revision && each.pixels);
  const draw = async (file, over, alpha) => {
    const bitmap = await createImageBitmap(file);
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    if (over) {
      context.globalAlpha = alpha;
      context.drawImage(await createImageBitmap(over), 0, 0);
    }
    return { canvas, pixels: context.getImageData(0, 0, bitmap.width, bitmap.height).data };
  };
  const [below, above] = [behind, front].map(text => new Blob(
    [Uint8Array.from(atob(text), letter => letter.charCodeAt(0))], { type: 'image/png' }));
  const { canvas, pixels } = await draw(below, above, opacity);
  const psnr = other => {
    let sum = 0;
    for (let i = 0; i < pixels.length; i++) sum += (pixels[i] - other[i]) ** 2;
    return 10 * Math.log10(255 ** 2 / (sum / (pixels.length * 3 / 4)));
  };
  const video = { psnr: psnr(frame.pixels), bytes: globalThis.bytesOf.get(revision) };
  for (let quality = 0.2; quality < 0.99; quality += 0.02) {
    const file = await canvas.convertToBlob({ type: 'image/jpeg', quality });
    const jpeg = { psnr: psnr((await draw(file)).pixels), bytes: file.size, quality };
    if (jpeg.psnr >= video.psnr) return { video, jpeg };
  }
  return { video, jpeg: null };
}

test('over a slow link, moving pictures are a video of less than half the bytes', async t => {
  const { page, close } = await openBehindLink();
  await turnUntil(page, 'vp8');
  const keys = await page.evaluate(() => globalThis.keys);
  assert.equal(keys[0], true, 'the first video frame is a key frame');
  assert.ok(keys.filter(each => !each).length > VIEWS / 2, 'most frames depend on others');

  const compared = [];
  for (let i = 0; i < MOST_TURNS && compared.length < COMPARED; i++) {
    const { revision, digest, shown } = await turn(page);
    const moving = shown.filter(({ kind }) => kind === 'vp8');
    assert.ok(moving.every(({ badge }) => /VP8 video/.test(badge)), 'the status line says so');
    assert.deepEqual(moving.map(each => each.revision), [...moving.map(each => each.revision)]
      .sort((a, b) => a - b), 'no picture is older than the one before');
    const exactDigest = await raw.evaluate((self, revision) =>
      self.frames.find(each => each.revision === revision && each.last)?.digest, revision);
    assert.equal(digest, exactDigest, 'at rest, the picture is exact');
    const frame = moving.find(each => each.revision === revision);
    if (!frame) continue;
    // A busy machine draws moving pictures smaller.
    const { size, surfaces } = await state(page);
    const { opacity } = surfaces.find(({ name }) => name === 'skin');
    const files = ['behind', 'front'].map(name => path.join(server.folder, `${name}-${i}.png`));
    for (const line of [`size ${frame.width}x${frame.height}`, 'surface skin visible=no',
                        `snapshot ${files[0]}`, 'surface skin visible=yes opacity=1',
                        `snapshot ${files[1]}`, `surface skin opacity=${opacity}`,
                        `size ${size.join('x')}`]) {
      const { ok, error } = await say(raw, line);
      assert.ok(ok, error);
    }
    const [behind, front] = files.map(file => readFileSync(file).toString('base64'));
    const pair = await page.evaluate(compareVideo, { behind, front, opacity, revision });
    compared.push(pair);
  }
  assert.equal(compared.length, COMPARED, 'the last moving pictures were compared');
  const mean = of => compared.reduce((sum, each) => sum + of(each), 0) / compared.length;
  const psnr = mean(({ video }) => video.psnr), bytes = mean(({ video }) => video.bytes);
  const jpeg = mean(({ jpeg }) => jpeg?.bytes ?? Infinity);
  t.diagnostic(`VP8 ${psnr.toFixed(1)} dB, ${(bytes / 1000).toFixed(1)} kB; JPEG of equal PSNR `
    + `${(jpeg / 1000).toFixed(1)} kB`);
  assert.ok(psnr > LEAST_PSNR_DB, `${psnr} dB`);
  assert.ok(bytes < MOST_OF_JPEG * jpeg, `${bytes} bytes, JPEG ${jpeg}`);
  await shoot(page, 'video-rests');
  await close();
});

test('after an error of the decoder the video goes on, and nothing is lost', async () => {
  const { page, close } = await openBehindLink();
  await turnUntil(page, 'vp8');
  await page.evaluate(() => { globalThis.failures = 1; globalThis.keys = []; });
  const { shown, revision } = await turn(page);
  const now = await page.evaluate(() => ({ ...globalThis.pxpl5.video, keys: globalThis.keys }));
  assert.equal(now.failures, 1);
  assert.equal(now.on, true);
  assert.ok(now.keys.includes(true), 'a new video begins with a key frame');
  assert.ok(kindsOf(shown).filter(kind => kind === 'vp8').length > VIEWS / 4);
  assert.equal((await settled(page)).revision, revision);
  assert.equal(await page.getByTestId('toast-info').count(), 0);
  await close();
});

test('a decoder that always fails is said once, and moving pictures are JPEG', async () => {
  const { page, close } = await openBehindLink();
  await turnUntil(page, 'vp8');
  await page.evaluate(() => { globalThis.failures = Infinity; });
  const isSaid = page.getByText(/cannot decode the video .*broken by the test.* JPEG/).waitFor()
    .then(() => shoot(page, 'video-refused'));
  const { revision } = await turn(page);
  await isSaid;
  assert.equal((await settled(page)).revision, revision);
  const { failures, on } = await page.evaluate(() => globalThis.pxpl5.video);
  assert.deepEqual({ failures, on }, { failures: 3, on: false });
  const { shown } = await turn(page);
  assert.ok(kindsOf(shown).length > 0 && kindsOf(shown).every(kind => kind === 'jpeg'));
  await close();
});

test('a browser without a decoder gets JPEG over a slow link, too', async () => {
  const { page, close } = await openBehindLink(new Function(`delete globalThis.VideoDecoder;
    (${prepare})();`));
  await turn(page);
  const { shown } = await turn(page);
  assert.ok(kindsOf(shown).length > 0 && kindsOf(shown).every(kind => kind === 'jpeg'));
  assert.equal(await page.evaluate(() => globalThis.pxpl5.video.on), false);
  await close();
});
