// Measuring in slices and in the picture: angles, paths, regions, and the files of them.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import test from 'node:test';
import { byId, page, shoot, usePage } from '../harness.js';
import { drag, middleOf, settled, state } from '../steps.js';

const last = () => byId('measure-list').locator('li').last();
/** The values of all measurements, in the words of the list. */
const listed = () => byId('measure-list').locator('b').allTextContents();

usePage(undefined, async () => {
  await byId('tab-slices').click();
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
  await byId('choice-measure').click();
});

/** Clicks places of the axial slice, CSS pixels from its middle. */
async function click(...places) {
  const at = await middleOf(byId('slice-axial'));
  for (const [x, y] of places) await page.mouse.click(at.x + x, at.y + y);
}

async function number(text) {
  return Number.parseFloat((await text).replaceAll(',', ''));
}

/** How many pixels of the axial slice have the color of measurements. */
async function marked() {
  await page.evaluate(() => new Promise(done =>
    requestAnimationFrame(() => requestAnimationFrame(done))));
  return byId('slice-axial').evaluate(canvas => {
    const color = getComputedStyle(canvas).getPropertyValue('--over-warn').trim();
    const rgb = [1, 3, 5].map(at => parseInt(color.slice(at, at + 2), 16));
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      count += rgb.every((part, k) => Math.abs(data[i + k] - part) < 20) ? 1 : 0;
    }
    return count;
  });
}

test('three clicks in a slice are an angle', async () => {
  await byId('slices-kind').selectOption('angle');
  await click([50, 0], [0, 0], [0, -50]);
  await byId('slices-message').getByText('90.0°').waitFor();
  await click([50, 0], [0, 0], [50, -50]);
  await byId('slices-message').getByText('45.0°').waitFor();
  assert.deepEqual(await listed(), ['90.0°', '45.0°']);
  assert.ok(await marked() > 50);
});

test('a path is as long as its lines', async () => {
  await byId('slices-kind').selectOption('distance');
  await click([-40, 10], [40, 10]);
  await byId('slices-message').getByText(' mm. ').waitFor();
  const straight = await number(last().locator('b').textContent());
  await byId('slices-kind').selectOption('path');
  assert.ok(await byId('slices-path-done').isDisabled());
  await click([-40, 10], [40, 10], [-40, 10]);
  await byId('slices-message').getByText('so far').waitFor();
  await byId('slices-path-done').click();
  await last().getByText('path').waitFor({ state: 'attached' });
  const there = await number(last().locator('b').textContent());
  assert.ok(Math.abs(there - 2 * straight) <= 1.5, `${there} mm there and back, ${straight} mm`);
});

test('an unfinished angle is no path', async () => {
  const before = await listed();
  await byId('slices-kind').selectOption('angle');
  await click([0, 0], [20, 0]);
  await byId('slices-kind').selectOption('path');
  assert.deepEqual(await listed(), before);
});

test('a region of air has the value of air, and only its own slice shows it', async () => {
  await byId('slices-kind').selectOption('rectangle');
  const bare = await marked();
  const box = await byId('slice-axial').boundingBox();
  const { size, minimum, spacing_mm } = (await state(page)).volume;
  const perPixel = size[1] * spacing_mm[1] / box.height;
  const corner = { x: box.x + box.width / 2 - size[0] * spacing_mm[0] / perPixel / 2 + 3,
                   y: box.y + 3 };
  await drag(page, corner, { x: corner.x + 20, y: corner.y + 10 });
  await byId('slices-message').getByText('voxels').waitFor();
  const [, mean, deviation] = (await byId('slices-message').innerText()).replaceAll(/,(?=\d)/g, '')
    .match(/mean (-?[\d.]+), deviation ([\d.]+)/).map(Number);
  assert.ok(mean >= minimum && mean < minimum + 40 && deviation < 30, `${mean} ± ${deviation}`);
  const area = await number(last().locator('b').textContent());
  const expected = 20 * 10 * perPixel ** 2;
  assert.ok(Math.abs(area - expected) < 0.02 * expected, `${area} mm², expected ${expected}`);
  const withMark = await marked();
  assert.ok(withMark > bare, `${withMark} pixels, ${bare} before`);
  await byId('slice-axial').focus();
  await page.keyboard.press(']');
  await byId('slice-count-0').getByText(`${Math.floor(size[2] / 2) + 2} /`).waitFor();
  assert.equal(await marked(), 0);
  await page.keyboard.press('[');
  await byId('slice-count-0').getByText(`${Math.floor(size[2] / 2) + 1} /`).waitFor();
  assert.equal(await marked(), withMark);
  await byId('slices-kind').selectOption('ellipse');
  const at = await middleOf(byId('slice-axial'));
  await drag(page, { x: at.x - 25, y: at.y - 20 }, { x: at.x + 25, y: at.y + 20 });
  await byId('slices-message').getByText('voxels').waitFor();
  await shoot(page, 'slices_measured');
});

