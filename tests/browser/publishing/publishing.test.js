// Pictures to publish: any size, samples, ground, slices, the clipboard. The scene stays as it is.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, shots, usePage } from '../harness.js';
import { rawSocket, say, settled, state, stateWhen } from '../steps.js';

// From 1680 px on, letters are larger.
const WIDE = { width: 1660, height: 720 }, USUAL = { width: 1280, height: 720 };

usePage(undefined, async () => {
  await byId('tab-slices').click();
  await byId('slices-readout').getByText('crosshair').waitFor();
});

/** Chooses in the dialog, and does not save yet. */
async function choose({ what = 'Surfaces', size = '1', free, samples = '16', ground = 'shown',
                        marks = false, legend = false }) {
  await byId('save-menu').click();
  await byId('save-picture-what').selectOption(what);
  await byId('save-picture-size').selectOption(size);
  if (free) {
    await byId('save-picture-size-width').fill(String(free[0]));
    await byId('save-picture-size-height').fill(String(free[1]));
  }
  if (what === 'Surfaces') await byId('save-picture-samples').selectOption(samples);
  await byId('save-picture-ground').selectOption(ground);
  await byId('save-overlay').setChecked(marks);
  await byId('save-legend').setChecked(legend);
}

/** Saves a picture; returns its bytes, its size, and the whole file as a URL. */
async function saved(choices) {
  await choose(choices);
  const [download] = await Promise.all([page.waitForEvent('download'), byId('snapshot').click()]);
  const bytes = readFileSync(await download.path());
  return { bytes, name: download.suggestedFilename(), size: [16, 20].map(at =>
    bytes.readUInt32BE(at)), url: `data:image/png;base64,${bytes.toString('base64')}` };
}

/** In the page: how two pictures differ, each laid over a color first. */
async function compare({ a, b, over }) {
  const pixels = async url => {
    const picture = await createImageBitmap(await (await fetch(url)).blob());
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext('2d');
    context.fillStyle = over;
    context.fillRect(0, 0, picture.width, picture.height);
    context.drawImage(picture, 0, 0);
    return context.getImageData(0, 0, picture.width, picture.height);
  };
  const [one, other] = await Promise.all([pixels(a), pixels(b)]);
  let most = 0, different = 0, far = 0;
  const row = 4 * one.width;
  for (let at = 0; at < one.data.length; at += 4) {
    const by = (from = at) =>
      Math.max(...[0, 1, 2].map(k => Math.abs(one.data[at + k] - other.data[from + k])));
    most = Math.max(most, by());
    different += by() > 0;
    // Letters may begin elsewhere within a pixel.
    far += by() > 64 && [-row - 4, -row, 4 - row, -4, 4, row - 4, row, row + 4].every(step =>
      by(at + step) > 64);
  }
  return { sizes: [one.width, one.height, other.width, other.height], most, different, far,
           first: [...one.data.slice(0, 3)] };
}

/** Compares on a page of its own, whose policy lets it read pictures that the test made. */
async function compared(a, b, over = '#000') {
  const blank = await page.context().newPage();
  try {
    return await blank.evaluate(compare, { a, b, over });
  } finally {
    await blank.close();
  }
}

/** How many pixels of a PNG have no, some, and full opacity. */
async function opacities(url) {
  const blank = await page.context().newPage();
  try {
    return await blank.evaluate(async url => {
      const picture = await createImageBitmap(await (await fetch(url)).blob());
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      canvas.getContext('2d').drawImage(picture, 0, 0);
      const { data } = canvas.getContext('2d').getImageData(0, 0, picture.width, picture.height);
      const counts = { none: 0, some: 0, full: 0 };
      for (let at = 3; at < data.length; at += 4) {
        ++counts[data[at] === 0 ? 'none' : data[at] === 255 ? 'full' : 'some'];
      }
      return counts;
    }, url);
  } finally {
    await blank.close();
  }
}

/** The parts of the state that a saved picture could disturb. */
async function scene() {
  const { revision, size, background, overlay, camera, undo } = await state(page);
  return { revision, size, background, overlay, camera, undo };
}

