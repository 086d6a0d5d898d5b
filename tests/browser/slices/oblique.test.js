// The oblique slice: a plane through the crosshair, turned by two angles.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { planeThrough } from '../../../host/serve/page/slices/oblique_plane.js';
import { after, canvasPixels, middleOf, rawSocket, say, settled, state } from '../steps.js';

const NOTCH = 120;

let raw;

usePage(undefined, async () => {
  raw = await rawSocket(page, server.url);
  await byId('tab-slices').click();
  await settled(page);
  await after(page, () => say(raw, 'load phantom:sphere'),
              now => now.volume?.name.includes('sphere'));
  await byId('slices-readout').getByText('crosshair').waitFor();
});

const pixelsOf = id => canvasPixels(byId(id));

/** The value and the voxel that the readout tells. */
async function told() {
  const text = await byId('slices-readout').innerText();
  const voxel = /voxel (\d+), (\d+), (\d+)/.exec(text)?.slice(1).map(Number);
  return { text, value: Number.parseFloat(text), voxel };
}

async function crosshair() {
  await page.mouse.move(1, 1);
  await byId('slices-readout').getByText('crosshair').waitFor();
  return told();
}

/** Waits until the slice is another picture. */
async function changed(id, before) {
  for (;;) {
    const now = await pixelsOf(id);
    if (!before || Buffer.compare(now, before) !== 0) return now;
  }
}

async function setAngle(name, degrees) {
  await byId(`oblique-${name}`).fill(String(degrees));
}

test('an open oblique slice is a dashed line in the others', async () => {
  const slices = ['slice-axial', 'slice-coronal', 'slice-sagittal'];
  const before = await Promise.all(slices.map(pixelsOf));
  const empty = await pixelsOf('slice-oblique').catch(() => null);
  await byId('oblique').locator('summary').click();
  await changed('slice-oblique', empty);
  const now = await Promise.all(slices.map(pixelsOf));
  slices.forEach((name, k) => assert.notDeepEqual(now[k], before[k], name));
  await byId('slice-oblique').scrollIntoViewIfNeeded();
  await shoot(page, 'slices_oblique');
});

test('its line is right after other volumes while the slices were hidden', async () => {
  const slices = ['slice-axial', 'slice-coronal', 'slice-sagittal'];
  const before = await Promise.all(slices.map(pixelsOf));
  await byId('tab-volume').click();
  for (const name of ['pelvis', 'sphere']) {
    await after(page, () => say(raw, `load phantom:${name}`),
                now => now.volume?.name.includes(name));
  }
  await byId('tab-slices').click();
  for (const [k, name] of slices.entries()) {
    const isAsBefore = async () => Buffer.compare(await pixelsOf(name), before[k]) === 0;
    for (let i = 0; i < 100 && !await isAsBefore(); i++);
    assert.ok(await isAsBefore(), name);
  }
});

test('the pointer tells an interpolated value, near the crosshair that of its voxel', async () => {
  const own = await crosshair();
  await byId('slice-oblique').scrollIntoViewIfNeeded();
  const at = await middleOf(byId('slice-oblique'));
  await page.mouse.move(at.x, at.y);
  await byId('slices-readout').getByText('interpolated').waitFor();
  const under = await told();
  // The middle of the volume is at most a voxel beside the crosshair, 0.01 mm of depth each.
  own.voxel.forEach((each, axis) => assert.ok(Math.abs(each - under.voxel[axis]) <= 1, under.text));
  assert.ok(Math.abs(under.value - own.value) <= 100 * 3, `${under.text}, ${own.text}`);
});

test('a click moves the crosshair within the plane', async () => {
  const { spacing_mm: spacing } = (await state(page)).volume;
  const before = await crosshair();
  await byId('slice-oblique').scrollIntoViewIfNeeded();
  const at = await middleOf(byId('slice-oblique'));
  await page.mouse.click(at.x + 30, at.y - 40);
  const now = await crosshair();
  const step = now.voxel.map((each, axis) => (each - before.voxel[axis]) * spacing[axis]);
  assert.ok(Math.hypot(...step) > 8, `${step} mm`);
  // Tilted by 45 degrees: towards posterior as far as towards inferior, but for two rounded voxels.
  const rounded = spacing[1] + spacing[2] + 1e-9;
  assert.ok(Math.abs(step[1] + step[2]) <= rounded, `${step} mm`);
  assert.ok(step[0] > 0 && step[1] < 0 && step[2] > 0, `left, anterior and superior: ${step} mm`);
});

test('the wheel moves the plane along its normal, angles turn it', async () => {
  const before = await crosshair();
  await byId('slice-oblique').scrollIntoViewIfNeeded();
  const at = await middleOf(byId('slice-oblique'));
  const first = await pixelsOf('slice-oblique');
  await page.mouse.move(at.x, at.y);
  await page.mouse.wheel(0, 2 * NOTCH);
  const second = await changed('slice-oblique', first);
  const now = await crosshair();
  assert.equal(now.voxel[0], before.voxel[0], 'tilted only');
  assert.ok(now.voxel[1] > before.voxel[1] && now.voxel[2] > before.voxel[2], now.text);
  await setAngle('turn', 30);
  assert.equal(await byId('oblique-turn-value').innerText(), '30°');
  await changed('slice-oblique', second);
});

test('the command oblique shows the same plane', async () => {
  // The pixels of the last volume are larger than its voxels: they would be more than 512.
  for (const line of ['load phantom:sphere', 'load phantom:letters',
    'load phantom:sphere resample=600x500x20']) {
    await after(page, () => say(raw, line));
    const { volume } = await state(page);
    for (const [tilt, turn] of [[30, -20], [-75, 66], [0, 0]]) {
      const { result } = await say(raw, `oblique ${tilt} ${turn} at=3,-8,5`);
      const plane = planeThrough(volume, { tilt, turn }, [3, -8, 5]);
      assert.deepEqual(result.size, [plane.width, plane.height]);
      for (const [told, own] of [[result.center_mm, plane.center_mm], [result.right, plane.right],
        [result.down, plane.down], [[result.pixel_mm], [plane.pixel_mm]]]) {
        told.forEach((each, k) => assert.ok(Math.abs(each - own[k]) < 1e-9, `${told}, ${own}`));
      }
    }
  }
  assert.equal((await say(raw, 'oblique 30 10')).result.size[0], 512);
});
