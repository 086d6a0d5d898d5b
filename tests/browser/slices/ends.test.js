// Ends of measurements are moved by a pointer and by keys, in slices and in the picture. A moved
// measurement has the numbers of a new one at the same points.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { drag, middleOf, settled, state } from '../steps.js';

usePage(undefined, async () => {
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
  await byId('choice-measure').click();
});
test.afterEach(async () => {
  await byId('tab-measure').click();
  if (await byId('measure-list').locator('li').count() > 0) {
    await byId('measure-delete-all').click();
  }
  await page.keyboard.press('Escape');
  await byId('tab-slices').click();
});

const listed = () => byId('measure-list').locator('b').allTextContents();
const count = async number => {
  await page.waitForFunction(number => document.querySelectorAll(
    '[data-testid=measure-list] > li').length === number, number);
};

/** The measurements as the page saves them, without their names. */
async function saved() {
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    byId('measure-json').evaluate(button => button.click())]);
  const { measurements } = JSON.parse(await readFile(await download.path(), 'utf8'));
  return measurements.map(({ name, ...measure }) => measure);
}

/** A place of the axial slice, CSS pixels from its middle. */
async function inSlice([x, y]) {
  const at = await middleOf(byId('slice-axial'));
  return { x: at.x + x, y: at.y + y };
}

async function clickSlice(...places) {
  for (const place of places) {
    const { x, y } = await inSlice(place);
    await page.mouse.click(x, y);
  }
}

async function dragSlice(from, to) {
  await drag(page, await inSlice(from), await inSlice(to));
}

test('an end that is dragged in a slice gives the numbers of a new measurement', async () => {
  for (const [kind, places, end, to] of [
    ['distance', [[-40, 10], [40, 10]], 1, [25, -30]],
    ['angle', [[50, 0], [0, 0], [0, -50]], 1, [-30, 25]]]) {
    await byId('slices-kind').selectOption(kind);
    await clickSlice(...places);
    const before = await listed();
    await page.mouse.move(...Object.values(await inSlice(places[end])));
    await page.mouse.down();
    await page.mouse.move(...Object.values(await inSlice([to[0] + 9, to[1]])), { steps: 4 });
    const during = await listed();
    assert.notDeepEqual(during, before, 'the value follows the pointer');
    await page.mouse.move(...Object.values(await inSlice(to)));
    await page.mouse.up();
    assert.notDeepEqual(await listed(), during);
    await clickSlice(...places.map((place, k) => k === end ? to : place));
    const [moved, fresh] = (await saved()).slice(-2);
    assert.equal(moved.kind, kind);
    assert.deepEqual(moved, fresh);
  }
  await count(4);
});

test('each corner of a region can be dragged', async () => {
  await byId('slices-kind').selectOption('ellipse');
  await dragSlice([-30, -20], [20, 25]);
  await dragSlice([20, -20], [35, -35]);     // A corner that the user never pressed.
  await dragSlice([-30, 25], [-25, 10]);     // The opposite one.
  await dragSlice([-25, -35], [-20, -30]);   // The first one.
  await byId('slices-kind').selectOption('ellipse');
  await count(1);
  const [moved] = await saved();
  await byId('measure-delete-all').evaluate(button => button.click());
  await dragSlice([-20, -30], [35, 10]);
  const [fresh] = await saved();
  assert.ok(fresh.values.voxels > 20);
  assert.deepEqual(moved.values, fresh.values);
  for (const key of ['slice', 'kind']) assert.deepEqual(moved[key], fresh[key]);
  assert.ok(Math.abs(moved.value - fresh.value) < 1e-6 * fresh.value);
});

test('Esc puts a dragged end back', async () => {
  await byId('slices-kind').selectOption('distance');
  await clickSlice([-40, 10], [40, 10]);
  const before = await saved();
  await page.mouse.move(...Object.values(await inSlice([40, 10])));
  await page.mouse.down();
  await page.mouse.move(...Object.values(await inSlice([10, 40])), { steps: 3 });
  assert.notDeepEqual(await saved(), before);
  await byId('slice-axial').focus();
  await page.keyboard.press('Escape');
  await page.mouse.move(...Object.values(await inSlice([15, 45])));
  await page.mouse.up();
  assert.deepEqual(await saved(), before);
});