test('a picture of another shape is the one that a page of this shape shows', async () => {
  await settled(page);
  await page.setViewportSize(WIDE);
  const { size } = await stateWhen(page, now => now.size[0] > 800);
  await settled(page);
  const shown = await saved({ marks: true, legend: true });
  assert.deepEqual(shown.size, size);
  await page.setViewportSize(USUAL);
  await stateWhen(page, now => now.size[0] < 800);
  await settled(page);
  const before = await scene();
  const free = await saved({ size: 'free', free: size, marks: true, legend: true });
  writeFileSync(path.join(shots, 'published-wide.png'), free.bytes);
  assert.deepEqual(free.size, size);
  const { far } = await compared(shown.url, free.url);
  // The panel is not as high as the other one, so that letters are a little larger.
  assert.ok(far < 150, `${far} pixels differ`);
  assert.deepEqual(await scene(), before);
});

test('a picture keeps its marks while slices alone are shown', async () => {
  await settled(page);
  const form = { size: 'free', free: [600, 600], marks: true, legend: true };
  const [marked, bare] = [await saved(form), await saved({ ...form, marks: false, legend: false })];
  const { different: usual } = await compared(marked.url, bare.url);
  assert.ok(usual > 500, 'marks are visible');
  const same = { marks: true, legend: true };  // In the size on the screen, which has own marks.
  const [asShown, plain] = [await saved(same), await saved({})];
  const { different: usualAsShown } = await compared(asShown.url, plain.url);
  await page.keyboard.press('0');
  await byId('stage').waitFor({ state: 'hidden' });
  const [alone, aloneAsShown] = [await saved(form), await saved(same)];
  writeFileSync(path.join(shots, 'published-slices-alone.png'), alone.bytes);
  assert.ok(await byId('stage').isHidden());
  await page.keyboard.press('7');
  await byId('stage').waitFor();
  // The panel is smaller, so that letters are larger in the picture.
  const { different } = await compared(alone.url, bare.url);
  assert.ok(different > 0.9 * usual, `${different} pixels of marks, usually ${usual}`);
  assert.deepEqual(aloneAsShown.size, plain.size);
  const { different: own } = await compared(aloneAsShown.url, plain.url);
  assert.ok(own > 0.9 * usualAsShown && own < 3 * usualAsShown,
            `${own} pixels of marks, usually ${usualAsShown}`);
});

test('a picture of 1920 x 1080 has 16 samples, whatever the Renderers have room for', async () => {
  const before = await scene();
  const { bytes, size } = await saved({ size: '1920x1080', marks: true });
  writeFileSync(path.join(shots, 'published-1920.png'), bytes);
  assert.deepEqual(size, [1920, 1080]);
  assert.ok(bytes.includes(Buffer.from('pxpl5:samples\u000016')), 'the file says 16 samples');
  assert.match(await byId('toast-info').last().innerText(), /1920 × 1080 pixels, 16 samples/);
  assert.deepEqual(await scene(), before);
});

test('one sample per pixel is another picture than 16', async () => {
  const [one, many] = [await saved({ samples: '1' }), await saved({ samples: '16' })];
  assert.ok((await compared(one.url, many.url)).different > 1000);
});

test('a transparent ground, laid over any color, is the picture over this color', async () => {
  const { background } = await state(page);
  const clear = await saved({ ground: 'transparent' });
  writeFileSync(path.join(shots, 'published-clear.png'), clear.bytes);
  const { none, some, full } = await opacities(clear.url);
  assert.ok(none > 10_000 && some > 1000 && full > 1000, JSON.stringify({ none, some, full }));
  const shown = await saved({});
  assert.ok((await compared(clear.url, shown.url, background)).most <= 2);
  const white = await saved({ ground: 'white' });
  const over = await compared(clear.url, white.url, '#fff');
  assert.deepEqual(over.first, [255, 255, 255]);
  assert.ok(over.most <= 2, `${over.most} levels`);
});

