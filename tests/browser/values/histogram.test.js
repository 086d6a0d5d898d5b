// The histogram: the values that it shows, and the bands of tissues.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { movedBy, zoomedAt } from '../../../host/serve/page/surfaces/zoom.js';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { after, drag, middleOf, settled, state, stateWhen } from '../steps.js';
import { writeEllipsoid } from '../volumes.js';

usePage();

const ALL = { low: -1000, high: 3000 };

test('zooming keeps the place of a value, and stops at the ends and at the narrowest', () => {
  assert.deepEqual(zoomedAt(ALL, ALL, 2, 0, 100), { low: -500, high: 1500 });
  assert.deepEqual(zoomedAt({ low: -500, high: 1500 }, ALL, 2, 0, 100),
                   { low: -250, high: 750 });
  assert.deepEqual(zoomedAt({ low: -250, high: 750 }, ALL, 0.25, 0, 100), ALL);
  assert.deepEqual(zoomedAt({ low: 0, high: 150 }, ALL, 2, 75, 100), { low: 25, high: 125 });
  assert.deepEqual(zoomedAt({ low: -1000, high: -500 }, ALL, 0.5, -500, 100),
                   { low: -1000, high: 0 });
  assert.deepEqual(movedBy({ low: 0, high: 1000 }, ALL, 500), { low: 500, high: 1500 });
  assert.deepEqual(movedBy({ low: 0, high: 1000 }, ALL, 5000), { low: 2000, high: 3000 });
  assert.deepEqual(movedBy(ALL, ALL, 5), ALL);
});

/** The values of the axis' labels, and the place of a handle, CSS pixels from the left. */
const shown = () => page.evaluate(() => {
  const svg = document.querySelector('#histogram');
  const labels = [...svg.querySelectorAll('.axis text')].map(each =>
    Number(each.textContent.replace(',', '').replace('−', '-')));
  const handle = svg.querySelector('[data-testid="handle-bone"]');
  const x = Number(/translate\(([-\d.]+)/.exec(handle.getAttribute('transform'))[1]);
  const beyond = handle.querySelector('.beyond').getAttribute('visibility') === 'visible';
  return { first: labels[0], last: labels.at(-1), x, beyond, width: svg.clientWidth,
           path: svg.querySelector('.area').getAttribute('d') };
});
/** The value at a place of the window, by the labels of the axis. */
const valueAt = x => page.evaluate(x => {
  const [a, b] = [...document.querySelectorAll('#histogram .axis text')].map(each => {
    const box = each.getBoundingClientRect();
    return { x: box.left + box.width / 2, value: Number(each.textContent.replace(',', '')) };
  });
  return a.value + (x - a.x) / (b.x - a.x) * (b.value - a.value);
}, x);
const isovalue = async () => (await state(page)).surfaces.find(each => each.name === 'bone')
  .isovalue;

test('the buttons show fewer values around the chosen surface, and all again', async () => {
  await settled(page);
  await byId('handle-bone').focus();
  const whole = await shown();
  assert.ok(await byId('values-all').isDisabled(), 'all values are shown');
  await byId('values-fewer').click();
  const half = await shown();
  assert.ok(Math.abs(half.x - half.width / 2) < 2, `the handle is in the middle: ${half.x}`);
  assert.equal(await page.locator('#histogram').evaluate(svg =>
    getComputedStyle(svg).cursor), 'grab');
  await byId('values-fewer').click();
  const part = await shown();
  assert.ok(part.last - part.first < (whole.last - whole.first) / 2,
            `${part.first} to ${part.last}`);
  assert.ok(part.first <= await isovalue() && await isovalue() <= part.last);
  assert.ok(Math.abs(part.x - part.width / 2) < 2, `the handle is in the middle: ${part.x}`);
  await byId('values-all').click();
  assert.deepEqual(await shown(), whole);
});

test('a handle moves by less where fewer values are shown', async () => {
  const moved = async () => {
    const was = await isovalue();
    const grip = await middleOf(byId('handle-bone').locator('.reach'));
    await after(page, () => drag(page, grip, { x: grip.x + 20, y: grip.y }));
    const is = await isovalue();
    await after(page, async () => {
      await byId('iso-bone').fill(String(was));
      await byId('iso-bone').press('Enter');
    });
    return is - was;
  };
  const whole = await moved();
  await byId('values-fewer').click();
  await byId('values-fewer').click();
  const part = await moved();
  assert.ok(Math.abs(part / whole - 0.25) < 0.05, `${whole} and ${part}`);
});

test('an empty place can be dragged, and a handle beyond the values points to them', async () => {
  const was = await shown(), value = await isovalue();
  const box = await byId('histogram').boundingBox();
  const y = box.y + box.height - 4;
  await drag(page, { x: box.x + 200, y }, { x: box.x + 20, y });
  const now = await shown();
  assert.ok(now.first > was.first, `${was.first}, ${now.first}`);
  assert.equal(await isovalue(), value, 'the surface stays');
  assert.ok(now.beyond, 'the isovalue is not shown any more');
  // More values around the shown ones, wherever the isovalue is.
  await byId('values-more').click();
  const more = await shown();
  assert.ok(more.first <= now.first && more.last >= now.last, JSON.stringify([now, more]));
  await byId('values-fewer').click();
  await byId('values-all').click();
  for (let k = 0; k < 3; ++k) await byId('values-fewer').click();
  await drag(page, { x: box.x + 220, y }, { x: box.x + 20, y });
  assert.ok((await shown()).beyond);
  // A key brings the values to the handle.
  await byId('handle-bone').focus();
  await after(page, () => page.keyboard.press('ArrowRight'));
  const followed = await shown();
  assert.ok(!followed.beyond && Math.abs(followed.x - followed.width / 2) < 2,
            JSON.stringify(followed));
});

test('Ctrl and the wheel zoom at the pointer; the wheel alone does not', async () => {
  await byId('values-all').click();
  const whole = await shown();
  const { x, y } = await middleOf(byId('histogram'));
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, -100);
  assert.deepEqual(await shown(), whole);
  const before = await valueAt(x);
  await page.keyboard.down('Control');
  await page.mouse.wheel(0, -100);
  await page.keyboard.up('Control');
  await page.waitForFunction(() => !document.querySelector(
    '[data-testid="values-all"]').disabled);
  const part = await shown();
  assert.ok(part.last - part.first < whole.last - whole.first);
  assert.ok(Math.abs(await valueAt(x) - before) < 5, `${before} stays under the pointer`);
  await byId('values-all').click();
});

