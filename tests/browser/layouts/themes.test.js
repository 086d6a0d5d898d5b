// Themes: dark, light, as the system says; forced colors and paper. axe-core finds nothing in any.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { lookFor } from '../layout.js';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { after, measureAcross, settled, unfold } from '../steps.js';

const axe = readFileSync(path.join(process.env.PXPL5_NODE_MODULES, 'axe-core/axe.min.js'), 'utf8');

const SIZES = [[390, 844], [1024, 768], [1280, 720], [1920, 1080], [3840, 2160]];

let turns = 0;

useServer();

/**
 * What axe-core finds, as sentences.
 * @param {string} part       Selector of what to check: what this state of the page changes.
 * @param {object} [options]  Of axe.run(): which rules.
 * @param {number} [least]    Number of rules that must have had something to check.
 */
async function axeFinds(page, part, options = {}, least = 5) {
  const { violations, passes, incomplete } = await page.evaluate(([part, options]) =>
    globalThis.axe.run(part, { preload: false, ...options }), [part, options]);
  const checked = passes.length + incomplete.length;
  assert.ok(checked >= least, `axe-core checked ${checked} rules`);
  return violations.flatMap(({ id, help, nodes }) => nodes.map(({ html, any }) =>
    `${id}: ${help}: ${html.slice(0, 160)} ${any[0]?.message ?? ''}`));
}

