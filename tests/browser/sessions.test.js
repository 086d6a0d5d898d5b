// Sessions: a saved one is the scene with its volume's identity and the page's own part. Opening
// one writes no file, asks for a volume that is missing, and never shows another volume.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { byId, page, server, usePage } from './harness.js';
import { after, errorsShown, middleOf, settled, state, stateWhen, unfold } from './steps.js';
import { writeEllipsoid } from './volumes.js';

usePage();

async function openPath(text) {
  await byId('open-panel').click();
  await byId('open-path').fill(text);
  await byId('open-go').click();
  await stateWhen(page, (now, text) => now.volume?.source === text && !now.busy, text);
  await settled(page);
}

/** Saves the session; returns the file. */
async function saveSession(name) {
  await byId('save-menu').click();
  const [download] = await Promise.all([page.waitForEvent('download'),
    byId('session-save').click()]);
  const file = path.join(server.folder, name);
  writeFileSync(file, readFileSync(await download.path()));
  return file;
}

/** Saves the picture; returns its name and bytes. */
async function savePicture() {
  await byId('save-menu').click();
  const [download] = await Promise.all([page.waitForEvent('download'), byId('snapshot').click()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

async function openSession(file) {
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
}

/** What the page alone knows. */
async function ownPart() {
  return { window: await byId('slices-window').inputValue(),
           level: await byId('slices-level').inputValue(),
           slices: await Promise.all([0, 1, 2].map(n => byId(`slice-index-${n}`).inputValue())),
           distances: await byId('measure-list').locator('b').allTextContents() };
}

/** Makes a scene with all that a session has. */
async function makeScene() {
  await unfold(page);
  await after(page, async () => {
    await byId('stage').focus();
    await page.keyboard.press('ArrowRight');
    await byId('iso-bone').fill('261.5');
    await byId('iso-bone').press('Enter');
    await byId('clip-add-P').click();
    await stateWhen(page, now => now.clips.length === 1 &&
      now.surfaces.some(({ isovalue }) => isovalue === 261.5));
  });
  await byId('slices-window').fill('777');
  await byId('slices-window').press('Enter');
  await byId('slice-index-0').fill('7');
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const { x, y } = await middleOf(byId('stage'));
  await page.mouse.click(x - 20, y - 40);
  await page.mouse.click(x + 20, y - 40);
  await byId('measure-list').locator('b').waitFor();
  await byId('leave-mode').click();
  await byId('tab-slices').click();
}

test('a session is the scene: opened again, picture, window, crosshair and distances are the same',
     async () => {
  await openPath('phantom:torus');
  await openPath('phantom:pelvis');
  await makeScene();
  const before = { ...await settled(page), own: await ownPart(), picture: await savePicture() };
  const file = await saveSession('scene.pxpl5');
  const script = readFileSync(file, 'utf8');
  assert.equal(script.match(/^load /gm).length, 1, 'the scene, not the way to it');
  assert.match(script, /^info digest=[0-9a-f]{16} place=[0-9a-f]{16}$/m);

  await openPath('phantom:sphere');
  await byId('tab-measure').click();
  assert.equal(await byId('measure-list').locator('b').count(), 0);
  await byId('tab-slices').click();
  await openSession(file);
  await stateWhen(page, now => now.volume?.source === 'phantom:pelvis' && now.clips.length === 1 &&
    !now.busy);
  assert.equal((await settled(page)).digest, before.digest);
  await byId('measure-list').locator('b').waitFor({ state: 'attached' });
  const { name, bytes } = await savePicture();
  assert.equal(name, before.picture.name);
  assert.ok(bytes.equals(before.picture.bytes), 'another picture was saved');
  assert.deepEqual(await ownPart(), before.own);
  assert.deepEqual(await errorsShown(page), []);
});

test('opening a session writes no file, and says so', async () => {
  const file = path.join(server.folder, 'writes.pxpl5');
  writeFileSync(file, ['load phantom:fetus', 'surface a iso=60', 'snapshot there.png',
                       'export there.stl', ''].join('\n'));
  const before = readdirSync(server.folder);
  await openSession(file);
  await stateWhen(page, now => now.volume?.source === 'phantom:fetus' &&
    now.surfaces.length === 1 && !now.busy);
  await byId('toasts').getByText(/2 commands of the session write files/).waitFor();
  assert.deepEqual(readdirSync(server.folder), before);
});

test('a session whose volume is missing asks for it and continues with the files', async () => {
  const folder = path.join(server.folder, 'data');
  mkdirSync(folder);
  const volume = writeEllipsoid(path.join(folder, 'egg.nrrd'), [24, 24, 24], [9, 9, 11]);
  await openPath(volume);
  const { surfaces } = await state(page);
  await byId(`iso-${surfaces[0].name}`).fill('0.25');
  await byId(`iso-${surfaces[0].name}`).press('Enter');
  await stateWhen(page, now => now.surfaces[0].isovalue === 0.25);
  const before = await settled(page);
  const file = await saveSession('egg.pxpl5');
  const away = path.join(folder, 'away.nrrd');
  renameSync(volume, away);
  await openPath('phantom:sphere');
  await openSession(file);
  await byId('open-error').getByText(/egg\.nrrd.*egg\.pxpl5 continues with the files/s).waitFor();
  assert.equal((await state(page)).volume.source, 'phantom:sphere');
  await byId('open-files').setInputFiles(away);
  await stateWhen(page, now => now.surfaces[0]?.isovalue === 0.25 && !now.busy);
  assert.equal((await settled(page)).digest, before.digest);
});

test('a session refuses another volume at its volume\'s place', async () => {
  const place = path.join(server.folder, 'place.nrrd');
  writeEllipsoid(place, [24, 24, 24], [9, 9, 11]);
  await openPath(place);
  const file = await saveSession('place.pxpl5');
  await openPath('phantom:torus');
  const before = await settled(page);
  writeEllipsoid(place, [24, 24, 24], [9, 9, 10]);
  await openSession(file);
  await byId('open-error').getByText(/place\.nrrd is not the volume that was wanted/).waitFor();
  await page.keyboard.press('Escape');
  assert.equal((await settled(page)).digest, before.digest);
  assert.equal((await state(page)).volume.source, 'phantom:torus');
});

test('a session of dropped files opens again while the server keeps them', async () => {
  const file = writeEllipsoid(path.join(server.folder, 'dropped.nrrd'), [20, 20, 20], [8, 8, 8]);
  await byId('open-panel').click();
  await byId('open-files').setInputFiles(file);
  await stateWhen(page, now => now.volume?.source.endsWith('dropped.nrrd') && !now.busy);
  const before = await settled(page);
  await byId('save-menu').click();
  assert.match(await byId('session-note').innerText(), /Keep the files that you dropped/);
  await page.keyboard.press('Escape');
  const session = await saveSession('dropped.pxpl5');
  await openPath('phantom:sphere');
  await byId('save-menu').click();
  assert.doesNotMatch(await byId('session-note').innerText(), /dropped/);
  await page.keyboard.press('Escape');
  await openSession(session);
  await stateWhen(page, now => now.volume?.source.endsWith('dropped.nrrd') && !now.busy);
  assert.equal((await settled(page)).digest, before.digest);
});

test('a session of dropped files that are gone asks for them', async () => {
  const file = writeEllipsoid(path.join(server.folder, 'gone.nrrd'), [22, 22, 22], [8, 9, 8]);
  await byId('open-panel').click();
  await byId('open-files').setInputFiles(file);
  const { volume } = await stateWhen(page,
    now => now.volume?.source.endsWith('gone.nrrd') && !now.busy);
  const before = await settled(page);
  const session = await saveSession('gone.pxpl5');
  const ended = path.join(server.folder, 'ended.pxpl5');  // Of a server that has ended.
  writeFileSync(ended, readFileSync(session, 'utf8').replace(server.folder, '/tmp/pxpl5-ended'));
  rmSync(path.dirname(volume.source), { recursive: true });
  for (const each of [session, ended]) {
    await openPath('phantom:sphere');
    await openSession(each);
    const error = byId('open-error');
    await error.getByText(new RegExp(
      `gone\\.nrrd.*${path.basename(each)} continues with the files`, 's')).waitFor();
    for (const text of [await error.innerText(), await byId('open-path').inputValue()]) {
      assert.doesNotMatch(text, /\/uploads\//, 'a folder of the server');
    }
    assert.ok(await byId('open').locator('details').isHidden(), 'the session has its own options');
    await byId('open-files').setInputFiles(file);
    await stateWhen(page, now => now.volume?.source.endsWith('gone.nrrd') && !now.busy);
    assert.equal((await settled(page)).digest, before.digest);
  }
});

test('one undo takes back the flip of a clip plane, at its place', async () => {
  await openPath('phantom:letters');
  await unfold(page);
  await byId('clip-add-R').click();
  await byId('clip-place-R').fill('12');
  const { clips: [before] } = await stateWhen(page, now => now.clips[0]?.words === 'R 12');
  await byId('clip-flip-R').click();
  const { clips } = await stateWhen(page, now => now.clips[0]?.words.startsWith('L'));
  assert.deepEqual(clips.map(({ plane }) => plane), [before.plane.map(each => 0 - each)],
                   'the other side of the same place');
  await byId('undo').click();
  const undone = await stateWhen(page, now => now.clips[0]?.words.startsWith('R'));
  assert.deepEqual(undone.clips, [before]);
});
