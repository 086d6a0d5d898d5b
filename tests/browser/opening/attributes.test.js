// The DICOM attributes of the open scan, and the hints about names and faces before saving.
import assert from 'node:assert/strict';
import path from 'node:path';
import test from 'node:test';
import { isFound, tagText } from '../../../host/serve/page/volume/attributes.js';
import { factsOf, privacyText } from '../../../host/serve/page/volume/privacy.js';
import { writeSeries } from '../dicom.js';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { ask, rawSocket, stateWhen } from '../steps.js';
import { writeEllipsoid } from '../volumes.js';

usePage();

async function openPath(source, options = '') {
  await byId('open-panel').click();
  await byId('open-path').fill(source);
  if (options) {
    await byId('open').locator('details').evaluate(details => { details.open = true; });
    await byId('open-series').fill(options);
  }
  await byId('open-go').click();
  await stateWhen(page, (now, source) => now.volume?.source === source && !now.busy, source);
  await byId('open').waitFor({ state: 'hidden' });
}

const waitForText = (id, text) => byId(id).filter({ hasText: text }).waitFor();
const rows = () => byId('attributes-table').locator('tbody tr');

test('the attributes are those of the middle slice of the open series, and can be filtered',
     async () => {
  const folder = path.join(server.folder, 'named');
  writeSeries(folder, [{ description: 'Knee', side: 10, patient: 'Doe^Jane' },
    { description: '<i>Head</i>', side: 15, modality: 'MR', patient: 'Doe^Jane',
      study: 'Follow-up', bodyPart: 'HEAD' }]);
  await openPath(folder, '2');
  await byId('tab-volume').click();
  await byId('attributes-show').click();
  await waitForText('attributes-told', / of \d+ attributes of the middle slice, 1-7\.dcm/);
  const all = await rows().count();
  await byId('attributes-filter').fill('series desc');
  assert.deepEqual(await rows().locator('td').allTextContents(),
                   ['(0008,103e)', 'SeriesDescription', 'LO', '<i>Head</i>']);
  await byId('attributes-filter').fill('0020,0013');
  assert.deepEqual(await rows().locator('td').allTextContents(),
                   ['(0020,0013)', 'InstanceNumber', 'IS', '8']);
  assert.match(await byId('attributes-told').innerText(), new RegExp(`^1 of ${all} attributes`));
  await byId('attributes-filter').fill('');
  assert.equal(await rows().count(), all);
  await shoot(page, 'attributes');
  await page.keyboard.press('Escape');
});

test('a click beside a dialog closes it, a selection that ends there does not', async () => {
  await byId('attributes-show').click();
  const dialog = byId('attributes');
  await dialog.waitFor();
  const box = await byId('attributes-filter').boundingBox();
  await page.mouse.move(box.x + 9, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(3, 3);
  await page.mouse.up();
  assert.ok(await dialog.isVisible());
  await page.mouse.click(3, 3);
  await dialog.waitFor({ state: 'hidden' });
});

test('before saving, the page says that the scan names a patient and may show a face', async () => {
  await byId('save-menu').click();
  await waitForText('privacy', /contains a patient's name.*If a head is seen/s);
  await shoot(page, 'save-privacy');
  await page.keyboard.press('Escape');
});

test('a file that is no DICOM file has no attributes, and the hint says what is unknown',
     async () => {
  await openPath(writeEllipsoid(path.join(server.folder, 'ball.nrrd'), [16, 16, 16], [6, 6, 6]));
  await byId('attributes-show').click();
  await waitForText('attributes-told', /ball\.nrrd: holds no DICOM slices/);
  await page.keyboard.press('Escape');
  await byId('save-menu').click();
  await waitForText('privacy', /cannot tell whether the file names a patient/);
  await page.keyboard.press('Escape');
});

test('a built-in volume has neither, and a view-only page may not ask', async () => {
  await byId('open-panel').click();
  await byId('phantom-torus').click();
  await stateWhen(page, now => now.volume?.source === 'phantom:torus' && !now.busy);
  assert.ok(await byId('attributes-show').isHidden());
  await byId('save-menu').click();
  assert.ok(await byId('privacy').isHidden());
  await page.keyboard.press('Escape');
  const raw = await rawSocket(page, server.url);
  await assert.rejects(ask(raw, { ask: 'attributes' }), /no file is open/);
  const watch = await openPage(browser, server.watchUrl);
  const watching = await rawSocket(watch.page, server.watchUrl);
  for (const question of [{ ask: 'attributes' }, { ask: 'series', path: server.folder }]) {
    await assert.rejects(ask(watching, question), /you only watch/);
  }
  await watch.close();
});

test('the hint speaks of a face only where skin and a head are possible', () => {
  const text = facts => privacyText({ isDicom: true, hasName: false, modality: 'CT',
                                      bodyPart: 'CHEST', ...facts });
  assert.equal(text({}), '');
  for (const bodyPart of ['head', 'BRAIN', 'WHOLE BODY', 'EYE', 'CERVICAL NECK', 'HEAD/NECK', 'TMJ',
    'CHEST NECK', 'SCHÄDEL', 'tête']) {
    assert.equal(text({ bodyPart }), `The header states the part "${bodyPart}". If a head is seen, `
      + 'a face can be recognized from the surface of the skin.');
  }
  for (const bodyPart of ['HEART', 'FOREARM', 'KNEE', 'chest/abdomen', 'ABDOMEN PELVIS']) {
    assert.equal(text({ bodyPart }), '', bodyPart);
  }
  assert.match(text({ bodyPart: '' }), /^The header does not state the part of the body\. If/);
  assert.match(text({ bodyPart: '', isDicom: false }), /names a patient\. If the scan shows a/);
  assert.equal(text({ modality: 'US', bodyPart: 'HEAD' }), '');
  assert.match(text({ hasName: true }), /^The header of this scan contains a patient's name/);
  const facts = name => factsOf({ attributes: [[0x10, 0x10, 1, '', 'PN', 'Inner', false],
    [0x10, 0x10, 0, '', 'PN', name, false], [0x18, 0x15, 0, '', 'CS', 'SKULL', false]] });
  assert.deepEqual(facts('^^ ='), { isDicom: true, hasName: false, modality: '',
                                    bodyPart: 'SKULL' });
  assert.equal(facts('X').hasName, true);
});

test('a filter finds all of its words in tag, keyword, representation and value', () => {
  const attribute = [0x18, 0x50, 0, 'SliceThickness', 'DS', '2.5', false];
  assert.equal(tagText(0x18, 0x50), '(0018,0050)');
  for (const filter of ['', 'slice', 'thick 2.5', '0018,0050', 'ds 2']) {
    assert.ok(isFound(attribute, filter), filter);
  }
  for (const filter of ['slice 3', '0018,0051', 'x']) {
    assert.ok(!isFound(attribute, filter), filter);
  }
});
