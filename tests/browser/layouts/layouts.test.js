// Layouts: picture and slices side by side, sides that close and change their size, and what a
// session and a reload keep of it.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { lookFor } from '../layout.js';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { drag, middleOf, settled } from '../steps.js';

const SIZES = [[390, 844], [1024, 768], [1280, 720], [1920, 1080]];
const LARGE = [3840, 2160];
const KEYS = { picture: '7', beside: '8', four: '9', slices: '0' };
const NAMES = Object.keys(KEYS);
const SLICES = ['slice-axial', 'slice-coronal', 'slice-sagittal'];

useServer();

/** Chooses a layout by its key, and waits until picture and slices have their places. */
async function choose(page, name) {
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press(KEYS[name]);
  await fits(page);
}

/** Waits until the picture at rest has the proportions of its pane, if it is shown. */
async function fits(page) {
  await page.waitForFunction(() => {
    const { clientWidth, clientHeight } = document.querySelector('#stage');
    const [width, height] = globalThis.pxpl5.state.size;
    return clientWidth === 0 || Math.abs(width / height - clientWidth / clientHeight) < 0.02;
  });
  await settled(page);
}

/** Boxes of the picture and of the slices that are in sight. */
async function panes(page) {
  const boxes = {};
  for (const id of ['stage', ...SLICES]) {
    const pane = page.getByTestId(id);
    if (await pane.isVisible()) boxes[id] = await pane.boundingBox();
  }
  return boxes;
}

/** Whether a slice has been painted: its canvas has bright pixels. */
function isPainted(page, id) {
  return page.waitForFunction(id => {
    const canvas = document.querySelector(`[data-testid=${id}]`);
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Uint8Array(data.buffer).some((level, at) => at % 4 === 0 && level > 150);
  }, id);
}

function overlap(a, b) {
  return a.x + 1 < b.x + b.width && b.x + 1 < a.x + a.width && a.y + 1 < b.y + b.height &&
    b.y + 1 < a.y + a.height;
}

for (const [width, height] of [...SIZES, LARGE]) {
  test(`every layout at ${width} x ${height} shows its panes whole, apart, and painted`,
       async () => {
    const { page, close } = await openPage(browser, server.url, { viewport: { width, height } });
    await page.mouse.click(2, 2);  // The first hint goes.
    for (const name of NAMES) {
      await choose(page, name);
      const boxes = await panes(page);
      const hasStage = name !== 'slices', isBeside = name !== 'picture';
      assert.equal('stage' in boxes, hasStage, name);
      const middle = await page.locator('#middle').boundingBox();
      if (isBeside) {
        for (const id of SLICES) {
          await isPainted(page, id);
          const { x, y, width: wide, height: high } = boxes[id];
          assert.ok(x >= middle.x && y >= middle.y && x + wide <= middle.x + middle.width + 1 &&
            y + high <= middle.y + middle.height + 1, `${name}: ${id} leaves the middle`);
          assert.ok(wide >= 100 && high >= 60, `${name}: ${id} of ${wide} x ${high}`);
        }
        const all = Object.entries(boxes);
        all.forEach(([id, box], index) => all.slice(index + 1).forEach(([other, its]) =>
          assert.ok(!overlap(box, its), `${name}: ${id} lies over ${other}`)));
        const covered = all.reduce((sum, [, box]) => sum + box.width * box.height, 0);
        assert.ok(covered > 0.5 * middle.width * middle.height,
                  `${name}: ${covered / middle.width / middle.height} of the middle is used`);
      }
      assert.deepEqual(await page.evaluate(lookFor.misplaced), [], name);
      await shoot(page, `layout-${name}-${width}`);
    }
    await close();
  });
}

test('beside, the picture is the largest pane; two by two, all are equal; slices, one is large',
     async () => {
  const { page, close } = await openPage(browser, server.url,
                                         { viewport: { width: 1920, height: 1080 } });
  const area = ({ width, height }) => width * height;
  await choose(page, 'beside');
  const beside = await panes(page);
  for (const id of SLICES) assert.ok(area(beside.stage) > 3 * area(beside[id]), id);
  await choose(page, 'four');
  const four = await panes(page);
  assert.ok(Math.abs(four.stage.x - four['slice-coronal'].x) < 2, 'one column');
  assert.ok(Math.abs(four['slice-axial'].width - four.stage.width) < 2, 'of one width');
  await page.getByTitle('Enlarge this slice').nth(2).click();
  const slices = await panes(page);
  assert.ok(!slices.stage, 'the large slice takes the place of the picture');
  for (const id of SLICES.slice(0, 2)) {
    assert.ok(area(slices['slice-sagittal']) > 2 * area(slices[id]), id);
  }
  await choose(page, 'picture');
  const panel = await page.locator('#panel-slices').boundingBox();
  assert.ok(overlap(panel, (await panes(page))['slice-sagittal']), 'back in the panel');
  assert.ok(await page.locator('#panel-slices').getByTestId('slices-readout').isVisible());
  await page.getByTestId('slice-coronal').focus();
  for (const key of ['9', '7']) {
    await page.keyboard.press(key);
    assert.equal(await page.evaluate(() => document.activeElement.dataset.testid),
                 'slice-coronal', `after ${key}, the slice has the focus`);
  }
  await close();
});

