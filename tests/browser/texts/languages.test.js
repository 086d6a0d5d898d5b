// The page in another language, and that no text of the page has only English.
import assert from 'node:assert/strict';
import test from 'node:test';

import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { lookFor } from '../layout.js';
import { measureAcross, settled, unfold } from '../steps.js';

useServer(['phantom:heart', 'resample=48x48x48']);

/** The address of the page in a language. */
function inLanguage(code) {
  const url = new URL(server.url);
  url.searchParams.set('lang', code);
  return url.href;
}

/** Names that are the same in every language: of files, programs, colors, built-in volumes. */
const NAMES = ['CSV', 'DICOM', 'JSON', 'LPS', 'MIP', 'NIfTI', 'PLY', 'PNG', 'RAS', 'STL', 'VTK',
  'Wavefront', 'binary', 'fetus', 'glTF', 'glb', 'head', 'letters', 'obj', 'paper', 'pelvis', 'ply',
  'sphere', 'stl', 'torus', 'viridis', 'vtp'];

/**
 * Words outside of brackets, each with the element that shows it. Runs in the page. Data have
 * translate="no", as in HTML, and English texts of the machine have a language of their own.
 * @param {string[]} names  Words that need no translation.
 */
function unmarkedWords(names) {
  const { volume, surfaces } = globalThis.pxpl5.state;
  const data = [volume.name, volume.source, ...surfaces.map(({ name }) => name)].join(' ');
  const known = new Set([...names, ...data.match(/\p{L}{3,}/gu)]);
  const outside = text => {
    let rest = text, before;
    do {
      before = rest;
      rest = rest.replace(/⟦[^⟦⟧]*⟧/g, ' ');
    } while (rest !== before);
    return rest.match(/\p{L}{3,}/gu) ?? [];
  };
  const found = new Map();
  const look = (text, element, what) => {
    for (const word of outside(text).filter(each => !known.has(each))) {
      const named = element.closest('[data-testid], [id]');
      const place = named?.getAttribute('data-testid') ?? named?.id ?? '';
      found.set(`${word} (${place || element.tagName}${what})`, text.slice(0, 120));
    }
  };
  for (const element of document.body.querySelectorAll('*')) {
    if (element.closest('[translate=no], body [lang], code, pre, script, style')) continue;
    for (const name of ['aria-label', 'title', 'alt', 'aria-valuetext']) {
      const text = element.getAttribute(name);
      if (text) look(text, element, ` ${name}`);
    }
    for (const node of element.childNodes) {
      if (node.nodeType === Node.TEXT_NODE) look(node.textContent, element, '');
    }
  }
  return [...found];
}

/** Shows each part of the page in turn, and calls `look` with its name. */
async function everywhere(page, look) {
  await settled(page);
  await unfold(page);
  for (const tab of await page.getByRole('tab').all()) {
    await tab.click();
    await settled(page);
    await unfold(page);
    await look(`panel-${(await tab.getAttribute('data-testid')).replace('tab-', '')}`);
  }
  for (const key of ['8', '9', '0', '7']) {
    await page.keyboard.press(key);
    await settled(page);
    await look(`layout-${key}`);
  }
  await page.getByTestId('view-menu').click();
  await look('menu');
  await page.keyboard.press('Escape');
  for (const [key, name] of [['?', 'help'], ['o', 'open'], ['s', 'save']]) {
    await page.keyboard.press(key);
    await page.locator('dialog[open]').waitFor();
    await unfold(page);
    await look(`dialog-${name}`);
    await page.keyboard.press('Escape');
  }
  await page.keyboard.press('t');
  const steps = page.locator('[data-testid^=tour-link-]');
  await steps.first().waitFor();
  for (let step = 0; step < await steps.count(); ++step) {
    await steps.nth(step).click();
    await settled(page);
    await look(`tour-${step + 1}`);
  }
  await page.keyboard.press('Escape');
}

test('every text of the page comes from the texts that are translated', async () => {
  const { page, close } = await openPage(browser, inLanguage('marked'));
  const found = new Map();
  await everywhere(page, async where => {
    for (const [word, text] of await page.evaluate(unmarkedWords, NAMES)) {
      if (!found.has(word)) found.set(word, `${where}: ${word}: '${text}'`);
    }
  });
  assert.deepEqual([...found.values()], []);
  await close();
});

test('German fits its places in all parts of the page, at 390 and 1280 pixels', async () => {
  const { page, close } = await openPage(browser, inLanguage('de'));
  assert.equal(await page.locator('html').getAttribute('lang'), 'de');
  assert.equal(await page.getByTestId('undo').getAttribute('aria-label'), 'Rückgängig');
  const found = new Set();
  for (const [width, height] of [[1280, 720], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await everywhere(page, async where => {
      await shoot(page, `german-${width}-${where}`);
      for (const fault of await page.evaluate(lookFor.misplaced)) {
        if (fault.includes('wide')) found.add(`${where}, ${width} px: ${fault}`);
      }
    });
  }
  assert.deepEqual([...found], []);
  await close();
});

test('measurements are lost only if the user says so', async () => {
  const { page, close } = await openPage(browser, server.url);
  await measureAcross(page);
  await page.getByTestId('measure-list').locator('b').first().waitFor({ state: 'attached' });
  await page.keyboard.press('?');
  const questions = [];
  page.once('dialog', async dialog => {
    questions.push(dialog.message());
    await dialog.dismiss();
  });
  await page.getByTestId('choice-de').click();
  assert.match(questions.join(), /^Your measurements would be lost/);
  assert.equal(await page.getByTestId('choice-en').getAttribute('aria-checked'), 'true');
  assert.equal(await page.getByTestId('measure-list').locator('b').count(), 1);
  await close();
});

test('without its texts, the page is in English', async () => {
  const { page, complaints, context } = await openPage(browser, inLanguage('de'), {
    refused: '**/de.js' });
  assert.equal(await page.locator('html').getAttribute('lang'), 'en');
  assert.equal(await page.getByTestId('undo').getAttribute('aria-label'), 'Undo');
  assert.deepEqual(complaints.filter(each => !each.includes('ERR_FAILED')), []);
  await context.close();
});

test('the language is the browser\'s until the user chooses one, and is kept', async () => {
  const { page, close } = await openPage(browser, server.url, { locale: 'de-AT' });
  const language = () => page.locator('html').getAttribute('lang');
  const opened = () => page.waitForFunction(() => globalThis.pxpl5?.frames > 0);
  assert.equal(await language(), 'de', 'as the browser');
  await page.keyboard.press('?');
  assert.equal(await page.getByTestId('choice-de').getAttribute('aria-checked'), 'true');
  const { digest } = await settled(page);
  await Promise.all([page.waitForNavigation(), page.getByTestId('choice-en').click()]);
  await opened();
  assert.equal(await language(), 'en', 'as chosen');
  assert.equal((await settled(page)).digest, digest, 'the picture is the same');
  await page.goto(server.url);
  await opened();
  assert.equal(await language(), 'en', 'kept');
  await page.goto(inLanguage('de'));
  await opened();
  assert.equal(await language(), 'de', 'as the address says');
  await close();
  const other = await openPage(browser, server.url, { locale: 'fr-FR' });
  assert.equal(await other.page.locator('html').getAttribute('lang'), 'en', 'no French');
  await other.close();
});
