// Sizes of windows: everything can be reached and read in small ones, and the picture has the size
// of the window that is used.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { lookFor } from './layout.js';
import { browser, openPage, server, shoot, useServer } from './harness.js';
import { holdMessages } from './holding.js';
import { after, settled, stateWhen } from './steps.js';
import { writeEllipsoid } from './volumes.js';

const SIZES = [[390, 844], [640, 360], [844, 390], [910, 512], [960, 540], [1000, 700], [1100, 700],
             [1280, 720]];
const LEAST_PX = { width: 380, height: 200 };  // Of the picture.

useServer(['phantom:pelvis']);

/** In the page: pairs of things over the picture that lie over each other. */
function overlaps() {
  const things = [...document.querySelectorAll(
    '#overlay .side, #overlay [data-testid=scale-bar], #hint, #cube, #views, #assumed, .toast')]
    .filter(each => each.checkVisibility() && each.getBoundingClientRect().width > 0);
  const nameOf = each => each.id || each.textContent || each.getAttribute('data-testid');
  const found = [];
  things.forEach((a, index) => {
    const one = a.getBoundingClientRect();
    for (const b of things.slice(index + 1)) {
      const other = b.getBoundingClientRect();
      if (one.left < other.right && other.left < one.right && one.top < other.bottom &&
          other.top < one.bottom) {
        found.push(`${nameOf(a)} lies over ${nameOf(b)}`);
      }
    }
  });
  return found;
}

for (const [width, height] of SIZES) {
  test(`a first visit at ${width} x ${height}: nothing hides letters, menus or the picture`,
       async () => {
    const { page, close } = await openPage(browser, server.url, { viewport: { width, height } });
    await settled(page);
    await shoot(page, `window-${width}x${height}`);
    assert.ok(await page.getByTestId('hint').isVisible());
    assert.deepEqual(await page.evaluate(overlaps), []);
    const box = await page.getByTestId('stage').boundingBox();
    assert.ok(box.width >= LEAST_PX.width && box.height >= LEAST_PX.height, JSON.stringify(box));
    const hint = await page.getByTestId('hint').boundingBox();
    assert.ok(hint.width * hint.height < box.width * box.height / 6, 'the hint hides the picture');
    const menu = await page.getByTestId('size-menu').boundingBox();
    assert.ok(menu.x + menu.width <= width, 'the size menu is cut off');
    const { clientWidth, scrollWidth } = await page.getByTestId('title-volume').evaluate(
      ({ clientWidth, scrollWidth }) => ({ clientWidth, scrollWidth }));
    assert.ok(scrollWidth <= clientWidth || clientWidth === 0, 'the title is cut off');
    for (const tab of await page.getByRole('tab').all()) {
      const { x, width: wide } = await tab.boundingBox();
      assert.ok(x + wide <= width, `tab ${await tab.innerText()} is cut off`);
    }
    assert.deepEqual(await page.evaluate(lookFor.misplaced), []);
    await close();
  });
}

test('the warning of an assumed place is whole in windows of any size', async () => {
  const raw = await openPage(browser, server.url);
  const file = writeEllipsoid(path.join(server.folder, 'unplaced.nrrd'), [20, 20, 20], [8, 8, 8],
                              false);
  await after(raw.page, async () => {
    await raw.page.getByTestId('open-panel').click();
    await raw.page.getByTestId('open-path').fill(file);
    await raw.page.getByTestId('open-go').click();
  }, (now, file) => now.volume?.source === file, file);
  await raw.close();
  for (const [width, height] of [...SIZES, [1920, 1080]]) {
    const { page, close } = await openPage(browser, server.url, { viewport: { width, height } });
    await settled(page);
    const warning = page.getByTestId('assumed');
    assert.equal(await warning.innerText(), 'place or spacing ASSUMED');
    const box = await warning.boundingBox(), stage = await page.getByTestId('stage').boundingBox();
    assert.ok(box.x >= stage.x && box.x + box.width <= stage.x + stage.width,
              `${width} x ${height}: ${JSON.stringify(box)}`);
    assert.deepEqual(await page.evaluate(overlaps), [], `${width} x ${height}`);
    const seen = await warning.evaluate(element => {
      const { left, right, top, bottom } = element.getBoundingClientRect();
      element.style.pointerEvents = 'auto';
      return [[left + 2, top + 2], [right - 2, top + 2], [left + 2, bottom - 2],
              [right - 2, bottom - 2]].every(at => document.elementFromPoint(...at) === element);
    });
    assert.ok(seen, `${width} x ${height}: something lies over the warning`);
    await shoot(page, `assumed-${width}x${height}`);
    await page.keyboard.press('0');
    await page.getByTestId('stage').waitFor({ state: 'hidden' });
    assert.ok(await warning.isVisible(), 'slices alone have the warning, too');
    await page.keyboard.press('7');
    await page.getByTestId('stage').waitFor();
    await page.evaluate(() => {
      const toast = document.createElement('div');
      toast.className = 'toast error';
      toast.textContent = 'A message that stays until it is closed';
      document.getElementById('toasts').append(toast);
    });
    const covered = (await page.evaluate(overlaps)).filter(pair => pair.includes('assumed'));
    assert.deepEqual(covered, [], `${width} x ${height}: a message lies over the warning`);
    await close();
  }
  const last = await openPage(browser, server.url);
  await after(last.page, async () => {
    await last.page.getByTestId('open-panel').click();
    await last.page.getByTestId('open-path').fill('phantom:pelvis');
    await last.page.getByTestId('open-go').click();
  }, now => now.volume?.name === 'phantom:pelvis');
  assert.ok(await last.page.getByTestId('assumed').isHidden());
  await last.close();
});