test('keys move an end in a slice by a voxel, with Shift by ten', async () => {
  await byId('slices-kind').selectOption('distance');
  await clickSlice([-30, 10], [10, 10]);
  const [before] = await saved();
  await byId('slices-list').getByRole('button', { name: /^Measurement/ }).click();
  await page.keyboard.press('Tab');    // Delete.
  await page.keyboard.press('Tab');    // Its name.
  await page.keyboard.press('Tab');
  await page.keyboard.press('Tab');
  const focused = await page.evaluate(() => document.activeElement.getAttribute('aria-label'));
  assert.match(focused, /^Last end of measurement/);
  for (const key of ['ArrowRight', 'Shift+ArrowRight', 'ArrowUp']) {
    await byId('slices-readout').getByText('crosshair').waitFor();
    await page.keyboard.press(key);
  }
  const [{ points_mm: [still, moved], value }] = await saved();
  const { spacing_mm } = (await state(page)).volume;
  assert.deepEqual(still, before.points_mm[0]);
  const by = moved.map((mm, axis) => Math.abs(mm - before.points_mm[1][axis]));
  for (const [axis, voxels] of [11, 1, 0].entries()) {
    assert.ok(Math.abs(by[axis] - voxels * spacing_mm[axis]) < 1e-3, `${by}, ${spacing_mm}`);
  }
  assert.ok(Math.abs(value - Math.hypot(...moved.map((mm, k) => mm - still[k]))) < 1e-9);
  await shoot(page, 'ends_slices');
});

/** The place on the screen of a pixel of the picture. */
async function ofPixel([x, y]) {
  const [width, height] = (await state(page)).size;
  const box = await byId('frame').boundingBox();
  return [box.x + (x + 0.5) / width * box.width, box.y + (y + 0.5) / height * box.height];
}

/** Pixels of the picture from shares of its size. */
async function pixels(...shares) {
  const [width, height] = (await state(page)).size;
  return shares.map(([x, y]) => [Math.floor(x * width), Math.floor(y * height)]);
}

async function clickPixels(...places) {
  for (const place of places) await page.mouse.click(...await ofPixel(place));
}

test('an end that is dropped on the picture lies on the surface there', async () => {
  await byId('tab-measure').click();
  await byId('choice-distance').click();
  await byId('measure-mode').click();
  const [a, b, to, beside] = await pixels([0.44, 0.4], [0.56, 0.42], [0.5, 0.35], [0.02, 0.02]);
  await clickPixels(a, b);
  await count(1);
  const camera = (await state(page)).camera;
  const [before] = await listed();
  await page.mouse.move(...await ofPixel(b));
  await page.mouse.down();
  await page.mouse.move(...await ofPixel(to), { steps: 5 });
  await page.mouse.up();
  await byId('measure-list').locator('b').filter({ hasNotText: before }).waitFor();
  await clickPixels(a, to);
  await count(2);
  const [moved, fresh] = await saved();
  assert.deepEqual(moved, fresh);
  await drag(page, ...(await Promise.all([ofPixel(to), ofPixel(beside)]))
    .map(([x, y]) => ({ x, y })));
  await byId('measure-message').getByText(/no surface.*back in its place/).waitFor();
  assert.deepEqual(await saved(), [moved, fresh]);
  assert.deepEqual((await state(page)).camera, camera, 'no drag turned the picture');
});

/** Waits until the last end of the first measurement is drawn at a pixel. */
async function endIsAt(pixel) {
  const [x, y] = await ofPixel(pixel);
  await page.waitForFunction(([x, y]) => {
    const circle = document.querySelector('[data-testid=measure-lines] circle:nth-of-type(2)');
    const box = circle?.getBoundingClientRect();
    return box && Math.hypot(box.x + box.width / 2 - x, box.y + box.height / 2 - y) < 0.3;
  }, [x, y]);
}

test('keys move an end in the picture by a pixel, with Shift by ten, on the surface', async () => {
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const [a, b] = await pixels([0.44, 0.4], [0.54, 0.42]);
  await clickPixels(a, b);
  await count(1);
  await byId('measure-list').getByRole('button', { name: /^Measurement/ }).click();
  await byId('measure-end-1').focus();
  for (const key of ['ArrowLeft', 'Shift+ArrowUp', 'ArrowUp']) await page.keyboard.press(key);
  await endIsAt([b[0] - 1, b[1] - 11]);
  await clickPixels(a, [b[0] - 1, b[1] - 11]);
  await count(2);
  const [moved, fresh] = await saved();
  assert.deepEqual(moved, fresh);
  await shoot(page, 'ends_picture');
});

test('a finger grabs an end from 20 pixels away, a mouse does not', async () => {
  const touch = await openPage(browser, server.url, { hasTouch: true });
  const at = id => touch.page.getByTestId(id);
  await at('slices-readout').getByText('crosshair').waitFor();
  await at('choice-measure').click();
  const middle = await middleOf(at('slice-axial'));
  for (const x of [-30, 30]) await touch.page.mouse.click(middle.x + x, middle.y);
  const value = () => at('slices-list').locator('b').textContent();
  const before = await value();
  const [from, to] = [[48, 10], [60, 10]].map(([x, y]) => ({ x: middle.x + x, y: middle.y + y }));
  await drag(touch.page, from, to);
  assert.equal(await value(), before);
  await touch.page.keyboard.press('Escape');
  const session = await touch.context.newCDPSession(touch.page);
  const send = (type, ...touchPoints) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  await send('touchStart', from);
  for (const x of [4, 8, 12]) await send('touchMove', { x: from.x + x, y: from.y });
  await send('touchEnd');
  assert.ok(Number.parseFloat(await value()) > Number.parseFloat(before));
  await touch.close();
});
