// Folders from this computer: few requests, several series as a choice, first views that fit.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from './dicom.js';
import { byId, page, server, usePage } from './harness.js';
import { drop, errorsShown, rawSocket, say, settled, state, stateWhen, unfold } from './steps.js';
import { writeEllipsoid } from './volumes.js';

usePage();

/** Chooses a folder of this computer, and counts the requests that upload it. */
async function chooseFolder(folder) {
  const requests = [];
  page.on('request', request => {
    if (request.url().includes('/upload')) requests.push(new URL(request.url()).pathname);
  });
  await byId('open-panel').click();
  await byId('open-folder').setInputFiles(folder);
  return requests;
}

test('a folder with several series is a choice, and the chosen one opens', async () => {
  const folder = path.join(server.folder, 'study');
  writeSeries(folder, [{ description: 'Thorax 5 mm', side: 10 },
    { description: 'Thorax 1 mm', side: 14 }]);
  const requests = await chooseFolder(folder);
  await byId('series-2').waitFor();
  assert.doesNotMatch(await byId('open').innerText(), /\/uploads\//, "the server's own folder");
  assert.match(await byId('series-1').innerText(), /Thorax 5 mm.*10 × 10 × 10/s);
  assert.deepEqual(requests, ['/upload/files', '/upload/done'], '24 files in one request');
  await byId('series-2').click();
  const { volume } = await stateWhen(page, now => now.volume?.size[2] === 14 && !now.busy);
  assert.match(volume.name, /study|Thorax/);
  await byId('open').waitFor({ state: 'hidden' });
  assert.deepEqual(await errorsShown(page), []);
});

for (const [side, modality, name] of /** @type {const} */ ([[11, 'MR', 'knee'],
                                                            [13, 'PT', 'tumor']])) {
  test(`a tissue of CT is refused for ${modality}, with advice`, async () => {
    const folder = path.join(server.folder, name);
    writeSeries(folder, [{ description: name, side, modality }]);
    await chooseFolder(folder);
    await stateWhen(page, (now, side) => now.volume?.size[2] === side && !now.busy, side);
    const raw = await rawSocket(page, server.url);
    const { ok, error } = await say(raw, 'surface bone preset=bone');
    assert.equal(ok, false);
    assert.match(error, new RegExp(`this volume is ${modality}.*give iso=V`));
    assert.equal(await page.getByRole('group', { name: 'Tissues' }).isVisible(), false);
    assert.ok(await byId('window-Bone').isHidden(), 'a window in HU');
    await byId('tab-volume').click();
    assert.match(await byId('volume-facts').innerText(), new RegExp(`\\b${modality}\\b`));
    await byId('tab-slices').click();
  });
}

test('the options of a path are there for a dropped folder, too', async () => {
  const folder = path.join(server.folder, 'options');
  writeSeries(folder, [{ description: 'A', side: 10 }, { description: 'B', side: 12 }]);
  await chooseFolder(folder);
  await byId('series-1').waitFor();
  await unfold(page);
  await byId('open-resample').fill('6x6x6');
  await byId('series-1').click();
  await stateWhen(page, now => now.volume?.size.every(each => each === 6) && !now.busy);
  await byId('open').waitFor({ state: 'hidden' });
});

test('options that are typed first are used for a folder that is chosen or dropped', async () => {
  const folder = path.join(server.folder, 'typed');
  writeSeries(folder, [{ description: 'One', side: 12 }]);
  for (const [count, give] of /** @type {const} */ ([
    [5, () => byId('open-folder').setInputFiles(folder)], [7, () => drop(page, [folder])]])) {
    await byId('open-panel').click();
    await unfold(page);
    await byId('open-resample').fill(Array(3).fill(count).join('x'));
    await give();
    await stateWhen(page, (now, count) => now.volume?.size[2] === count && !now.busy, count);
    await byId('open-panel').click();
    assert.equal(await byId('open-resample').inputValue(), '', 'of one volume only');
    await page.keyboard.press('Escape');
  }
});

test('options that are typed are used for a built-in volume, and end with the dialog', async () => {
  await byId('open-panel').click();
  await unfold(page);
  await byId('open-resample').fill('9x9x9');
  await byId('phantom-torus').click();
  await stateWhen(page, now => now.volume?.size.every(each => each === 9) && !now.busy);
  await byId('open-panel').click();
  await byId('open-resample').fill('4x4x4');
  await page.keyboard.press('Escape');
  await drop(page, [path.join(server.folder, 'typed')]);
  const { volume } = await stateWhen(page, now => now.volume?.size[0] !== 9 && !now.busy);
  assert.deepEqual(volume.size, [12, 12, 12]);
});

/** In the page: the part of the picture that is not its ground, as shares of its sides. */
function shownPart(canvas) {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  const pixels = new Uint32Array(data.buffer);
  const found = { left: width, right: -1, top: height, bottom: -1 };
  pixels.forEach((pixel, at) => {
    if (pixel !== pixels[0]) {
      const x = at % width, y = Math.floor(at / width);
      found.left = Math.min(found.left, x);
      found.right = Math.max(found.right, x);
      found.top = Math.min(found.top, y);
      found.bottom = Math.max(found.bottom, y);
    }
  });
  return { left: found.left / width, right: 1 - (found.right + 1) / width,
           top: found.top / height, bottom: 1 - (found.bottom + 1) / height };
}

for (const [name, size, radii] of /** @type {const} */ ([
  ['tall', [20, 20, 90], [9, 9, 44]], ['wide', [90, 20, 20], [44, 9, 9]],
  ['small in a corner', [60, 60, 60], [10, 10, 10]]])) {
  test(`the first view shows a ${name} surface whole and large`, async () => {
    const file = writeEllipsoid(path.join(server.folder, `${name.split(' ')[0]}.nrrd`), size,
                                radii);
    await byId('open-panel').click();
    await byId('open-path').fill(file);
    await byId('open-go').click();
    await stateWhen(page, (now, file) => now.volume?.source === file && !now.busy, file);
    await settled(page);
    const free = await byId('frame').evaluate(shownPart);
    const least = Math.min(...Object.values(free));
    assert.ok(least > 0.02, `touches the edge: ${JSON.stringify(free)}`);
    assert.ok(Math.min(free.left + free.right, free.top + free.bottom) < 0.35,
              `small: ${JSON.stringify(free)}`);
    const { camera } = await state(page);
    assert.deepEqual([camera.azimuth_deg, camera.elevation_deg], [0, 0]);
  });
}