test('the first hint goes with the first drag of a threshold', async () => {
  const { page, close } = await openPage(browser, server.url);
  await page.getByTestId('hint').waitFor();
  await page.getByTestId('handle-bone').locator('.reach').click();
  await page.getByTestId('hint').waitFor({ state: 'hidden' });
  await close();
});

test('an isovalue with many digits fits into its field', async () => {
  const { page, close } = await openPage(browser, server.url);
  const field = page.getByTestId('iso-bone');
  await after(page, async () => {
    await field.fill('134.750001');
    await field.press('Enter');
  }, now => now.surfaces.some(({ isovalue }) => Math.abs(isovalue - 134.75) < 0.001));
  await page.waitForFunction(() => document.activeElement === document.body);
  const { clientWidth, scrollWidth } = await field.evaluate(
    ({ clientWidth, scrollWidth }) => ({ clientWidth, scrollWidth }));
  assert.ok(scrollWidth <= clientWidth, `${scrollWidth} px in a field of ${clientWidth} px`);
  assert.ok((await field.inputValue()).length <= 9, await field.inputValue());
  await close();
});

test('the picture has the size of the page that is used, after another one has gone', async () => {
  const mine = await openPage(browser, server.url);
  await settled(mine.page);
  const own = (await mine.page.evaluate(() => globalThis.pxpl5.state.size)).join('x');
  const other = await openPage(browser, server.url, { viewport: { width: 1920, height: 1080 } });
  await stateWhen(mine.page, (now, own) => now.size.join('x') !== own, own);
  await other.close();
  await mine.page.mouse.move(20, 20);
  const box = await mine.page.getByTestId('stage').boundingBox();
  await mine.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2, { steps: 3 });
  await stateWhen(mine.page, (now, own) => now.size.join('x') === own, own);
  await mine.close();
});

test('a panel that is small for a moment leaves no small picture, though the state is late',
     async () => {
  const { page, close } = await openPage(browser, server.url, { script: holdMessages });
  await settled(page);
  const { size } = await page.evaluate(() => globalThis.pxpl5.state);
  const replies = await page.evaluate(() => {
    globalThis.holds = 'state';
    return globalThis.replies;
  });
  for (const [wanted, height] of [[1, 600], [2, 720]]) {
    await page.setViewportSize({ width: 1280, height });
    await page.waitForFunction(least => globalThis.replies >= least, replies + wanted);
  }
  await page.evaluate(() => globalThis.release());
  await settled(page);
  assert.deepEqual((await page.evaluate(() => globalThis.pxpl5.state)).size, size);
  await close();
});

test('scale bar and letters stand out on white as on black', async () => {
  const { page, close } = await openPage(browser, server.url);
  await settled(page);
  for (const [ground, light] of [['#ffffff', true], ['#000000', false]]) {
    await page.evaluate(() => {
      for (const details of document.querySelectorAll('details')) details.open = true;
    });
    await after(page, () => page.getByTestId('background').fill(ground),
                (now, ground) => now.background === ground, ground);
    const ink = await page.evaluate(() => [
      getComputedStyle(document.querySelector('#overlay .scale')).stroke,
      getComputedStyle(document.querySelector('#overlay .side')).fill,
      getComputedStyle(document.querySelector('#overlay .scale-text')).fill,
    ].map(color => Number(/\d+/.exec(color)[0])));
    for (const level of ink) assert.ok(light ? level < 80 : level > 180, `${ink} on ${ground}`);
    await shoot(page, `ground-${light ? 'white' : 'black'}`);
  }
  await close();
});