test('angles and paths on the surface; Enter ends a path, Esc keeps it', async () => {
  await byId('tab-measure').click();
  const count = (await listed()).length;
  const stage = await byId('stage').boundingBox();
  const clickPicture = async (...places) => {
    for (const [x, y] of places) {
      await page.mouse.click(stage.x + x * stage.width, stage.y + y * stage.height);
    }
  };
  await byId('choice-angle').click();
  await byId('measure-mode').click();
  await clickPicture([0.44, 0.4], [0.5, 0.42]);
  await byId('measure-message').getByText('third').waitFor();
  await clickPicture([0.56, 0.4]);
  await last().getByText('angle', { exact: true }).waitFor();
  assert.match(await last().locator('b').textContent(), /^\d+\.\d°$/);
  await byId('choice-path').click();
  for (const key of ['Enter', 'Escape']) {
    const before = (await listed()).length;
    if (key === 'Escape') await byId('measure-mode').click();
    await clickPicture([0.44, 0.4], [0.5, 0.42]);
    await byId('measure-message').getByText('so far').waitFor();
    await byId('measure-done').waitFor();
    await page.keyboard.press(key);
    if (key === 'Enter') await page.keyboard.press('Escape');
    await byId('measure-list').locator('li').nth(before).waitFor();
  }
  assert.equal((await listed()).length, count + 3);
  assert.ok(await byId('measure-lines').locator('line').count() >= 8);
  await shoot(page, 'measured');
});

test('Enter waits for the points of all clicks, and the next path begins anew', async () => {
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const stage = await byId('stage').boundingBox();
  const before = (await listed()).length;
  for (const x of [0.44, 0.5, 0.56]) {
    await page.mouse.click(stage.x + x * stage.width, stage.y + 0.41 * stage.height);
  }
  await page.keyboard.press('Enter');
  await byId('measure-list').locator('li').nth(before).waitFor();
  await page.keyboard.press('Escape');
  await byId('measure-message').filter({ hasText: /^$/ }).waitFor({ state: 'attached' });
  const [download] = await Promise.all([page.waitForEvent('download'),
                                        byId('measure-json').click()]);
  const { measurements } = JSON.parse(await readFile(await download.path(), 'utf8'));
  assert.equal(measurements.length, before + 1);
  assert.equal(measurements.at(-1).points_mm.length, 3);
});

test('with keys: Enter sets corners at the crosshair, Esc ends a path', async () => {
  await byId('tab-slices').click();
  await byId('slices-kind').selectOption('path');
  await byId('slice-axial').focus();
  const before = (await listed()).length;
  await page.keyboard.press('Enter');
  for (let i = 0; i < 5; i++) await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Enter');
  await page.keyboard.press('Escape');
  await byId('measure-list').locator('li').nth(before).waitFor({ state: 'attached' });
  const { spacing_mm } = (await state(page)).volume;
  const path = await number(last().locator('b').textContent());
  assert.ok(Math.abs(path - 5 * spacing_mm[0]) < 0.06, `${path} mm`);
  await byId('slices-kind').selectOption('rectangle');
  await byId('slice-axial').focus();
  await page.keyboard.press('Enter');
  for (const key of ['ArrowLeft', 'ArrowDown']) {
    for (let i = 0; i < 4; i++) await page.keyboard.press(key);
  }
  await page.keyboard.press('Enter');
  await byId('slices-message').getByText('25 voxels').waitFor();
});

test('a region reaches the edge of the slice, however fast the pointer leaves it', async () => {
  await byId('tab-measure').click();
  await byId('measure-delete-all').click();  // Else the pointer would grab an end in the middle.
  await byId('tab-slices').click();
  await byId('slices-kind').selectOption('rectangle');
  const at = await middleOf(byId('slice-axial'));
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x + 1500, at.y - 1500);
  await page.mouse.up();
  const { size } = (await state(page)).volume;
  const text = await byId('slices-message').innerText();
  const voxels = Number(text.match(/([\d,]+) voxels/)[1].replaceAll(',', ''));
  const quarter = size[0] * size[1] / 4;
  assert.ok(Math.abs(voxels - quarter) < 0.1 * quarter, `${voxels} voxels, ${quarter}`);
});

test('the files have all measurements', async () => {
  await byId('tab-measure').click();
  const names = await byId('measure-list').locator('.badge').allTextContents();
  const saved = async suffix => {
    const [download] = await Promise.all([page.waitForEvent('download'),
                                          byId(`measure-${suffix}`).click()]);
    assert.equal(download.suggestedFilename(), `measurements.${suffix}`);
    return readFile(await download.path(), 'utf8');
  };
  const lines = (await saved('csv')).trim().split('\r\n').map(line => line.split(','));
  assert.deepEqual(lines.slice(1).map(line => line[1]), names);
  const { volume, measurements } = JSON.parse(await saved('json'));
  assert.equal(volume, (await state(page)).volume.name);
  assert.deepEqual(measurements.map(({ name }) => name), names);
  const told = await listed();
  for (const [index, { kind, value }] of measurements.entries()) {
    assert.equal(Number(lines[index + 1][3]), value);
    assert.equal(lines[index + 1][2], kind);
    const shown = await number(told[index]);
    assert.ok(Math.abs(shown - value) <= 0.5, `${told[index]}: ${value}`);
  }
});
