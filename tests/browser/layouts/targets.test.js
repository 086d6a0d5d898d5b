// Controls are large enough: 44 x 44 CSS pixels for fingers, 24 x 24 for a mouse.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { settled, unfold } from '../steps.js';
import { writeEllipsoid } from '../volumes.js';

const FINGER_PX = 44, MOUSE_PX = 24;  // WCAG 2.2: 2.5.5 and 2.5.8.
const TOUCH = { hasTouch: true, isMobile: true };
const WINDOWS = [
  { width: 390, height: 844, least: FINGER_PX, options: TOUCH },
  { width: 820, height: 1180, least: FINGER_PX, options: TOUCH },
  { width: 1180, height: 820, least: FINGER_PX, options: TOUCH },
  { width: 1280, height: 720, least: MOUSE_PX, options: {} },
];

useServer(undefined, false, () => {
  writeEllipsoid(path.join(server.folder, 'one.nrrd'), [8, 8, 8], [2, 2, 2]);
});

/**
 * Runs in the page: visible controls that a pointer does not hit on `least` pixels across and down
 * through their middle. A control is its element, what is in it, and its label. Not checked: faces
 * of the cube, which the letters beside it repeat, and links in sentences.
 */
function missed(least) {
  const controls = [...document.querySelectorAll('button, select, input, summary, a[href], ' +
    '[role=slider], [role=separator], [role=option], [role=tab]')].filter(element =>
    element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) &&
    element.type !== 'file' && !element.closest('.unseen, p, .face') &&
    (!document.querySelector('dialog[open]') || element.closest('dialog')));
  const found = [];
  for (const element of controls) {
    element.scrollIntoView({ block: 'center', inline: 'center' });
    const label = element.closest('label');
    const isTick = element.matches('[type=checkbox]');
    const held = isTick && label || element.querySelector('.reach') || element;
    const box = held.getBoundingClientRect();
    const own = isTick && label || element, isEdge = element.matches('[role=separator]');
    // The grip of an edge, in layouts.css.
    const [x, y] = [box.left + box.width / 2, box.top + box.height * (isEdge ? 0.8 : 0.5)];
    const isHit = (right, down) => {
      const top = document.elementFromPoint(x + right, y + down);
      // Handles and lights may lie close together.
      return own.contains(top) || own.matches('[role=slider]') && top?.closest('[role=slider]');
    };
    /** How far from the middle the control is hit, up to `least`. */
    const reach = (right, down) => {
      let far = 0;
      while (far < least && isHit(right * (far + 1), down * (far + 1))) ++far;
      return far;
    };
    // The place of the middle pixel, and the browser's rounding, are worth 2 pixels.
    const [width, height] = isHit(0, 0) ? [reach(-1, 0) + reach(1, 0) + 2,
                                           reach(0, -1) + reach(0, 1) + 2] : [0, 0];
    if (width < least || height < least) {
      const name = element.dataset.testid ?? element.getAttribute('aria-label') ??
        element.textContent.trim().slice(0, 30);
      found.push(`${element.tagName} ${name}: hit within ${width} x ${height}, ` +
        `is ${Math.round(box.width)} x ${Math.round(box.height)}`);
    }
  }
  return { count: controls.length, found };
}

for (const { width, height, least, options } of WINDOWS) {
  test(`all controls can be hit within ${least} px at ${width} x ${height}`, async t => {
    const { page, close } = await openPage(browser, server.url,
      { viewport: { width, height }, ...options });
    const click = id => page.getByTestId(id).click();
    await unfold(page);
    await settled(page);
    const all = new Map();
    let checked = 0;
    const look = async where => {
      await unfold(page);
      const { count, found } = await page.evaluate(missed, least);
      assert.ok(count > 0, `no control in ${where}`);
      checked += count;
      for (const each of found) all.set(each, all.get(each) ?? where);
    };
    await page.keyboard.press('2');  // The hint goes.
    for (const tab of await page.getByRole('tab').all()) {
      await tab.click();
      const name = await tab.innerText();
      if (name === 'Slices') await click('choice-measure');
      if (name === 'Machine') await page.getByTestId('node-gp-0').waitFor();
      await look(name);
    }
    await click('view-menu');
    await look('menu');
    await click('view-menu');
    for (const key of ['8', '9', '0', '7']) {
      await page.keyboard.press(key);
      await settled(page);
      await look(`layout ${key}`);
    }
    for (const key of ['o', 's', '?']) {
      await page.keyboard.press(key);
      await page.locator('dialog[open]').waitFor();
      await page.locator('dialog[open] :is(button, [role=option])').first().waitFor();
      await look(`dialog ${key}`);
      await page.keyboard.press('Escape');
    }
    await page.keyboard.press('t');
    await page.getByTestId('tour-title').waitFor();
    await look('tour');
    t.diagnostic(`${checked} controls`);
    assert.ok(checked > 200, `${checked} controls`);
    assert.deepEqual([...all].map(([what, where]) => `${where}: ${what}`), []);
    await close();
  });
}
