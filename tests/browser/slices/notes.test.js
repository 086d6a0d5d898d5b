// Notes: written in place and in the list, kept by files, sessions and saved pictures.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { middleOf, saved, settled, state, stateWhen } from '../steps.js';

usePage(undefined, async () => {
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
});

const listed = () => byId('measure-list').locator('b').allTextContents();
const count = number => page.waitForFunction(number => document.querySelectorAll(
  '[data-testid=measure-list] > li').length === number, number);

const measurements = async () => JSON.parse(await saved(page, () =>
  byId('measure-json').evaluate(button => button.click()))).measurements;

test('a note in a slice is written in place, and again by a click on its text', async () => {
  await byId('choice-measure').click();
  await byId('slices-kind').selectOption('note');
  const at = await middleOf(byId('slice-axial'));
  await page.mouse.click(at.x - 20, at.y);
  await byId('note-editor').waitFor();
  await page.keyboard.press('Escape');
  await byId('note-editor').waitFor({ state: 'detached' });
  assert.deepEqual(await listed(), [], 'Esc keeps no note');
  await page.mouse.click(at.x - 20, at.y);
  await page.keyboard.type('left sacrum');
  await page.keyboard.press('Enter');
  await count(1);
  assert.deepEqual(await listed(), ['left sacrum']);
  // Right above the point, where the text begins.
  await page.mouse.click(at.x - 20 + 30, at.y - 28);
  await byId('note-editor').waitFor();
  assert.equal(await byId('note-editor').inputValue(), 'left sacrum');
  await page.keyboard.type('right sacrum, S2');
  await shoot(page, 'note_editor');
  await page.keyboard.press('Enter');
  assert.deepEqual(await listed(), ['right sacrum, S2']);
  await page.keyboard.press('u');
  assert.deepEqual(await listed(), ['left sacrum']);
  await page.keyboard.press('Control+y');
  assert.deepEqual(await listed(), ['right sacrum, S2']);
  await shoot(page, 'note_slices');
});

test('a note in the picture is in files, sessions and saved pictures', async () => {
  await byId('slice-axial').focus();
  await page.keyboard.press('ArrowRight');  // A session brings the crosshair into the picture.
  await byId('tab-measure').click();
  await byId('choice-note').click();
  await byId('measure-mode').click();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.click(x, y - 60);
  await byId('note-editor').waitFor();
  await page.keyboard.type('promontory, where the pelvis begins');
  await page.keyboard.press('Enter');
  await count(2);
  await page.keyboard.press('Escape');
  const note = (await measurements())[1];
  assert.deepEqual([note.kind, note.text], ['note', 'promontory, where the pelvis begins']);
  const csv = String(await saved(page, () => byId('measure-csv').click()));
  assert.match(csv, /,note,.*"promontory, where the pelvis begins",,,,,,\r\n$/);
  assert.deepEqual((await byId('measure-lines').locator('text').allTextContents()).slice(1),
                   ['promontory, where the', 'pelvis begins']);
  await shoot(page, 'note_picture');
  const picture = async () => saved(page, async () => {
    await byId('save-menu').click();
    await byId('snapshot').click();
  });
  const withNote = await picture();
  await byId('save-menu').click();
  const session = await saved(page, () => byId('session-save').click());
  await byId('measure-choose-2').click();
  await byId('measure-text').fill('L5');
  await byId('measure-text').press('Enter');
  await byId('measure-lines').locator('text', { hasText: 'L5' }).waitFor();
  assert.notDeepEqual(await picture(), withNote, 'the picture shows the text');
  const file = path.join(server.folder, 'notes.pxpl5');
  await writeFile(file, session);
  const { revision } = await state(page);
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await stateWhen(page, (now, was) => now.revision > was && !now.busy, revision);
  await byId('measure-list').getByText('promontory').waitFor();
  await settled(page);
  assert.deepEqual(await picture(), withNote);
});

test('the arrow of a note can be dragged to another place', async () => {
  const before = (await measurements())[1];
  await byId('measure-mode').click();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.move(x, y - 60);
  await page.mouse.down();
  await page.mouse.move(x + 40, y - 20, { steps: 4 });
  await page.mouse.up();
  await page.waitForFunction(() => /move an end/.test(
    document.querySelector('[data-testid=undo]').title));
  const after = (await measurements())[1];
  assert.equal(after.text, before.text);
  assert.notDeepEqual(after.points_mm, before.points_mm);
});

test('a session with a wrong measurement opens without it, and says which', async () => {
  await page.keyboard.press('Escape');
  await byId('save-menu').click();
  const session = String(await saved(page, () => byId('session-save').click()));
  const line = session.split('\n').find(each => each.startsWith('# page '));
  const own = JSON.parse(line.slice('# page '.length));
  own.measurements[0].points_mm = [[1, 2]];
  const file = path.join(server.folder, 'wrong.pxpl5');
  await writeFile(file, session.replace(line, () => `# page ${JSON.stringify(own)}`));
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await byId('toast-error').getByText(
    /Measurement 1 was left out: points_mm is \[\[1,2\]\]/).waitFor();
  assert.equal((await listed()).length, own.measurements.length - 1);
});
