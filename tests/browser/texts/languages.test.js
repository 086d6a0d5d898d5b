// The page in another language.
import assert from 'node:assert/strict';
import test from 'node:test';

import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { lookFor } from '../layout.js';
import { measureAcross, settled } from '../steps.js';
import { everywhere, inLanguage } from './everywhere.js';

useServer(['phantom:heart', 'resample=48x48x48']);

test('German fits its places in all parts of the page, at 390 and 1280 pixels', async () => {
  const { page, close } = await openPage(browser, inLanguage(server.url, 'de'));
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

test('long words break in narrow places, and have no hyphens for screen readers', async () => {
  const { page, close } = await openPage(browser, inLanguage(server.url, 'de'),
                                         { viewport: { width: 390, height: 844 } });
  const tab = page.getByTestId('tab-surfaces');
  assert.equal(await tab.getAttribute('aria-label'), 'Oberflächen');
  const { word, button } = await tab.evaluate(element => ({
    word: element.querySelector('span').getBoundingClientRect().toJSON(),
    button: element.getBoundingClientRect().toJSON() }));
  assert.ok(word.left >= button.left && word.right <= button.right,
            JSON.stringify({ word, button }));
  const hyphens = await page.evaluate(() => {
    const [text, path] = [document.createElement('p'), document.createElement('p')];
    path.translate = false;
    document.body.append(text, path);
    return [text, path].map(element => getComputedStyle(element).hyphens);
  });
  assert.deepEqual(hyphens, ['auto', 'manual']);
  await close();
});

test('measurements are lost only if the user says so, in the language of the page', async () => {
  const { page, close } = await openPage(browser, inLanguage(server.url, 'de'));
  page.on('dialog', () => assert.fail('a window of the browser has its language'));
  await measureAcross(page);
  await page.getByTestId('measure-list').locator('b').first().waitFor({ state: 'attached' });
  await page.keyboard.press('?');
  const question = page.getByRole('alertdialog', { name: 'Sprache wechseln' });
  const cancel = question.getByRole('button', { name: 'Abbrechen' });
  const focused = locator => locator.evaluate(element => element === document.activeElement);
  for (const no of [() => page.keyboard.press('Escape'), () => cancel.click()]) {
    await page.getByTestId('choice-en').click();
    await question.waitFor();
    assert.match(await question.locator('p').innerText(), /^Ihre Messungen gingen verloren/);
    assert.ok(await focused(cancel), 'Enter does nothing that cannot be undone');
    await shoot(page, 'german-1280-question');
    await no();
    await question.waitFor({ state: 'detached' });
    await page.locator('[data-testid=choice-de][aria-checked=true]:focus').waitFor();
    assert.ok(await page.getByTestId('help-sheet').isVisible(), 'Esc closes the question alone');
    assert.equal(await page.getByTestId('measure-list').locator('b').count(), 1);
  }
  await page.getByTestId('choice-en').click();
  await Promise.all([page.waitForNavigation(),
    question.getByRole('button', { name: 'Sprache wechseln' }).click()]);
  await page.locator('html[lang=en]').waitFor({ state: 'attached' });
  await close();
});

test('without its texts, the page is in English', async () => {
  const { page, complaints, context } = await openPage(browser, inLanguage(server.url, 'de'), {
    refused: '**/de.js*' });
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
  await page.goto(inLanguage(server.url, 'de'));
  await opened();
  assert.equal(await language(), 'de', 'as the address says');
  await close();
  const other = await openPage(browser, server.url, { locale: 'fr-FR' });
  assert.equal(await other.page.locator('html').getAttribute('lang'), 'en', 'no French');
  await other.close();
});
