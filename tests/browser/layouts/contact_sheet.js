// Draws contact sheets of the viewer, one a theme: every tab, layout and dialog at five widths.
// usage: contact_sheet.js FOLDER   writes contact-dark.png and contact-light.png there
import path from 'node:path';
import { launchBrowser, openPage, serve } from '../harness.js';
import { settled } from '../steps.js';

const SIZES = [[390, 844], [1024, 768], [1280, 720], [1920, 1080], [3840, 2160]];
const THUMB_PX = 300;   // The longer side of each picture.
const SCALE = 1;        // Pixels of the sheet for a pixel of its layout.

/** What is shown, by name: each function brings it up, and Escape or the next one ends it. */
const SCREENS = {
  'first visit': () => {},
  ...Object.fromEntries(['Slices', 'Measure', 'Inspector', 'Machine', 'Volume'].map(
    name => [name, page => page.getByRole('tab', { name }).click()])),
  'two by two': page => page.keyboard.press('9'),
  'slices alone': page => page.keyboard.press('0'),
  open: page => dialog(page, 'o'),
  save: page => dialog(page, 's'),
  help: page => dialog(page, '?'),
  tour: page => page.keyboard.press('t'),
};

async function dialog(page, key) {
  await page.keyboard.press('7');
  await page.keyboard.press(key);
  await page.locator('dialog[open]').waitFor();
}

/** Pictures of one theme: by name of the screen, one for each size, as data: addresses. */
async function pictures(browser, url, colorScheme) {
  const rows = Object.fromEntries(Object.keys(SCREENS).map(name => [name, []]));
  for (const [width, height] of SIZES) {
    const { page, close } = await openPage(browser, url,
      { viewport: { width, height }, colorScheme, hasTouch: width < 1000 });
    for (const [name, show] of Object.entries(SCREENS)) {
      await show(page);
      await settled(page);
      const shot = await page.screenshot({ type: 'jpeg', quality: 90 });
      rows[name].push(`data:image/jpeg;base64,${shot.toString('base64')}`);
      if (await page.locator('dialog[open]').count() > 0) await page.keyboard.press('Escape');
    }
    await close();
  }
  return rows;
}

/** Lays the pictures of a theme out, and writes them to a file. */
async function writeSheet(browser, rows, theme, file) {
  const context = await browser.newContext({ deviceScaleFactor: SCALE,
    viewport: { width: SIZES.length * (THUMB_PX + 10) + 110, height: 800 } });
  const page = await context.newPage();
  const [ink, ground] = theme === 'dark' ? ['#ddd', '#222'] : ['#222', '#ddd'];
  const head = SIZES.map(([width, height]) => `<th>${width} x ${height}</th>`).join('');
  const body = Object.entries(rows).map(([name, shots]) => `<tr><th>${name}</th>${shots.map(
    shot => `<td><img src="${shot}"></td>`).join('')}</tr>`).join('');
  await page.setContent(`<style>
    body { display: inline-block; margin: 0; padding: 8px; font: 14px sans-serif;
      color: ${ink}; background: ${ground}; }
    td { text-align: center; } th { font-weight: normal; }
    img { display: block; margin: auto; max-width: ${THUMB_PX}px; max-height: ${THUMB_PX}px; }
    </style><table><tr><th>${theme}</th>${head}</tr>${body}</table>`);
  await page.locator('body').screenshot({ path: file });
  await context.close();
}

const [folder] = process.argv.slice(2);
if (!folder) {
  console.error('usage: contact_sheet.js FOLDER');
  process.exit(64);
}
const browser = await launchBrowser();
try {
  for (const theme of ['dark', 'light']) {
    const server = await serve('phantom:pelvis');  // A first visit for each theme.
    try {
      const rows = await pictures(browser, server.url, theme);
      await writeSheet(browser, rows, theme, path.join(folder, `contact-${theme}.png`));
      console.log(`wrote contact-${theme}.png`);
    } finally {
      await server.stop();
    }
  }
} finally {
  await browser.close();
}
