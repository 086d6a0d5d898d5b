// Ctrl+Z and the buttons undo scene and measurements in their order, in the page with its server.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, usePage } from '../harness.js';
import { middleOf, settled, state, stateWhen } from '../steps.js';

usePage(undefined, async () => {
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
  await byId('choice-measure').click();
});

const count = number => page.waitForFunction(number => document.querySelectorAll(
  '[data-testid=measure-list] > li').length === number, number);
const title = async way => (await byId(way).getAttribute('title')).replace(/ \(key.*/, '');

async function setBone(value) {
  await byId('iso-bone').fill(String(value));
  await byId('iso-bone').press('Enter');
  await boneIs(value);
}

async function boneIs(value) {
  await stateWhen(page, (now, value) => now.surfaces.some(
    ({ name, isovalue }) => name === 'bone' && isovalue === value), value);
}

test('undo and redo follow the order of changes in scene and measurements', async () => {
  const [{ isovalue: first }] = (await state(page)).surfaces;
  const { step } = await state(page);
  await setBone(300.5);
  const at = await middleOf(byId('slice-axial'));
  for (const x of [-30, 30]) await page.mouse.click(at.x + x, at.y);
  await count(1);
  // The same setting: without the measurement between, both would be one step.
  await setBone(350.5);
  assert.equal((await state(page)).step, step + 2);
  await byId('tab-measure').click();
  await byId('measure-delete-1').click();
  await count(0);
  assert.equal(await title('undo'), 'Undo: delete measurement 1');
  await page.keyboard.press('Control+z');
  await count(1);
  assert.equal((await state(page)).step, step + 2, 'the scene is as before');
  await page.keyboard.press('Control+z');
  await boneIs(300.5);
  await count(1);
  assert.match(await title('undo'), /^Undo: add distance 1/);
  await byId('undo').click();
  await count(0);
  await byId('undo').click();
  await boneIs(first);
  for (const check of [() => boneIs(300.5), () => count(1), () => boneIs(350.5),
                       () => count(0)]) {
    await page.keyboard.press('Control+y');
    await check();
  }
  assert.equal(await title('redo'), 'Nothing to redo');
  assert.ok(await byId('redo').isDisabled());
});

test('undo pressed fast goes back through everything, and redo returns', async () => {
  await setBone(280.5);
  const { step } = await state(page);
  await byId('tab-slices').click();
  const at = await middleOf(byId('slice-axial'));
  for (const x of [-30, 30]) await page.mouse.click(at.x + x, at.y + 20);
  await count(1);
  await setBone(290.5);
  await setBone(310.5);
  assert.equal(await title('undo'), 'Undo: surface bone iso=310.5');
  await byId('stage').focus();
  const presses = (await state(page)).step - step + 2;
  for (let press = 0; press < presses; press++) await page.keyboard.press('u');
  await count(0);
  await stateWhen(page, (now, step) => now.step === step - 1, step);
  for (let press = 0; press < presses; press++) await page.keyboard.press('U');
  await count(1);
  await boneIs(310.5);
});