test('slices beside the picture are the crosshair of the picture, whatever tab is in front',
     async () => {
  const { page, close } = await openPage(browser, server.url);
  await page.getByTestId('tab-volume').click();
  await choose(page, 'four');
  for (const id of SLICES) await isPainted(page, id);
  const count = page.getByTestId('slice-count-0');
  const before = await count.innerText();
  await page.getByTestId('slice-axial').focus();
  await page.keyboard.press('PageUp');
  await page.waitForFunction(before =>
    document.querySelector('[data-testid=slice-count-0]').textContent !== before, before);
  assert.ok(await page.getByTestId('slices-readout').isVisible());
  assert.equal(await page.evaluate(() => document.activeElement.dataset.testid), 'slice-axial');
  await page.keyboard.press('7');
  assert.ok(await page.getByTestId('slice-axial').isHidden(), 'the tab Volume is in front');
  await page.keyboard.press('0');
  await page.getByTestId('tab-inspector').click();
  await page.getByTestId('inspect-mode').click();
  assert.ok(await page.getByTestId('stage').isVisible(), 'the mode needs the picture');
  await page.keyboard.press('Escape');
  await close();
});

test('buttons and keys do the same, and say so', async () => {
  const { page, close } = await openPage(browser, server.url);
  for (const name of [...NAMES].reverse()) {
    await page.getByTestId(`choice-${name}`).click();
    assert.equal(await page.locator('#panes').getAttribute('data-layout'), name);
    assert.match(await page.getByTestId(`choice-${name}`).getAttribute('title'),
                 new RegExp(`key ${KEYS[name]}`));
  }
  for (const name of NAMES) {
    await page.keyboard.press(KEYS[name]);
    assert.equal(await page.getByTestId(`choice-${name}`).getAttribute('aria-checked'), 'true');
    assert.equal(await page.locator('[aria-label=Layout] [aria-checked=true]').count(), 1);
  }
  await choose(page, 'picture');
  for (const [side, key] of [['left', ','], ['right', '.']]) {
    const button = page.getByTestId(`side-${side}`);
    const before = (await page.getByTestId('stage').boundingBox()).width;
    await page.keyboard.press(key);
    assert.equal(await button.getAttribute('aria-expanded'), 'false');
    assert.ok(await page.locator(`#${side}`).isHidden());
    assert.ok((await page.getByTestId('stage').boundingBox()).width > before + 200, side);
    await fits(page);
    assert.match(await button.getAttribute('title'), /^Show/);
    await button.click();
    assert.equal(await button.getAttribute('aria-expanded'), 'true');
    assert.ok(await page.locator(`#${side}`).isVisible());
  }
  await page.keyboard.press('?');
  const sheet = await page.getByTestId('help-sheet').innerText();
  for (const words of ['7 8 9 0', ', .', 'full screen']) assert.ok(sheet.includes(words), words);
  await page.getByTestId('help-sheet').getByLabel('Close').click();
  await close();
});

test('full screen by button and key, and no button where there is none', async () => {
  const { page, close } = await openPage(browser, server.url);
  const isFull = wanted => page.waitForFunction(wanted =>
    (document.fullscreenElement !== null) === wanted, wanted);
  await page.getByTestId('full-screen').click();
  await isFull(true);
  assert.equal(await page.getByTestId('full-screen').getAttribute('aria-pressed'), 'true');
  await page.keyboard.press('f');
  await isFull(false);
  await page.waitForFunction(() => document.querySelector('[data-testid=full-screen]')
    .getAttribute('aria-pressed') === 'false');
  await close();
  const without = await openPage(browser, server.url, { script: () =>
    Object.defineProperty(Document.prototype, 'fullscreenEnabled', { get: () => false }) });
  assert.ok(await without.page.getByTestId('full-screen').isHidden());
  await without.page.keyboard.press('f');
  await without.close();
});

