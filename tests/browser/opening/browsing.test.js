// The file browser of the dialog Open: only allowed folders, by keyboard, names as text; and the
// recent files.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, statSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from '../dicom.js';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { ask, errorsShown, rawSocket, say, stateWhen } from '../steps.js';
import { writeEllipsoid } from '../volumes.js';

const MARKUP = '<img src=x onerror="globalThis.ran=1">.nrrd';
const FILES = 503;
let scans;

usePage(undefined, async () => {
  scans = path.join(server.folder, 'scans');
  mkdirSync(path.join(scans, 'knee'), { recursive: true });
  writeEllipsoid(path.join(scans, 'knee', 'left.nrrd'), [16, 16, 16], [6, 6, 6]);
  writeFileSync(path.join(scans, 'knee', MARKUP), 'no volume');
  writeFileSync(path.join(scans, 'knee', 'notes.txt'), 'text');
  writeSeries(path.join(scans, 'ct'), [{ description: 'Hip', side: 11 }]);
  mkdirSync(path.join(scans, 'many'));
  for (let i = 0; i < FILES; i++) writeFileSync(path.join(scans, 'many', `${i}.dcm`), '');
});

const entry = name => byId('browse-entry').filter({ hasText: name });
const names = () => byId('browse-entry').locator('.name').allTextContents();

/** Opens the dialog, which lists the allowed folder, and goes to a folder below it. */
async function browse(...folders) {
  if (!await byId('open').isVisible()) await byId('open-panel').click();
  await byId('browse-list').waitFor();
  while (await byId('browse-up').isEnabled()) {
    const from = await byId('browse-path').innerText();
    await byId('browse-up').click();
    await page.waitForFunction(from =>
      document.querySelector('[data-testid=browse-path]').textContent !== from, from);
  }
  for (const name of [server.folder, 'scans', ...folders]) {
    await entry(name).first().click();
    await page.waitForFunction(name => document.querySelector('[data-testid=browse-path]')
      .textContent.endsWith(name), name);
  }
}

test('a folder is listed with kinds, sizes and dates, and names stay text', async () => {
  await browse('knee');
  assert.deepEqual(await names(), [MARKUP, 'left.nrrd']);
  const row = await entry('left.nrrd').innerText();
  const { size } = statSync(path.join(server.folder, 'scans', 'knee', 'left.nrrd'));
  assert.match(row, new RegExp(`NRRD\\s+${size < 10_000 ? (size / 1000).toFixed(1)
    : Math.round(size / 1000)} kB`));
  assert.match(row, new RegExp(`\\b${new Date().getFullYear()}-\\d\\d-\\d\\d`));
  assert.equal(await page.evaluate(() => globalThis.ran), undefined);
  assert.match(await byId('browse-told').innerText(), /2 entries\. 1 other file not shown\./);
  await byId('browse-all').check();
  await entry('notes.txt').waitFor();
  await byId('browse-all').uncheck();
  await entry('notes.txt').waitFor({ state: 'detached' });
  await shoot(page, 'open-browser');
});

test('the keyboard alone finds and opens a file, and the focus is told', async () => {
  await browse();
  await byId('browse-list').focus();
  assert.deepEqual(await names(), ['ct', 'knee', 'many']);
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('ArrowDown');
  const active = await byId('browse-list').getAttribute('aria-activedescendant');
  assert.equal(await page.locator(`[id="${active}"] .name`).innerText(), 'knee');
  assert.equal(await page.locator(`[id="${active}"]`).getAttribute('aria-selected'), 'true');
  assert.equal(await byId('open-path').inputValue(), path.join(scans, 'knee'));
  await page.keyboard.press('Enter');
  await entry('left.nrrd').waitFor();
  await page.keyboard.press('End');
  await page.keyboard.press('Enter');
  const file = path.join(scans, 'knee', 'left.nrrd');
  await stateWhen(page, (now, file) => now.volume?.source === file && !now.busy, file);
  await byId('open').waitFor({ state: 'hidden' });
  assert.deepEqual(await errorsShown(page), []);
});

test('Backspace goes to the folder above and stays on where it came from', async () => {
  await browse('many');
  await byId('browse-list').focus();
  await page.keyboard.press('Backspace');
  await entry('knee').waitFor();
  assert.equal(await page.locator('[aria-selected=true] .name').innerText(), 'many');
});

test('a folder that is chosen while the dialog opens stays', async () => {
  await browse('knee');
  await page.keyboard.press('Escape');
  await byId('open').waitFor({ state: 'hidden' });
  await page.evaluate(() => {
    document.querySelector('[data-testid=open-panel]').click();
    document.querySelector('[data-testid=browse-up]').click();
  });
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=browse-path]').textContent.endsWith('/scans'));
  await entry('knee').waitFor();
});

test('a folder of DICOM opens by its path', async () => {
  await browse('ct');
  assert.equal(await byId('open-path').inputValue(), path.join(scans, 'ct'));
  await byId('open-go').click();
  await stateWhen(page, now => now.volume?.size[2] === 11 && !now.busy);
});

