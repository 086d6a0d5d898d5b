// Letters of the page: few sizes, those of tokens.css, and none too small to read.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { settled, unfold } from '../steps.js';

/** Least size of letters, CSS pixels: on a large screen people sit farther away. */
const SIZES = [
  { width: 390, height: 844, least: 12.5, phone: { hasTouch: true, isMobile: true } },
  { width: 1280, height: 720, least: 12 }, { width: 1920, height: 1080, least: 12.5 },
  { width: 3840, height: 2160, least: 19 },
];
const NAMES = ['small', 'body', 'title', 'large'];

useServer();

/**
 * Runs in the page: texts whose size is not one of tokens.css, or is less than `least`. Letters of
 * a drawing that is scaled as a whole have the size that the screen shows.
 */
function strays([names, least]) {
  const root = getComputedStyle(document.documentElement), rem = parseFloat(root.fontSize);
  const allowed = names.map(name => parseFloat(root.getPropertyValue(`--type-${name}`)) * rem);
  const drawn = parseFloat(root.getPropertyValue('--type-drawing'));
  const found = new Map();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let seen = 0;
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement, text = walker.currentNode.textContent.trim();
    if (!text || !element.checkVisibility({ visibilityProperty: true }) ||
        element.closest('.unseen, title')) continue;
    ++seen;
    const size = parseFloat(getComputedStyle(element).fontSize);
    const scale = element.getScreenCTM?.().a ?? 1;
    const isNamed = allowed.some(each => Math.abs(each - size) < 0.02) ||
      element.closest('svg') && size === drawn;
    if (!isNamed || size * scale < least) {
      const times = scale === 1 ? '' : ` x ${scale.toFixed(2)}`;
      found.set(`${element.tagName} ${element.className?.baseVal ?? element.className} ` +
        `${size} px${times}`, text.slice(0, 40));
    }
  }
  return { seen, found: [...found].map(pair => pair.join(': ')) };
}

for (const { width, height, least, phone } of SIZES) {
  test(`all letters have one of four sizes, at least ${least} px at ${width} x ${height}`,
       async () => {
    const { page, close } = await openPage(browser, server.url,
      { viewport: { width, height }, ...phone });
    await unfold(page);
    await settled(page);
    const found = [];
    const look = async where => {
      const { seen, found: strange } = await page.evaluate(strays, [NAMES, least]);
      assert.ok(seen > 15, `${seen} texts in ${where}`);
      found.push(...strange.map(each => `${where}: ${each}`));
    };
    for (const tab of await page.getByRole('tab').all()) {
      await tab.click();
      await look(await tab.innerText());
    }
    for (const key of ['o', 's', '?']) {
      await page.keyboard.press(key);
      await page.locator('dialog[open]').waitFor();
      await look(`dialog ${key}`);
      await page.keyboard.press('Escape');
    }
    assert.deepEqual(found, []);
    await close();
  });
}

test('letters on canvases have the sizes of the style sheet', async () => {
  const { page, close } = await openPage(browser, server.url);
  const { sheet, canvas, unit } = await page.evaluate(async names => {
    const { TYPE_REM, letterSize, unitOf } = await import('/elements/canvas.js');
    const root = getComputedStyle(document.documentElement);
    const of = name => parseFloat(root.getPropertyValue(`--type-${name}`));
    return { sheet: Object.fromEntries(names.map(name => [name, of(name)])), canvas: TYPE_REM,
             unit: [letterSize(unitOf(document.body), 'body'), parseFloat(root.fontSize)] };
  }, NAMES);
  for (const [name, rem] of Object.entries(canvas)) assert.equal(rem, sheet[name], name);
  assert.equal(unit[0], unit[1], 'a body letter is 1 rem');
  await close();
});