test('a CT has bands of tissues, with names where they fit', async () => {
  const band = name => byId(`band-${name}`);
  assert.match(await band('Fat').locator('title').textContent(), /-100 to -50 HU/);
  assert.equal(await byId('band-name-Fat').count(), 0, 'too narrow for its name');
  assert.equal(await byId('band-name-Bone').textContent(), 'Bone');
  assert.ok(await page.evaluate(() => {
    const place = selector => document.querySelector(selector).compareDocumentPosition(
      document.querySelector('#histogram .area'));
    return place('.band') & Node.DOCUMENT_POSITION_FOLLOWING &&
      place('.band-name') & Node.DOCUMENT_POSITION_PRECEDING;
  }), 'the outline lies over the bands and under their names');
  const ends = await page.evaluate(() => {
    const rect = document.querySelector('[data-testid="band-Bone"] rect').getBBox();
    const plot = document.querySelector('#histogram-plot rect').getBBox();
    return { right: rect.x + rect.width, end: plot.x + plot.width };
  });
  assert.ok(Math.abs(ends.right - ends.end) < 0.2, 'the band ends at the axis');
  await shoot(page, 'histogram-bands');
  await byId('handle-bone').focus();
  for (let k = 0; k < 12 && await byId('values-fewer').isEnabled(); ++k) {
    await byId('values-fewer').click();
  }
  assert.equal(await band('Lung').count(), 0, 'bands beyond the shown values are not drawn');
});

async function open(source) {
  await byId('open-panel').click();
  await byId('open-path').fill(source);
  await byId('open-go').click();
  await stateWhen(page, (now, source) => now.volume?.source === source && !now.busy, source);
}

const outline = () => page.locator('#histogram .area').getAttribute('d');

/** Waits for the outline of another volume. */
const redrawn = before => page.waitForFunction(before => {
  const now = document.querySelector('#histogram .area').getAttribute('d');
  return now !== before && !document.querySelector('#histogram.empty');
}, before);

test('another volume is shown whole, and has no bands if it is no CT', async () => {
  const bands = () => page.locator('#histogram .bands').first().evaluate(group =>
    group.style.display);
  assert.equal(await bands(), '');
  const scan = await outline();
  await open(writeEllipsoid(path.join(server.folder, 'ball.nrrd'), [16, 16, 16], [6, 6, 6]));
  await redrawn(scan);
  assert.equal(await bands(), 'none');
  assert.ok(await byId('values-all').isDisabled());
  await byId('values-fewer').click();
  assert.ok(await byId('values-all').isEnabled());
  const ball = await outline();
  await open('phantom:pelvis');
  await redrawn(ball);
  assert.ok(await byId('values-all').isDisabled());
  assert.equal(await bands(), '');
});
