// The list of series, the attributes and the hint before saving, in both themes, on a phone and on
// a laptop: axe-core finds nothing, all text can be read, nothing is cut, keys suffice.
import assert from 'node:assert/strict';
import { readFileSync, renameSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from '../dicom.js';
import { browser, openPage, server, shoot, useServer } from '../harness.js';
import { lookFor } from '../layout.js';
import { stateWhen } from '../steps.js';

const axe = readFileSync(path.join(process.env.PXPL5_NODE_MODULES, 'axe-core/axe.min.js'), 'utf8');
const LONG = 'An-unbroken-description-of-64-letters-for-which-a-phone-is-narrow';

useServer();

/** What axe-core finds, faint texts, and parts of the open dialog that are wider than it. */
async function findings(page) {
  await page.evaluate(axe);
  const { violations, passes } = await page.evaluate(() => globalThis.axe.run());
  assert.ok(passes.length > 10, `axe-core checked ${passes.length} rules`);
  const wide = await page.locator('dialog[open]').evaluate(dialog =>
    [dialog, ...dialog.querySelectorAll('*')].filter(each => each.scrollWidth > each.clientWidth + 1
      && each.clientWidth > 0 && !/hidden|clip/.test(getComputedStyle(each).overflowX)
      && each.tagName !== 'INPUT').map(each => `is too wide: ${each.outerHTML.slice(0, 160)}`));
  return [...wide, ...await page.evaluate(lookFor.faintText),
          ...violations.flatMap(({ id, help, nodes }) =>
            nodes.map(({ html }) => `${id}: ${help}: ${html.slice(0, 160)}`))];
}

for (const colorScheme of ['dark', 'light']) {
  for (const [width, height] of [[390, 844], [1280, 720]]) {
    test(`series, attributes and hint can be read and used: ${colorScheme}, ${width} pixels`,
         async () => {
      const folder = path.join(server.folder, `disc-${colorScheme}-${width}`);
      const files = writeSeries(folder, [
        { description: 'Thorax 5 mm', side: 10, patient: 'Doe^Jane', study: 'Chest' },
        { description: LONG, side: 14, patient: 'Doe^Jane', study: 'Chest', bodyPart: 'HEAD' },
        { description: 'Knee', side: 12, modality: 'MR', patient: 'Roe^Rick', study: 'Knee' }]);
      for (const file of files) renameSync(file, path.join(folder, LONG + path.basename(file)));
      // axe-core sets styles in markup, which the page's policy forbids.
      const { page, close } = await openPage(browser, server.url, { colorScheme, bypassCSP: true,
        viewport: { width, height } });
      await page.keyboard.press('o');
      await page.getByTestId('open-path').fill(folder);
      await page.keyboard.press('Enter');
      await page.getByTestId('thumbnail').nth(2).waitFor();
      assert.deepEqual(await findings(page), []);
      await shoot(page, `series-${colorScheme}-${width}`);
      assert.equal(await page.evaluate(() => document.activeElement.dataset.testid), 'series-1');
      await page.keyboard.press('Tab');
      await page.keyboard.press('Enter');
      await stateWhen(page, now => now.volume?.size[2] === 14 && !now.busy);
      await page.locator('dialog[open]').waitFor({ state: 'hidden' });
      await page.getByTestId('tab-volume').click();
      await page.getByTestId('attributes-show').focus();
      await page.keyboard.press('Enter');
      await page.getByRole('cell', { name: 'PatientName' }).waitFor();
      assert.deepEqual(await findings(page), []);
      await shoot(page, `attributes-${colorScheme}-${width}`);
      await page.keyboard.press('Escape');
      await page.keyboard.press('s');
      await page.getByTestId('privacy').filter({ hasText: 'names of its files' }).waitFor();
      assert.deepEqual(await findings(page), []);
      await shoot(page, `save-hint-${colorScheme}-${width}`);
      await close();
    });
  }
}
