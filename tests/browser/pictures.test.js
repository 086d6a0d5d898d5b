// A saved picture is the one on the screen: pixels, samples, letters, scale bar, measurements.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, shots, usePage } from './harness.js';
import { after, middleOf, settled, state, stateWhen } from './steps.js';
import { writeEllipsoid } from './volumes.js';

usePage(['phantom:pelvis']);

/** Saves the picture as wished; returns it as a data URL. */
async function savedPicture({ marks, legend, size = '1' }) {
  await byId('save-menu').click();
  await byId('save-overlay').setChecked(marks);
  await byId('save-legend').setChecked(legend);
  await byId('save-picture-size').selectOption(size);
  const [download] = await Promise.all([page.waitForEvent('download'), byId('snapshot').click()]);
  assert.match(download.suggestedFilename(), /\.png$/);
  const bytes = readFileSync(await download.path());
  return { bytes, url: `data:image/png;base64,${bytes.toString('base64')}` };
}

/**
 * In the page: how two PNG files differ. A pixel is `far` if no pixel beside it in the other file
 * is like it: the edges of letters depend on where within a pixel they begin. `corner` counts the
 * different pixels at the top left.
 */
async function compare({ a, b }) {
  const pixels = async url => {
    const picture = await createImageBitmap(await (await fetch(url)).blob());
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext('2d');
    context.drawImage(picture, 0, 0);
    return context.getImageData(0, 0, picture.width, picture.height);
  };
  const [one, other] = await Promise.all([pixels(a), pixels(b)]);
  let different = 0, far = 0, corner = 0;
  for (let at = 0; at < one.data.length; at += 4) {
    const by = (from = at) =>
      Math.max(...[0, 1, 2].map(k => Math.abs(one.data[at + k] - other.data[from + k])));
    different += by() > 0;
    const x = at / 4 % one.width, y = Math.floor(at / 4 / one.width);
    corner += by() > 0 && x < one.width * 0.35 && y < one.height * 0.12;
    if (by() > 64) {
      const row = 4 * one.width;
      far += [-row - 4, -row, 4 - row, -4, 4, row - 4, row, row + 4].every(step =>
        by(at + step) > 64);
    }
  }
  return { sizes: [one.width, one.height, other.width, other.height], different, far, corner,
           count: one.data.length / 4 };
}

/** Compares on a page of its own, whose policy lets it read pictures that the test made. */
async function compared(a, b) {
  const blank = await page.context().newPage();
  try {
    return await blank.evaluate(compare, { a, b });
  } finally {
    await blank.close();
  }
}

const canvasUrl = () => byId('frame').evaluate(canvas => canvas.toDataURL('image/png'));

/** A turned view with the crosshair and a distance. */
async function makeMarks() {
  await after(page, async () => {
    await byId('stage').focus();
    for (let n = 0; n < 6; n++) await page.keyboard.press('ArrowRight');
  });
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.click(x - 40, y - 40);
  await page.mouse.click(x + 40, y - 40);
  await byId('measure-list').locator('b').waitFor();
  await byId('leave-mode').click();
  await settled(page);
}

/** Hides or shows what is over the picture and no part of it. */
function setOthers(visibility) {
  return page.evaluate(visibility => {
    for (const id of ['views', 'hint', 'toasts', 'pointed']) {
      const element = document.getElementById(id);
      if (element) element.style.visibility = visibility;
    }
    document.activeElement?.blur();
  }, visibility);
}

test('a saved picture without marks has the very pixels of the screen, all samples', async () => {
  await settled(page);
  await makeMarks();
  const { url } = await savedPicture({ marks: false, legend: false });
  const { sizes, different } = await compared(await canvasUrl(), url);
  assert.deepEqual(sizes.slice(0, 2), sizes.slice(2));
  assert.deepEqual(sizes.slice(0, 2), (await state(page)).size);
  assert.equal(different, 0);
});

test('with marks, it is what a screenshot of the picture shows', async () => {
  const { url, bytes } = await savedPicture({ marks: true, legend: false });
  const plain = await compared(await canvasUrl(), url);
  assert.ok(plain.different > 2000, 'letters, bar, cube and distance are there');
  // The buttons and messages over the picture are no part of it.
  await setOthers('hidden');
  await page.mouse.move(1, 1);  // The edges of the sides shine under the pointer.
  const box = await byId('frame').boundingBox();
  const [width, height] = (await state(page)).size;
  const clip = { x: Math.round(box.x), y: Math.round(box.y), width, height };
  const screen = await page.screenshot({ clip });
  await setOthers('');
  const { sizes, far, count } = await compared(
    `data:image/png;base64,${screen.toString('base64')}`, url);
  assert.deepEqual(sizes.slice(0, 2), sizes.slice(2));
  assert.ok(bytes.length > 1000);
  writeFileSync(path.join(shots, 'saved-marks.png'), bytes);
  writeFileSync(path.join(shots, 'screen-marks.png'), screen);
  // The place of the picture may be a fraction of a pixel. A browser rounds it for the picture, but
  // not for the marks: edges of lines differ.
  assert.ok(far < 100, `${far} of ${count} pixels differ`);
});

test('a larger picture has the asked size and the legend', async () => {
  const [width, height] = (await state(page)).size;
  const { bytes } = await savedPicture({ marks: true, legend: true, size: '2' });
  writeFileSync(path.join(shots, 'saved-twice.png'), bytes);
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [2 * width, 2 * height]);
  assert.deepEqual((await state(page)).size, [width, height], 'the screen keeps its size');
  const { url } = await savedPicture({ marks: false, legend: true });
  const { different } = await compared(await canvasUrl(), url);
  assert.ok(different > 500, 'the legend is written');
});

test('a picture that is limited in size keeps its proportions', async () => {
  await page.setViewportSize({ width: 1900, height: 900 });
  // Four times as wide is too wide for a picture.
  const [width, height] = (await stateWhen(page, now => now.size[0] > 1024)).size;
  await settled(page);
  const { bytes } = await savedPicture({ marks: true, legend: true, size: '4' });
  const [wide, high] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
  assert.equal(wide, 4096);
  assert.ok(Math.abs(high - height * wide / width) <= 0.5, `${wide}x${high} of ${width}x${height}`);
  assert.match(await page.getByTestId('toast-info').last().innerText(), /samples? per pixel/);
});

test('a saved picture says what it shows, as those of the terminal do', async () => {
  for (const marks of [true, false]) {
    const { bytes, url } = await savedPicture({ marks, legend: marks });
    for (const text of ['pxpl5:volume', 'phantom:pelvis', 'pxpl5:voxel_digest', 'pxpl5:samples']) {
      assert.ok(bytes.includes(text), `${text} is missing`);
    }
    const { count } = await compared(url, url);
    assert.ok(count > 0, 'browsers still read it');
  }
});

test('a saved picture has the warning of an assumed place with letters or legend', async () => {
  await after(page, () => page.setViewportSize({ width: 390, height: 844 }),
              now => now.size[0] <= 390);
  const corner = async marks => {
    const { url } = await savedPicture({ marks, legend: false });
    return (await compared(await canvasUrl(), url)).corner;
  };
  assert.equal(await corner(true), 0, 'a stated place needs no warning');
  const file = writeEllipsoid(path.join(server.folder, 'unplaced.nrrd'), [20, 20, 20], [8, 8, 8],
                              false);
  await after(page, async () => {
    await byId('open-panel').click();
    await byId('open-path').fill(file);
    await byId('open-go').click();
  }, (now, file) => now.volume?.source === file, file);
  assert.ok(await corner(true) > 100);
});
