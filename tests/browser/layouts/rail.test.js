// The rail of icons that opens the panels: keyboard, tooltips, and the row of phones.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { settled } from '../steps.js';

const PANELS = ['slices', 'measure', 'inspector', 'machine', 'volume'];
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };

useServer();

const idOf = page => page.evaluate(() => document.activeElement.dataset.testid);

test('arrow keys walk the rail, and one tab at a time shows its panel', async () => {
  const { page, close } = await openPage(browser, server.url);
  assert.equal(await page.getByRole('tablist').getAttribute('aria-orientation'), 'vertical');
  assert.ok(await page.getByTestId('tab-surfaces').isHidden(), 'the surfaces have a side');
  await page.getByTestId('tab-slices').focus();
  const { digest } = await settled(page);
  for (const [key, ids] of [['ArrowDown', [...PANELS.slice(1), 'slices']],
                            ['ArrowUp', [...PANELS].reverse()]]) {
    for (const id of ids) {
      await page.keyboard.press(key);
      assert.equal(await idOf(page), `tab-${id}`);
      assert.equal(await page.locator('[role=tab][aria-selected=true]').getAttribute('id'),
                   `tab-${id}`);
      assert.equal(await page.locator('[role=tab][tabindex="0"]').count(), 1);
      for (const each of PANELS) {
        assert.equal(await page.locator(`#panel-${each}`).isVisible(), each === id, each);
      }
    }
  }
  assert.equal((await settled(page)).digest, digest, 'the keys do not turn the picture');
  await close();
});

test('a tooltip appears under a mouse and with the focus; Escape hides it', async () => {
  const { page, close } = await openPage(browser, server.url);
  const tip = page.getByTestId('tip'), tab = page.getByTestId('tab-inspector');
  await tab.hover();
  await tip.waitFor();
  assert.match(await tip.innerText(), /color of a pixel/);
  assert.equal(await tab.getAttribute('aria-describedby'), await tip.getAttribute('id'));
  const box = await tip.boundingBox(), own = await tab.boundingBox();
  assert.ok(box.x > 0 && box.x + box.width <= own.x, `beside the tab: ${JSON.stringify(box)}`);
  // Slowly, also across the gap between them.
  await page.mouse.move(own.x + 2, own.y + own.height / 2);
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2, { steps: 60 });
  assert.ok(await tip.isVisible(), 'the pointer may go to the tooltip');
  await page.mouse.move(200, 300);
  await tip.waitFor({ state: 'hidden' });
  assert.equal(await tab.getAttribute('aria-describedby'), null);
  await page.getByTestId('tab-slices').focus();
  await page.keyboard.press('ArrowDown');
  assert.match(await tip.innerText(), /Distances/);
  await shoot(page, 'rail-tip');
  await page.keyboard.press('Escape');
  assert.ok(await tip.isHidden());
  await close();
});

test('the rail stays when the right side is hidden, and opens it', async () => {
  const { page, close } = await openPage(browser, server.url);
  await page.keyboard.press('.');
  assert.ok(await page.locator('#right').isHidden());
  await page.getByTestId('tab-volume').click();
  assert.ok(await page.locator('#panel-volume').isVisible());
  assert.equal(await page.getByTestId('side-right').getAttribute('aria-expanded'), 'true');
  await close();
});

test('on a phone it is a row at the bottom, and shows one panel at a time', async () => {
  const { page, close } = await openPage(browser, server.url, PHONE);
  assert.equal(await page.getByRole('tablist').getAttribute('aria-orientation'), 'horizontal');
  assert.ok(await page.getByTestId('histogram').isVisible(), 'the histogram is first');
  assert.equal(await page.locator('#left').getAttribute('role'), 'tabpanel');
  for (const id of [...PANELS, 'surfaces']) {
    await page.getByTestId(`tab-${id}`).tap();
    assert.equal(await page.locator('#left').isVisible(), id === 'surfaces', id);
    assert.equal(await page.locator('#right').isVisible(), id !== 'surfaces', id);
    const { y, height } = await page.getByTestId(`tab-${id}`).boundingBox();
    assert.ok(y > 780 && y + height <= 844, `${id} at ${y}`);
    const stage = await page.getByTestId('stage').boundingBox();
    assert.ok(stage.y < 60 && stage.height > 250, 'the picture stays in sight');
  }
  await page.getByTestId('view-menu').tap();
  await page.getByTestId('side-left').tap();
  assert.ok(await page.locator('#sides').isHidden(), 'a hidden side makes room');
  await page.getByTestId('tab-surfaces').tap();
  assert.ok(await page.getByTestId('histogram').isVisible());
  await page.setViewportSize({ width: 1280, height: 720 });
  assert.ok(await page.locator('#left').isVisible() && await page.locator('#right').isVisible());
  assert.equal(await page.locator('#left').getAttribute('role'), null);
  assert.ok(await page.locator('#panel-volume').isVisible(), 'the last panel is back');
  await close();
});