/** Resizes the window and waits until the page has taken it, which it does with its next frames. */
async function resize(page, width, height) {
  await page.setViewportSize({ width, height });
  await page.evaluate(() =>
    new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** The color of the panels, as a level from 0 to 255. */
function panelLevel(page) {
  return page.locator('#bar').evaluate(bar =>
    Number(/\d+/.exec(getComputedStyle(bar).backgroundColor)[0]));
}

/**
 * What axe-core and `faintText` find in a state of the page, in all sizes of windows and both
 * themes: sentences, each with the first place where it holds.
 * @param {Map<string, string>} found
 * @param {string} where    The state, for screenshots and sentences.
 * @param {string} [part]
 */
async function lookEverywhere(page, found, where, part = 'html') {
  for (const [width, height] of SIZES) {
    await resize(page, width, height);
    const note = (faults, theme) => faults.forEach(fault =>
      found.set(fault, found.get(fault) ?? `${where}, ${width} x ${height}, ${theme}`));
    // Themes differ in colors alone, and sizes hardly in colors: 390 and 1280 px have both themes
    // in all states, the others one theme in turn.
    note(await axeFinds(page, part, { rules: { 'color-contrast': { enabled: false } } }),
         'both themes');
    const themes = width === 390 || width === 1280 ? ['dark', 'light']
      : [++turns % 2 === 0 ? 'dark' : 'light'];
    for (const colorScheme of themes) {
      await page.emulateMedia({ colorScheme });
      note(await axeFinds(page, part, { runOnly: ['color-contrast'] }, 1), colorScheme);
      note(await page.evaluate(lookFor.faintText), colorScheme);
      if (width === 1280) await shoot(page, `theme-${colorScheme}-${where}`);
    }
  }
}

test('axe-core finds nothing on any tab, layout, menu or dialog, whatever the theme and the window',
     async () => {
  // axe-core sets styles in markup, which the page's policy forbids.
  const { page, close } = await openPage(browser, server.url, { bypassCSP: true, script: axe });
  await unfold(page);
  await page.getByTestId('size-menu').selectOption('256x256');  // A large one takes its time.
  await settled(page);
  const found = new Map();
  for (const tab of await page.getByRole('tab').all()) {
    await resize(page, 1280, 720);
    await tab.click();
    await settled(page);
    const name = await tab.innerText();
    await lookEverywhere(page, found, name, name === 'Slices' ? 'html' : '#right');
  }
  for (const key of ['8', '9', '0']) {
    await page.keyboard.press(key);
    await page.locator('#panes .slice-canvas').first().waitFor();
    await lookEverywhere(page, found, `layout-${key}`, '#middle');
  }
  await page.keyboard.press('7');
  for (const [width, height] of SIZES) {
    await resize(page, width, height);
    await page.getByTestId('view-menu').click();
    for (const fault of await axeFinds(page, '#bar')) found.set(fault, `menu, ${width} px`);
    await page.keyboard.press('Escape');
  }
  for (const [key, name] of [['?', 'help'], ['o', 'open'], ['s', 'save']]) {
    await page.keyboard.press(key);
    await page.locator('dialog[open]').waitFor();
    await lookEverywhere(page, found, `dialog-${name}`, 'dialog[open]');
    await page.keyboard.press('Escape');
  }
  await resize(page, 1280, 720);
  await page.getByTestId('size-menu').selectOption('');  // As the next page has it.
  await settled(page);
  assert.deepEqual([...found].map(([fault, where]) => `${where}: ${fault}`), []);
  await close();
});

test('the theme is the system\'s until the user chooses one, and is kept', async () => {
  const { page, close } = await openPage(browser, server.url, { colorScheme: 'light' });
  const choose = async name => {
    await page.getByTestId('view-menu').click();
    await page.getByTestId(`choice-${name}`).click();
    await page.keyboard.press('Escape');
  };
  assert.ok(await panelLevel(page) > 240, 'light, as the system');
  await page.emulateMedia({ colorScheme: 'dark' });
  assert.ok(await panelLevel(page) < 40, 'dark, as the system');
  await choose('light');
  assert.ok(await panelLevel(page) > 240, 'light, as chosen');
  await page.reload();
  await page.waitForFunction(() => globalThis.pxpl5?.frames > 0);
  assert.ok(await panelLevel(page) > 240, 'light after a reload');
  assert.equal(await page.getByTestId('choice-light').getAttribute('aria-checked'), 'true');
  await page.emulateMedia({ colorScheme: 'light' });
  await choose('dark');
  assert.ok(await panelLevel(page) < 40, 'dark, as chosen');
  await choose('system');
  assert.ok(await panelLevel(page) > 240, 'the system\'s again');
  await close();
});

test('a theme changes neither the picture nor the ground of the scene', async () => {
  const { page, close } = await openPage(browser, server.url, { colorScheme: 'dark' });
  const dark = await settled(page);
  const ground = () => page.getByTestId('stage').evaluate(each =>
    getComputedStyle(each).backgroundColor);
  const was = await ground();
  await page.emulateMedia({ colorScheme: 'light' });
  assert.equal((await settled(page)).digest, dark.digest);
  assert.equal(await ground(), was);
  await unfold(page);
  for (const color of ['#ffffff', '#000000']) {
    await after(page, () => page.getByTestId('background').fill(color),
                (now, color) => now.background === color, color);
    const [level] = /\d+/.exec(await ground());
    assert.equal(Number(level), color === '#ffffff' ? 255 : 0);
    for (const colorScheme of ['dark', 'light']) {
      await page.emulateMedia({ colorScheme });
      await page.keyboard.press('?');
      await page.keyboard.press('Escape');
      assert.deepEqual(await page.evaluate(lookFor.faintText), [], `${colorScheme} on ${color}`);
      await shoot(page, `theme-${colorScheme}-ground-${color.slice(1)}`);
    }
  }
  await close();
});

test('paper has name, picture, slices and surfaces with values, and no button', async () => {
  const { page, close } = await openPage(browser, server.url, { colorScheme: 'dark' });
  await page.keyboard.press('8');
  await settled(page);
  await page.emulateMedia({ media: 'print', colorScheme: 'dark' });
  for (const id of ['title-volume', 'frame', 'slice-axial', 'slice-coronal', 'slice-sagittal',
                    'slices-readout', 'print-surfaces']) {
    assert.ok(await page.getByTestId(id).isVisible(), id);
  }
  const { surfaces } = await page.evaluate(() => globalThis.pxpl5.state);
  const words = await page.getByTestId('print-surfaces').innerText();
  for (const { name, isovalue } of surfaces) {
    assert.ok(words.includes(name) && words.includes(String(isovalue)), `${name} in '${words}'`);
  }
  for (const id of ['undo', 'open-panel', 'tab-slices', 'choice-four', 'side-left', 'size-menu',
                    'iso-bone', 'choice-point', 'slice-index-0', 'edge-left', 'cube-A']) {
    assert.ok(await page.getByTestId(id).isHidden(), `${id} is on the paper`);
  }
  assert.ok(await page.evaluate(() => {
    const ink = getComputedStyle(document.querySelector('h1')).color;
    return Number(/\d+/.exec(ink)[0]) < 60;
  }), 'dark letters on paper, in the dark theme, too');
  await page.emulateMedia({ media: null });
  const pdf = await page.pdf({ format: 'A4', path: path.join(process.env.PXPL5_SHOTS_DIR,
                                                             'print.pdf') });
  assert.ok(pdf.length > 20_000, `${pdf.length} bytes`);
  const pages = pdf.toString('latin1').match(/\/Type\s*\/Page\b/g).length;
  assert.ok(pages <= 2, `${pages} pages`);
  await close();
});

test('measurements are printed, with their values', async () => {
  const { page, close } = await openPage(browser, server.url);
  await measureAcross(page);
  await page.getByTestId('tab-measure').click();
  const value = await page.getByTestId('measure-list').locator('b').innerText();
  await page.emulateMedia({ media: 'print' });
  assert.ok((await page.getByTestId('print-measures').innerText()).includes(value), value);
  await close();
});

test('in forced colors, choices and bars stay visible', async () => {
  const { page, close } = await openPage(browser, server.url, { forcedColors: 'active' });
  for (const id of ['choice-picture', 'choice-point']) {
    const outline = await page.getByTestId(id).evaluate(each =>
      getComputedStyle(each).outlineStyle);
    assert.equal(outline, 'solid', id);
  }
  await page.getByTestId('tab-machine').click();
  await page.locator('.keys i').first().waitFor();
  const colors = await page.locator('.keys').first().locator('i').evaluateAll(keys =>
    keys.map(each => getComputedStyle(each).backgroundColor));
  assert.ok(colors.length > 2, `${colors}`);
  assert.equal(new Set(colors).size, colors.length, `${colors}`);
  await shoot(page, 'theme-forced');
  await close();
});
