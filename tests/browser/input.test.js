// Input that must do what it says: one notch, one slice; one change, one step of undo; no lost key;
// two clicks, one meaning.
import assert from 'node:assert/strict';
import test from 'node:test';
import { holdMessages } from './holding.js';
import { browser, byId, openPage, page, server, usePage } from './harness.js';
import { after, drag, middleOf, settled, state, stateWhen, unfold } from './steps.js';

usePage();

const surfaceOf = (now, name) => now.surfaces.find(each => each.name === name);

test('one notch of the wheel is one slice, a touchpad moves in small steps', async () => {
  await byId('tab-slices').click();
  await byId('slice-count-0').getByText('/').waitFor();
  const at = await middleOf(byId('slice-axial'));
  await page.mouse.move(at.x, at.y);
  const index = async () => Number(await byId('slice-index-0').inputValue());
  const wheel = async (px, by) => {
    const was = await index();
    await page.mouse.wheel(0, px);
    await page.waitForFunction(was =>
      Number(document.querySelector('[data-testid=slice-index-0]').value) !== was, was);
    assert.equal(await index() - was, by, `a wheel by ${px} pixels`);
  };
  for (const px of [100, 120, 100, 120, 150]) await wheel(px, 1);
  await wheel(-100, -1);
  await wheel(-120, -1);
  await wheel(240, 2);  // Two notches that the browser has added up.
  const was = await index();
  for (let i = 0; i < 8; i++) await page.mouse.wheel(0, 10);
  await page.waitForFunction(was => Number(
    document.querySelector('[data-testid=slice-index-0]').value) === was + 2, was);
});

test('keys work after a color was chosen', async () => {
  const before = await state(page);
  const { color } = surfaceOf(before, 'bone');
  await after(page, () => byId('surface-color-bone').fill('#ff2020'),
              now => now.surfaces.some(each => each.color === '#ff2020'));
  await byId('surface-color-bone').focus();
  await page.keyboard.press('u');
  await stateWhen(page, (now, color) => now.surfaces.some(
    each => each.name === 'bone' && each.color === color), color);
});

test('undo takes opacity, visibility and light back one change at a time', async () => {
  await byId('choose-skin').click();
  const skin = (now, [key, value]) =>
    now.surfaces.find(({ name }) => name === 'skin')[key] === value;
  const set = (act, key, value) => after(page, act, skin, [key, value]);
  await set(() => byId('surface-opacity-skin').fill('0.75'), 'opacity', 0.75);
  await set(() => byId('surface-opacity-skin').fill('0.25'), 'opacity', 0.25);
  await set(() => byId('undo').click(), 'opacity', 0.75);
  // The slider keeps the focus, and follows all the same.
  await set(() => byId('surface-opacity-skin').fill('0.5'), 'opacity', 0.5);
  await set(() => page.keyboard.press('Control+z'), 'opacity', 0.75);
  assert.equal(await byId('surface-opacity-skin').inputValue(), '0.75');

  await set(() => byId('surface-visible-skin').uncheck(), 'visible', false);
  await set(() => byId('surface-visible-skin').check(), 'visible', true);
  await set(() => byId('undo').click(), 'visible', false);
  await set(() => byId('undo').click(), 'visible', true);

  await unfold(page);
  const glossy = (now, value) => now.material.specular === value;
  await after(page, () => byId('material-specular').fill('0.5'), glossy, 0.5);
  await after(page, () => byId('material-specular').fill('0.1'), glossy, 0.1);
  await after(page, () => byId('undo').click(), glossy, 0.5);
});

test('no step of an arrow key is lost between a reply and the state', async () => {
  const held = await openPage(browser, server.url, { script: holdMessages });
  const was = surfaceOf(await state(held.page), 'bone').isovalue;
  await held.page.getByTestId('handle-bone').focus();
  await held.page.evaluate(() => { globalThis.holds = 'state'; });
  for (let i = 0; i < 4; i++) {
    const replies = await held.page.evaluate(() => globalThis.replies);
    await held.page.keyboard.press('ArrowRight');
    await held.page.waitForFunction(was => globalThis.replies > was, replies);
  }
  await held.page.evaluate(() => globalThis.release());
  await stateWhen(held.page, (now, wanted) => now.surfaces.some(
    each => each.name === 'bone' && each.isovalue === wanted), was + 4);
  assert.equal(Number(await held.page.getByTestId('handle-bone').getAttribute('aria-valuenow')),
               was + 4);
  await held.close();
});

test('a double click resets the view and points at nothing, a click points', async () => {
  await settled(page);
  const at = await middleOf(byId('stage'));
  await page.evaluate(() => {
    globalThis.places = 0;
    document.addEventListener('place', () => { ++globalThis.places; });
  });
  await after(page, () => drag(page, at, { x: at.x + 60, y: at.y }));
  await after(page, () => page.mouse.dblclick(at.x, at.y - 30));
  await page.mouse.click(at.x + 4, at.y - 30);
  await byId('pointed').waitFor();
  assert.equal(await page.evaluate(() => globalThis.places), 1);
});

test('a click leaves no frame around the picture, a key shows it', async () => {
  const at = await middleOf(byId('stage'));
  await byId('stage').focus();
  await page.keyboard.press('ArrowRight');
  await page.mouse.click(at.x, at.y);
  const style = () => byId('stage').evaluate(each => getComputedStyle(each).outlineStyle);
  assert.equal(await style(), 'none');
  await page.keyboard.press('ArrowLeft');
  assert.notEqual(await style(), 'none');
});
