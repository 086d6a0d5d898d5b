// Slabs in the slices: the mean, the maximum or the minimum of several slices.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { after, rawSocket, say, settled, state } from '../steps.js';

let raw;

usePage(undefined, async () => {
  raw = await rawSocket(page, server.url);
  await byId('tab-slices').click();
  await settled(page);
  await byId('slice-settings').locator('summary').click();
  await after(page, () => say(raw, 'load phantom:sphere'),
              now => now.volume?.name.includes('sphere'));
  await byId('slice-lines').selectOption('off');
  await byId('slices-readout').getByText('crosshair').waitFor();
});

/** Sets a slab of all slices, and waits until the readout tells it. */
async function slab(mm, kind) {
  await byId('slab-kind').selectOption(kind);
  await byId('slab-mm').fill(String(mm));
  await byId('slab-mm').press('Enter');
}

/** Without commas between thousands. */
const readout = async () => (await byId('slices-readout').innerText())
  .replaceAll(/(\d),(?=\d{3})/g, '$1');

/** A line of the readout: the number of slices, and the value. */
async function told(plane, words) {
  await byId('slices-readout').getByText(`${plane}, ${words}`).waitFor();
  const found = new RegExp(`${plane}, ${words} of (\\d+) slices?: (\\S+)`).exec(await readout());
  assert.ok(found, await readout());
  return { slices: Number(found[1]), value: Number(found[2]) };
}

/** The axial slice as PNG. The crosshair of all slices stands at the same place. */
const picture = () => byId('slice-axial').evaluate(canvas => new Promise(done =>
  requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL())))));

async function axialSlice(index) {
  const count = (await state(page)).volume.size[2];
  await byId('slice-index-0').fill(String(index));
  await byId('slice-count-0').getByText(`${index + 1} / ${count}`).waitFor();
}

test('the values of slabs at the crosshair stand below the value of the voxel', async () => {
  const { size } = (await state(page)).volume;
  const own = Number.parseFloat(await readout());
  assert.ok(own > 2800, `the middle of a sphere of 30 mm in 0.01 mm of depth: ${own}`);
  await slab(1000, 'max');
  const most = await told('Axial', 'maximum');
  assert.equal(most.slices, size[2]);
  assert.ok(most.value >= own && most.value <= 3000, `${most.value}`);
  await slab(1000, 'min');
  const least = await told('Coronal', 'minimum');
  assert.equal(least.slices, size[1]);
  assert.ok(least.value < 0, `outside of the sphere: ${least.value}`);
  await slab(1000, 'mean');
  const mean = await told('Sagittal', 'mean');
  assert.ok(mean.value > least.value && mean.value < own, `${mean.value}`);
  assert.equal(Number.parseFloat(await readout()), own, 'the voxel keeps its own value');
});

test('the maximum of all slices is the same picture from every slice', async () => {
  const middle = Math.floor((await state(page)).volume.size[2] / 2);
  await slab(0, 'max');
  await axialSlice(2);
  const [edge, single] = [await picture(), (await readout()).includes('maximum')];
  assert.ok(!single, 'a single slice is no slab');
  await slab(1000, 'max');
  await told('Axial', 'maximum');
  const all = await picture();
  assert.notEqual(all, edge);
  await axialSlice(middle);
  await told('Axial', 'maximum');
  assert.equal(await picture(), all);
  await shoot(page, 'slices_slab');
});

test('each slice may have a slab of its own', async () => {
  await slab(0, 'max');
  await byId('slab-plane').selectOption('sagittal');
  await slab(6, 'mean');
  await told('Sagittal', 'mean');
  assert.ok(!(await readout()).includes('Axial'), await readout());
  await byId('slab-plane').selectOption('axial');
  assert.equal(await byId('slab-mm').inputValue(), '0');
  await byId('slab-plane').selectOption('all slices');
  await slab(-5, 'max');
  assert.equal(await byId('slab-mm').inputValue(), '0');
});