test('a long folder says how many are left, and a part of a name finds them', async () => {
  await browse('many');
  assert.equal((await names()).length, 500);
  assert.match(await byId('browse-told').innerText(),
               new RegExp(`first 500 of ${FILES} entries\\. Type a part of a name`));
  await byId('browse-find').fill('50');
  await entry('502.dcm').waitFor();
  assert.deepEqual(await names(), ['50.dcm', '150.dcm', '250.dcm', '350.dcm', '450.dcm',
    '500.dcm', '501.dcm', '502.dcm']);
  await page.keyboard.press('Escape');
});

test('nothing leads out of the allowed folders', async () => {
  const outside = mkdtempSync(path.join(tmpdir(), 'pxpl5-outside-'));
  try {
    writeFileSync(path.join(outside, 'secret.nrrd'), '');
    symlinkSync(outside, path.join(scans, 'way-out'));
    const raw = await rawSocket(page, server.url);
    for (const wrong of [outside, path.join(scans, 'way-out'), '/', '/etc',
      `${server.folder}/..`, `${scans}/way-out/..`, `${scans}/../..`]) {
      await assert.rejects(ask(raw, { ask: 'folder', path: wrong }),
                           /is outside of the folders that the browser may read/, wrong);
    }
    const { json } = await ask(raw, { ask: 'folder', path: scans });
    assert.deepEqual(json.entries.map(({ name }) => name), ['ct', 'knee', 'many']);
    assert.equal(json.links_out, 1);
    await browse();
    assert.match(await byId('browse-told').innerText(), /1 link to places .* may not read/);
    await page.keyboard.press('Escape');
  } finally {
    rmSync(path.join(scans, 'way-out'), { force: true });
    rmSync(outside, { recursive: true });
  }
});

test('a phone shows names and sizes without scrolling sideways', async () => {
  const phone = await openPage(browser, server.url, { viewport: { width: 390, height: 844 } });
  const at = id => phone.page.getByTestId(id);
  await at('open-panel').click();
  for (const name of ['scans', 'knee']) {
    await at('browse-entry').filter({ hasText: name }).first().click();
  }
  const row = at('browse-entry').filter({ hasText: 'left.nrrd' });
  await row.waitFor();
  await shoot(phone.page, 'open-browser-390');
  for (const part of [at('open'), at('browse-list'), row]) {
    const { scrollWidth, clientWidth } = await part.evaluate(
      ({ scrollWidth, clientWidth }) => ({ scrollWidth, clientWidth }));
    assert.ok(scrollWidth <= clientWidth, `${scrollWidth} of ${clientWidth}`);
  }
  await phone.close();
});

test('a view-only page cannot browse', async () => {
  const watch = await openPage(browser, server.watchUrl);
  const raw = await rawSocket(watch.page, server.watchUrl);
  await assert.rejects(ask(raw, { ask: 'folder', path: '' }), /you only watch/);
  assert.ok(await watch.page.getByTestId('open-panel').isDisabled());
  await watch.page.keyboard.press('o');
  assert.equal(await watch.page.getByTestId('open').isVisible(), false);
  await watch.close();
});

test('files that were opened are listed until they are cleared, uploads and built-in ones not',
     async () => {
  const raw = await rawSocket(page, server.url);
  await say(raw, 'load phantom:sphere');  // Not from this page.
  await byId('open-panel').click();
  await byId('phantom-torus').click();
  await stateWhen(page, now => now.volume?.source === 'phantom:torus' && !now.busy);
  await byId('open-panel').click();
  assert.deepEqual(await byId('recent-file').allTextContents(), ['scans/ct', 'knee/left.nrrd']);
  await byId('recent-file').nth(1).click();
  const file = path.join(scans, 'knee', 'left.nrrd');
  await stateWhen(page, (now, file) => now.volume?.source === file && !now.busy, file);
  await page.reload();
  await byId('open-panel').click();
  assert.deepEqual(await byId('recent-file').allTextContents(), ['knee/left.nrrd', 'scans/ct']);
  await byId('recent-clear').click();
  assert.ok(await byId('recent').isHidden());
  await page.reload();
  await byId('open-panel').click();
  await byId('browse-list').waitFor();
  assert.ok(await byId('recent').isHidden());
});

test('dialogs and panels have their names for screen readers', async () => {
  await page.keyboard.press('Escape');
  for (const [button, name] of [['open-panel', 'Open a volume'], ['save-menu', 'Save'],
                                ['help', 'Help']]) {
    await byId(button).click();
    assert.equal(await page.getByRole('dialog', { name, exact: true }).count(), 1, name);
    await page.keyboard.press('Escape');
  }
  await byId('tab-volume').click();
  assert.equal(await page.getByRole('tabpanel', { name: 'Volume', exact: true }).count(), 1);
});
