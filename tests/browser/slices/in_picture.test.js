// Slices in the picture: buttons, the crosshair, the window, a click, undo, other pages.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { after, canvasPixels, middleOf, rawSocket, say, settled, state, stateWhen }
  from '../steps.js';

let raw;

usePage(['phantom:pelvis'], async () => {
  raw = await rawSocket(page, server.url);
  for (const line of ['surface skin visible=no', 'surface bone visible=no', 'view superior']) {
    await after(page, () => say(raw, line));
  }
  await byId('tab-slices').click();
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
});

const pressed = () => Promise.all([0, 1, 2].map(async number =>
  await byId(`in-picture-${number}`).getAttribute('aria-pressed') === 'true'));

/** The slices of the state, as "z 24". */
const planes = async () => (await state(page)).planes.map(({ axis, index }) => `${axis} ${index}`);

/** Presses the button of a plane, and waits for the picture. */
const press = number => after(page, () => byId(`in-picture-${number}`).click());

/** The number of gray pixels of the picture that are no background. */
async function grayPixels() {
  const data = await canvasPixels(byId('frame'));
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    count += data[i] === data[i + 1] && data[i] === data[i + 2] ? 1 : 0;
  }
  return count;
}

test('a button shows the slice of the crosshair, and takes it away', async () => {
  const before = await settled(page), { volume } = await state(page);
  assert.deepEqual(await pressed(), [false, false, false]);
  const shown = await press(0);
  assert.deepEqual(await planes(), [`z ${Math.floor(volume.size[2] / 2)}`]);
  assert.deepEqual(await pressed(), [true, false, false]);
  assert.notEqual(shown.digest, before.digest);
  assert.ok(await grayPixels() > 1000);
  assert.equal((await press(0)).digest, before.digest);
  assert.deepEqual(await pressed(), [false, false, false]);
});

test('two buttons that are pressed at once show both slices', async () => {
  await after(page, () => page.evaluate(() => {
    for (const number of [1, 2]) {
      document.querySelector(`[data-testid=in-picture-${number}]`).click();
    }
  }), now => now.planes.length === 2);
  assert.deepEqual((await planes()).map(text => text[0]), ['x', 'y']);
  assert.deepEqual(await pressed(), [false, true, true]);
  await press(0);
  await after(page, () => say(raw, 'surface bone visible=yes'));
  await after(page, () => say(raw, 'view 30 20'));
  await shoot(page, 'slices-in-picture');
  await after(page, () => say(raw, 'surface bone visible=no'));
});

test('the slices follow the crosshair and the window', async () => {
  const [, , axial] = await planes();
  await after(page, () => byId('slice-index-0').press('ArrowRight'),
              (now, was) => `z ${now.planes[2].index}` !== was, axial);
  const [, , moved] = await planes();
  assert.equal(Number(moved.slice(2)), Number(await byId('slice-index-0').inputValue()));
  await after(page, async () => {
    await byId('slices-window').fill('1500');
    await byId('slices-window').press('Enter');
  }, now => now.planes_window === 1500);
  const { planes_level: level } = await state(page);
  assert.equal(level, Number(await byId('slices-level').inputValue()));
});

test('a click on a slice moves the crosshair there, and says which slice it is', async () => {
  await after(page, () => say(raw, 'view superior'));
  const told = page.evaluate(() => new Promise(resolve =>
    document.addEventListener('place', event => resolve(event.detail), { once: true })));
  const [before] = await planes();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.click(x + 25, y + 25);
  assert.equal((await told).from, 'picture');
  await byId('pointed').waitFor();
  assert.match(await byId('pointed').innerText(), /^Axial slice \d+ of \d+,? /);
  // The sagittal slice has followed.
  await stateWhen(page, (now, was) => `x ${now.planes[0].index}` !== was, before);
  const [sagittal] = await planes();
  assert.equal(sagittal, `x ${await byId('slice-index-2').inputValue()}`);
});

test('undo takes one button back; the buttons follow', async () => {
  await after(page, () => say(raw, 'planes off'), now => now.planes.length === 0);
  assert.deepEqual(await pressed(), [false, false, false]);
  await press(2);
  await after(page, () => byId('undo').click(), now => now.planes.length === 0);
  assert.deepEqual(await pressed(), [false, false, false]);
  // The same button sends the same line again.
  await press(2);
  assert.deepEqual(await pressed(), [false, false, true]);
});

test('another volume begins without slices in the picture', async () => {
  await after(page, () => say(raw, 'load phantom:head'), now => now.planes.length === 0);
  assert.deepEqual(await pressed(), [false, false, false]);
  await stateWhen(page, now => now.volume.source === 'phantom:head', null);
  await press(0);
  assert.equal((await planes()).length, 1);
});
