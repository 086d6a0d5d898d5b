// Picks are of surfaces: neighboring pixels of the default scene, its skin half transparent, give
// one answer, whichever surface the screen door happens to show there.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, usePage } from './harness.js';
import { after, errorsShown, middleOf, settled, state, stateWhen } from './steps.js';

const BONE_HU = 250.5;
const NEAR_PX = [[0, 0], [1, 0], [0, 1], [1, 1], [2, 1], [3, 2]];

usePage(['phantom:pelvis']);

/** Half the diagonal of a voxel, in millimeters. */
const halfVoxel = ({ volume }) => Math.hypot(...volume.spacing_mm) / 2;

/** Where a click may go: a place in the middle of the picture where bone lies behind the skin. */
async function boneAt() {
  const { x, y } = await middleOf(byId('stage'));
  return { x: Math.round(x), y: Math.round(y) - 60 };
}

/** What a click tells: the surface, and the place in millimeters. */
async function pointed(x, y) {
  const told = page.evaluate(() => new Promise(resolve =>
    document.addEventListener('place', event => resolve(event.detail.p_mm), { once: true })));
  await page.mouse.click(x, y);
  const p_mm = await told;
  await byId('pointed').waitFor();
  return { surface: await byId('pointed').locator('strong').innerText(), p_mm };
}

test('a click tells one surface and one depth, whatever pixel it meets', async () => {
  await settled(page);
  const { x, y } = await boneAt();
  const found = [];
  for (const [dx, dy] of NEAR_PX) {
    found.push(await pointed(x + dx, y + dy));
  }
  const now = await state(page);
  assert.deepEqual([...new Set(found.map(({ surface }) => surface))], ['bone']);
  const depths = found.map(({ p_mm }) => p_mm[1]);
  const spread = Math.max(...depths) - Math.min(...depths);
  assert.ok(spread < 2 * halfVoxel(now), `depths ${depths}, 3 pixels apart`);
});

test('the pointed line names the transparent skin in front', async () => {
  const { x, y } = await boneAt();
  await pointed(x, y);
  assert.match(await byId('pointed').innerText(), /bone.*in front: skin/s);
});

test('the pointed line tells the isovalue from the value of the nearest voxel', async () => {
  const { x, y } = await boneAt();
  await pointed(x, y);
  assert.match(await byId('pointed').innerText(), /bone\s+isovalue 250\.5, nearest voxel -?\d/);
});

test('a distance does not jump with the pixel of its ends', async () => {
  const { x, y } = await boneAt();
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const list = byId('measure-list').locator('li');
  for (const [index, [dx, dy]] of NEAR_PX.slice(0, 4).entries()) {
    await page.mouse.click(x - 20 + dx, y + dy);
    await page.mouse.click(x + 20, y);
    await list.nth(index).waitFor();
  }
  await page.keyboard.press('Escape');
  const told = (await list.locator('b').allInnerTexts()).map(Number.parseFloat);
  const spread = Math.max(...told) - Math.min(...told);
  assert.ok(spread < 2 * halfVoxel(await state(page)), `distances ${told} mm`);
});

test('a part is chosen by any pixel of its surface', async () => {
  const { x, y } = await boneAt();
  await byId('choose-bone').click();
  for (const [dx, dy] of NEAR_PX.slice(0, 4)) {
    await byId('surface-components-bone').selectOption('at');
    await after(page, () => page.mouse.click(x + dx, y + dy),
                now => now.surfaces.some(({ components }) => components.startsWith('at')));
    assert.deepEqual(await errorsShown(page), []);
    await byId('surface-components-bone').selectOption('show=all');
    await stateWhen(page, now => now.surfaces.every(
      ({ components }) => !components.startsWith('at')));
  }
});

test('a click on tissue gives one isovalue, whichever pixel it meets', async () => {
  await byId('choose-bone').click();
  const values = [];
  for (const [dx, dy] of NEAR_PX.slice(0, 4)) {
    const { x, y } = await boneAt();
    await byId('tissue-mode').click();
    const { state: now } = await after(page, () => page.mouse.click(x + dx, y + dy));
    values.push(now.surfaces.find(({ name }) => name === 'bone').isovalue);
    await page.keyboard.press('Escape');
  }
  // Each click starts from the isovalue that the last one set. The skin's is hundreds of HU lower.
  assert.ok(values.every(value => Math.abs(value - BONE_HU) < 20), `isovalues ${values}`);
});
