// A time series: the strip below the picture plays and steps, and slices and measurements follow.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, middleOf, rawSocket, say, settled, state, stateWhen } from '../steps.js';

const FRAMES = 30;

let raw;

usePage(['phantom:heart'], async () => {
  raw = await rawSocket(page, server.url);
});

const frameIs = (now, frame) => now.volume?.frame === frame;

/** Does something and waits until the volume is shown at rest. */
async function shows(frame, act) {
  await act();
  await stateWhen(page, frameIs, frame);
  return settled(page);
}

/** The gray values of a slice's canvas, as a number that differs between pictures. */
const sliceHash = () => byId('slice-axial').evaluate(canvas => {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return data.reduce((hash, value) => (Math.imul(hash, 31) + value) | 0, 7);
});

test('the strip tells volume and time, and shows the volume that is chosen', async () => {
  assert.equal(await byId('cine-number').innerText(), `1 / ${FRAMES}`);
  assert.equal(await byId('cine-when').innerText(), '0 ms');
  const first = await settled(page);
  const thirteenth = await shows(13, () => byId('cine-slider').fill('13'));
  assert.equal(await byId('cine-number').innerText(), `13 / ${FRAMES}`);
  assert.equal(await byId('cine-when').innerText(), '360 ms');
  assert.notEqual(thirteenth.digest, first.digest);
  assert.equal((await shows(14, () => byId('cine-on').click())).revision,
               (await state(page)).revision);
  assert.equal((await shows(13, () => byId('cine-back').click())).digest, thirteenth.digest);
  assert.equal((await shows(1, () => byId('undo').click())).digest, first.digest);
  await shows(FRAMES, () => byId('cine-back').click());
  await shows(1, () => byId('cine-on').click());
  await shoot(page, 'cine');
});

test('it plays each volume once, in order, and stops where it ends', async () => {
  await byId('cine-loop').uncheck();
  await byId('cine-rate').selectOption('fast');
  const before = (await settled(page)).frames;
  const uploads = () => page.evaluate(() => globalThis.pxpl5.warp.uploads);
  const uploadsBefore = await uploads();
  await byId('cine-number').evaluate(number => {
    globalThis.told = [];
    new MutationObserver(() => globalThis.told.push(number.textContent))
      .observe(number, { childList: true, characterData: true, subtree: true });
  });
  await shows(FRAMES, () => byId('cine-play').click());
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=cine-play]').title === 'Play');
  const told = await page.evaluate(() => globalThis.told);
  assert.deepEqual(told, Array.from({ length: FRAMES - 1 }, (_, k) => `${k + 2} / ${FRAMES}`));
  const { frames } = await settled(page);
  assert.ok(frames - before >= FRAMES - 1, `${frames - before} pictures`);
  assert.ok(await uploads() > uploadsBefore, 'WebGL does not have the picture at rest');
  await shows(1, () => byId('undo').click());
});

test('it goes on at the first volume, until a mode needs one picture', async () => {
  await byId('cine-loop').check();
  await shows(29, () => byId('cine-slider').fill('29'));
  await byId('cine-play').click();
  await stateWhen(page, now => now.volume.frame < 20);
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=cine-play]').title === 'Play');
  await settled(page);  // One volume may have been on its way already.
  const { volume } = await state(page);
  const { state: later } = await after(page, () => say(raw, 'view 30 5'));
  assert.equal(later.volume.frame, volume.frame);
  await page.keyboard.press('Escape');
});

test('slices show the volume, at the same place and with the same window', async () => {
  await shows(1, () => say(raw, 'time 1'));
  await byId('tab-slices').click();
  await byId('slice-index-0').fill('20');
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=slice-count-0]').textContent.startsWith('21 /'));
  const first = await sliceHash();
  await shows(13, () => byId('cine-slider').fill('13'));
  await page.waitForFunction(new Function('was', `
    const canvas = document.querySelector('[data-testid=slice-axial]');
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((hash, value) => (Math.imul(hash, 31) + value) | 0, 7) !== was;`), first);
  assert.match(await byId('slice-count-0').innerText(), /^21 \//);
});

test('slices keep up while it plays', async () => {
  await shows(1, () => say(raw, 'time 1'));
  await byId('choice-slices').click();
  await byId('cine-rate').selectOption('fast');
  await byId('cine-loop').uncheck();
  await byId('slice-axial').evaluate(canvas => {
    globalThis.axial = new Set();
    document.addEventListener('sliceshown', () => requestAnimationFrame(() => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      globalThis.axial.add(data.reduce((hash, value) => (Math.imul(hash, 31) + value) | 0, 7));
    }));
  });
  await byId('cine-play').click();
  await stateWhen(page, frameIs, FRAMES);
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=cine-play]').title === 'Play');
  const seen = await page.evaluate(() => globalThis.axial.size);
  assert.ok(seen > 12, `${seen} different slices`);  // Some volumes are alike.
  await byId('choice-picture').click();
  await settled(page);
});

test('a measurement belongs to the volume that it was made in', async () => {
  await shows(1, () => say(raw, 'time 1'));
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const middle = await middleOf(byId('stage'));
  await page.mouse.click(middle.x - 30, middle.y);
  await page.mouse.click(middle.x + 30, middle.y);
  await page.keyboard.press('Escape');
  const list = byId('measure-list').locator('li');
  await list.first().waitFor();
  const drawn = byId('measure-lines').locator('line');
  assert.ok(await drawn.count() > 0, 'the distance is drawn');
  await shows(13, () => byId('cine-slider').fill('13'));
  await list.getByText('of volume 1').waitFor();
  await drawn.first().waitFor({ state: 'detached' });
  await shows(1, () => byId('measure-choose-1').click());
  await drawn.first().waitFor({ state: 'attached' });
});

test('a view-only page follows, and cannot play', async () => {
  const watcher = await openPage(browser, server.watchUrl);
  await shows(5, () => say(raw, 'time 5'));
  await watcher.page.getByTestId('cine-number').getByText(`5 / ${FRAMES}`).waitFor();
  for (const id of ['cine-play', 'cine-slider', 'cine-on', 'cine-rate']) {
    assert.ok(await watcher.page.getByTestId(id).isDisabled(), id);
  }
  await watcher.close();
});

test('a single volume has no strip', async () => {
  await after(page, () => say(raw, 'load phantom:sphere'));
  await byId('cine').waitFor({ state: 'hidden' });
});