test('the separators follow pointer and keys, within their limits', async () => {
  const { page, close } = await openPage(browser, server.url);
  const wide = async side => (await page.locator(`#${side}`).boundingBox()).width;
  for (const [side, way] of [['left', 1], ['right', -1]]) {
    const edge = page.getByTestId(`edge-${side}`);
    const value = async name => Number(await edge.getAttribute(`aria-value${name}`));
    assert.equal(await edge.getAttribute('role'), 'separator');
    assert.equal(await edge.getAttribute('aria-controls'), side);
    const was = await wide(side);
    assert.equal(await value('now'), Math.round(was));
    const at = await middleOf(edge);
    await drag(page, at, { x: at.x + way * 50, y: at.y });
    assert.ok(Math.abs(await wide(side) - was - 50) <= 1, `${await wide(side)} from ${was}`);
    assert.equal(await value('now'), Math.round(await wide(side)));
    const dragged = await wide(side);
    await edge.focus();
    await page.keyboard.press(way === 1 ? 'ArrowRight' : 'ArrowLeft');
    assert.ok(Math.abs(await wide(side) - dragged - 13) <= 1, 'one rem wider');
    await page.keyboard.press(way === 1 ? 'ArrowLeft' : 'ArrowRight');
    assert.ok(Math.abs(await wide(side) - dragged) <= 1, 'and back');
    for (const [key, limit] of [['Home', 'min'], ['End', 'max']]) {
      await page.keyboard.press(key);
      assert.ok(Math.abs(await wide(side) - await value(limit)) <= 1, `${key}: ${limit}`);
    }
    const least = await page.getByTestId('stage').boundingBox();
    assert.ok(least.width > 200, `a picture of ${least.width} px`);
    await page.getByTestId(`edge-${side}`).dblclick();
    assert.ok(Math.abs(await wide(side) - was) <= 1, 'a double click resets it');
  }
  await fits(page);
  await close();
});

test('a reload keeps layout, sides and widths; so does a saved session', async () => {
  const { page, context, close } = await openPage(browser, server.url);
  await choose(page, 'beside');
  await page.getByTestId('edge-right').focus();
  await page.keyboard.press('Shift+ArrowLeft');
  await page.keyboard.press(',');
  const right = (await page.locator('#right').boundingBox()).width;
  const file = path.join(server.folder, 'layout.pxpl5');
  await page.getByTestId('save-menu').click();
  const [download] = await Promise.all([page.waitForEvent('download'),
    page.getByTestId('session-save').click()]);
  writeFileSync(file, readFileSync(await download.path()));

  const now = () => page.evaluate(() => ({
    name: document.querySelector('#panes').dataset.layout,
    left: document.querySelector('#left').checkVisibility(),
    right: document.querySelector('#right').getBoundingClientRect().width }));
  const kept = { name: 'beside', left: false, right };
  await page.reload();
  await page.waitForFunction(() => globalThis.pxpl5?.frames > 0);
  assert.deepEqual(await now(), kept);
  for (const id of SLICES) await isPainted(page, id);

  await page.evaluate(() => localStorage.clear());
  await page.reload();
  await page.waitForFunction(() => globalThis.pxpl5?.frames > 0);
  assert.deepEqual(await now(), { name: 'picture', left: true, right: right - 52 });
  await page.getByTestId('save-menu').click();
  await page.getByTestId('session-open').setInputFiles(file);
  await page.waitForFunction(() => document.querySelector('#panes').dataset.layout === 'beside');
  assert.deepEqual(await now(), kept);

  for (const bad of ['{"name":"five","left":0,"sizes":{"right":"wide"}}', 'not JSON', '7']) {
    await page.evaluate(bad => localStorage.setItem('pxpl5-layout', bad), bad);
    await page.reload();
    await page.waitForFunction(() => globalThis.pxpl5?.frames > 0);
    assert.deepEqual(await now(), { name: 'picture', left: true, right: right - 52 }, bad);
  }
  await context.clearCookies();
  await close();
});

test('a lost connection and a near end are shown over slices alone', async () => {
  const { page, close } = await openPage(browser, server.url);
  await choose(page, 'slices');
  await page.evaluate(() => {
    for (const id of ['lost', 'ending']) document.getElementById(id).hidden = false;
    document.getElementById('ending').textContent = 'This session ends soon';
  });
  const middle = await page.locator('#middle').boundingBox();
  for (const id of ['lost', 'ending']) {
    const box = await page.getByTestId(id).boundingBox();
    assert.ok(box && overlap(box, middle), id);
  }
  await close();
});