test('a size out of range is refused in the dialog, with both limits', async () => {
  for (const [width, height, words] of [
    [4097, 100, 'Width is "4097", must be a whole number from 1 to 4096 pixels.'],
    [100, 0, 'Height is "0", must be a whole number from 1 to 4096 pixels.']]) {
    await choose({ size: 'free', free: [width, height] });
    await byId('snapshot').click();
    assert.equal(await byId('save-picture-wrong').innerText(), words);
    assert.ok(await byId('save').isVisible());
    await page.keyboard.press('Escape');
  }
});

test('an error of the machine is told, and the scene stays as it was', async () => {
  const before = await scene();
  await choose({ ground: 'transparent' });
  await byId('save-picture-format').selectOption('exr');
  await byId('snapshot').click();
  await byId('toast-error').getByText('cannot have a transparent ground').waitFor();
  await byId('toast-error').getByRole('button').click();
  assert.deepEqual(await scene(), before);
  await byId('save-menu').click();
  await byId('save-picture-format').selectOption('png');
  await page.keyboard.press('Escape');
});

test('a slice is saved as it is shown: window, zoom, contours, letters', async () => {
  await byId('slice-settings').locator('summary').click();
  await byId('slice-larger').click();
  await page.mouse.move(1, 1);
  await page.evaluate(() => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(done))));
  for (const plane of ['Axial', 'Coronal', 'Sagittal']) {
    const shown = await byId(`slice-${plane.toLowerCase()}`).evaluate(canvas =>
      canvas.toDataURL('image/png'));
    const { url, name, bytes } = await saved({ what: `${plane} slice`, marks: true });
    assert.match(name, new RegExp(`-${plane.toLowerCase()}\\.png$`));
    const { sizes, different } = await compared(shown, url);
    assert.deepEqual(sizes.slice(0, 2), sizes.slice(2));
    assert.equal(different, 0, plane);
    if (plane === 'Axial') writeFileSync(path.join(shots, 'published-slice.png'), bytes);
  }
  const bare = await saved({ what: 'Axial slice' });
  const marked = await saved({ what: 'Axial slice', marks: true });
  assert.ok((await compared(bare.url, marked.url)).different > 100, 'letters and crosshair');
  const large = await saved({ what: 'Axial slice', size: '1920x1080', marks: true, legend: true,
                              ground: 'white' });
  writeFileSync(path.join(shots, 'published-slice-1920.png'), large.bytes);
  assert.deepEqual(large.size, [1920, 1080]);
});

test('only slices that are shown are offered', async () => {
  await byId('tab-volume').click();
  await byId('save-menu').click();
  const offered = () => byId('save-picture-what').locator('option').allInnerTexts();
  assert.deepEqual(await offered(), ['Surfaces']);
  await page.keyboard.press('Escape');
  await byId('tab-slices').click();
  await byId('save-menu').click();
  assert.deepEqual(await offered(),
                   ['Surfaces', 'Axial slice', 'Coronal slice', 'Sagittal slice']);
  await page.keyboard.press('Escape');
});

test('a copied picture is in the clipboard', async () => {
  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await choose({ size: 'free', free: [321, 123] });
  await byId('picture-copy').click();
  const told = page.locator('[data-testid^=toast-]').filter({ hasText: /opy|opied|lipboard/ });
  assert.match(await told.last().innerText(), /Copied the picture, 321 × 123 pixels, 16 samples/);
  assert.deepEqual(await page.evaluate(async () => {
    const [item] = await navigator.clipboard.read();
    const { width, height } = await createImageBitmap(await item.getType('image/png'));
    return [item.types, width, height];
  }), [['image/png'], 321, 123]);
});

test('the command refuses what it cannot write, with the remedy', async () => {
  const raw = await rawSocket(page, server.url);
  const { error } = await say(raw, 'snapshot download:x.png size=5000x10');
  assert.match(error, /5000/);
  assert.match(error, /4096/);
  assert.match((await say(raw, 'snapshot download:x.png ground=nothing')).error, /nothing/);
});
