// The volume of a part of a surface, as a measurement.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { lookAtPicture, middleOf, rawSocket, say, saved, settled, state, stateWhen }
  from '../steps.js';

usePage();

const listed = () => byId('measure-list').locator('li');
const count = wanted => page.waitForFunction(wanted => document.querySelectorAll(
  '[data-testid=measure-list] > li').length === wanted, wanted);

test('a click on bone measures the volume of the part there', async () => {
  await settled(page);
  await byId('tab-measure').click();
  await byId('choice-part').click();
  await byId('measure-mode').click();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.click(x, y - 60);
  await count(1);
  await shoot(page, 'part');
  const file = String(await saved(page, () => byId('measure-csv').click()));
  const csv = file.split('\r\n')[1].split(',');
  const { surfaces } = await state(page);
  const bone = surfaces.find(each => each.name === 'bone');
  assert.equal(csv[2], 'part');
  assert.equal(csv[4], 'ml');
  assert.deepEqual(csv.slice(17, 20), ['bone', String(bone.isovalue), 'no']);
  const socket = await rawSocket(page, server.url);
  const { result } = await say(socket, 'components bone');
  const solid = result.largest[0];
  assert.ok(!solid.cavity);
  const own = result.largest.filter(each => each.cavity_of === 1);
  const sum = own.reduce((all, each) => all + each.volume_ml, solid.volume_ml);
  // The reply lists the ten largest alone; the others are tiny cavities.
  assert.ok(Math.abs(Number(csv[3]) - sum) < 1e-3 * sum, `${csv[3]}, not ${sum}`);
  assert.match(await listed().first().textContent(), /\d ml part.*bone at 250\.5, [\d,.]+ cm²/);
  assert.match(await byId('measure-lines').locator('text').first().textContent(),
               /^1: [\d,]+ ml$/);
});

test('beside the surfaces there is no part, and the place of a part stays', async () => {
  const { x, y, width, height } = await byId('stage').boundingBox();
  await page.mouse.click(x + 100, y + 40);
  await byId('measure-message').getByText('There is no surface').waitFor();
  await count(1);
  await byId('measure-choose-1').click();
  assert.match(await byId('measure-end-0').getAttribute('aria-label'), /The place of a part stays/);
  await byId('measure-end-0').focus();
  await page.keyboard.press('ArrowRight');
  await byId('measure-message').getByText('The place of a part stays').waitFor();
  // A drag from the place turns the view: it is no end.
  const before = (await state(page)).camera.azimuth_deg;
  await page.keyboard.press('Escape');
  const from = { x: x + width / 2, y: y + height / 2 - 60 };
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + 50, from.y, { steps: 4 });
  await page.mouse.up();
  await stateWhen(page, (now, was) => now.camera.azimuth_deg !== was, before);
});

test('what a click measures is chosen at the click', async () => {
  const { x, y } = await middleOf(byId('stage'));
  await byId('choice-part').click();
  await byId('measure-mode').click();
  await page.mouse.click(x, y - 60);
  await byId('choice-note').click();
  await count(2);
  assert.match(await listed().nth(1).textContent(), /ml part/);
  assert.equal(await byId('note-editor').count(), 0);
  await page.keyboard.press('Escape');
  await byId('measure-delete-2').click();
  await count(1);
});

test('a session keeps the part as it was measured, after the surface has changed', async () => {
  const before = await listed().first().textContent();
  await byId('iso-bone').fill('400.5');
  await byId('iso-bone').press('Enter');
  await stateWhen(page, now => now.surfaces.some(each => each.isovalue === 400.5));
  assert.equal(await listed().first().textContent(), before);
  await byId('save-menu').click();
  const session = await saved(page, () => byId('session-save').click());
  const file = path.join(server.folder, 'part.pxpl5');
  await writeFile(file, session);
  await byId('measure-delete-1').click();
  await count(0);
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await count(1);
  await byId('measure-choose-1').waitFor();
  assert.match(await listed().first().textContent(), /bone at 250\.5,/);
  assert.ok((await lookAtPicture(page)).colors > 100);
});
