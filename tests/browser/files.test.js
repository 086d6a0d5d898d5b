// Files that enter and leave the page: volumes by path, by drop and built in; meshes, pictures,
// sessions; what is wrong is said in a sentence and changes nothing; long work can be given up.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { browser, byId, openPage, page, serve, server, usePage } from './harness.js';
import { after, drop, errorsShown, lookAtPicture, rawSocket, say, settled, state, stateWhen }
  from './steps.js';

const STL_HEADER_BYTES = 84;
const STL_TRIANGLE_BYTES = 50;
const SIDE = 24;  // Voxels of the ball that is dropped, along each axis.

usePage();

/** Does what makes the page save a file, and returns its name and bytes. */
async function saved(act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return { name: download.suggestedFilename(), bytes: readFileSync(await download.path()) };
}

/** Opens a volume by the path field. */
async function openPath(text) {
  await byId('open-panel').click();
  await byId('open-path').fill(text);
  await byId('open-go').click();
}

/** Opens a small volume by its card. */
async function openTorus() {
  await byId('open-panel').click();
  await byId('phantom-torus').click();
  await stateWhen(page, now => now.volume?.source === 'phantom:torus' && !now.busy);
}

/** Closes the messages that are shown; notes may just be going by themselves. */
async function closeMessages() {
  await byId('toasts').evaluate(root => {
    for (const button of root.querySelectorAll('button')) button.click();
  });
  await byId('open').evaluate(dialog => dialog.close());
}

/** A ball in a NRRD file: voxels are their distance from its surface, positive inside. */
function writeBall(file) {
  const values = new Float32Array(SIDE ** 3);
  const middle = (SIDE - 1) / 2;
  for (let z = 0, at = 0; z < SIDE; z++) {
    for (let y = 0; y < SIDE; y++) {
      for (let x = 0; x < SIDE; x++, at++) {
        values[at] = SIDE / 3 - Math.hypot(x - middle, y - middle, z - middle);
      }
    }
  }
  const header = ['NRRD0004', 'type: float', 'dimension: 3', `sizes: ${SIDE} ${SIDE} ${SIDE}`,
                  'space: left-posterior-superior', 'space directions: (1,0,0) (0,1,0) (0,0,1)',
                  'space origin: (0,0,0)', 'endian: little', 'encoding: raw', '', ''].join('\n');
  writeFileSync(file, Buffer.concat([Buffer.from(header), Buffer.from(values.buffer)]));
}

test('the mesh is saved as STL with as many triangles as the state says', async () => {
  await settled(page);
  const { surfaces } = await state(page);
  await byId('save-menu').click();
  await byId('export-format').selectOption('stl');
  const { name, bytes } = await saved(() => byId('export-go').click());
  assert.match(name, /^\S+\.stl$/);
  const count = bytes.readUInt32LE(STL_HEADER_BYTES - 4);
  assert.equal(bytes.length, STL_HEADER_BYTES + count * STL_TRIANGLE_BYTES);
  const shown = surfaces.filter(({ visible }) => visible);
  assert.equal(count, shown.reduce((sum, { triangles }) => sum + triangles, 0));
});

test('a mesh is closed at cuts if asked for, and its certificate is there', async () => {
  const told = () => page.getByTestId('toast-info').last();
  for (const closed of [false, true]) {
    await byId('save-menu').click();
    await byId('export-format').selectOption('obj');
    await byId('save-cap').setChecked(closed);
    await saved(() => byId('export-go').click());
    await told().getByText(closed ? ', closed' : 'open: see').waitFor();
    const { name, bytes } = await saved(() => told().getByTestId('saved-certificate').click());
    assert.match(name, /certificate\.json$/);
    const { cap, surfaces } = JSON.parse(bytes.toString());
    assert.equal(cap, closed);
    assert.equal(surfaces.every(({ certificate }) => certificate.closed), closed);
    const colors = await saved(() => told().getByTestId('saved-colors').click());
    assert.match(colors.bytes.toString(), /^newmtl bone/m);
    await told().getByRole('button').click();
  }
});

test('a mesh is smoothed and decimated as the dialog says', async () => {
  await byId('save-menu').click();
  await byId('export-format').selectOption('ply');
  await byId('save-cap').setChecked(false);
  await byId('save-keep').selectOption('within 0.5 mm');
  await byId('save-smoothing').selectOption('smoothed a little');
  await saved(() => byId('export-go').click());
  const { bytes } = await saved(() => page.getByTestId('toast-info').last()
    .getByTestId('saved-certificate').click());
  const { keep, error_mm: error, smoothing, surfaces } = JSON.parse(bytes.toString());
  assert.deepEqual([keep, error, smoothing], [0, 0.5, 10]);  // No share was asked for.
  assert.ok(surfaces.every(each => each.moved_mm <= 0.5 && each.smoothing.farthest_mm > 0));
  await page.getByTestId('toast-info').last().getByRole('button').click();
  await byId('save-menu').click();
  await byId('save-keep').selectOption('all triangles');
  await byId('save-smoothing').selectOption('not smoothed');
  await page.keyboard.press('Escape');
});

test('the picture is saved as PNG in the size of the state', async () => {
  const { size } = await state(page);
  await byId('save-menu').click();
  const { name, bytes } = await saved(() => byId('snapshot').click());
  assert.match(name, /\.png$/);
  assert.equal(bytes.subarray(1, 4).toString(), 'PNG');
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], size);
});

test('a saved session, opened again, shows the same picture', async () => {
  const done = await after(page, async () => {
    await byId('stage').focus();
    await page.keyboard.press('ArrowRight');
    await byId('iso-bone').fill('260.5');
    await byId('iso-bone').press('Enter');
    await stateWhen(page, now => now.surfaces.some(each => each.isovalue === 260.5));
  });
  await byId('save-menu').click();
  const { name, bytes } = await saved(() => byId('session-save').click());
  assert.match(bytes.toString(), /^load "?phantom:pelvis/m);
  assert.match(bytes.toString(), /260\.5/);
  const file = path.join(server.folder, name);
  writeFileSync(file, bytes);

  await openPath('phantom:sphere');
  await stateWhen(page, now => now.volume.source === 'phantom:sphere');
  await settled(page);
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await stateWhen(page, now => now.volume?.source === 'phantom:pelvis' &&
    now.surfaces.some(each => each.isovalue === 260.5) && !now.busy);
  assert.equal((await settled(page)).digest, done.digest);
});

test('a built-in volume opens by its card, and is never shown empty', async () => {
  await openTorus();
  const { volume, surfaces } = await state(page);
  await settled(page);
  assert.match(await page.title(), new RegExp(volume.name));
  assert.ok(surfaces.length > 0);
});

test('a wrong path is told in a sentence, and what was open stays', async () => {
  const before = await settled(page);
  const wrong = path.join(server.folder, 'there-is-no-such.nrrd');
  await openPath(wrong);
  await byId('open-error').waitFor();
  const [sentence] = await errorsShown(page);
  assert.ok(sentence.includes('there-is-no-such.nrrd'), sentence);
  assert.equal(await byId('open-path').inputValue(), wrong, 'the path can be mended');
  assert.ok(await byId('open').isVisible());
  assert.match(sentence, /\w+ \w+ \w+/);
  assert.equal((await settled(page)).digest, before.digest);
  await closeMessages();
});

test('a file that is no volume is told in a sentence, and what was open stays', async () => {
  const before = await settled(page);
  const file = path.join(server.folder, 'broken.nrrd');
  writeFileSync(file, 'NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\nshort');
  await openPath(file);
  await byId('open-error').waitFor();
  assert.match((await errorsShown(page))[0], /broken\.nrrd/);
  assert.equal((await settled(page)).digest, before.digest);
  await closeMessages();
});

test('a file that is dropped on the page is opened, with a first surface', async () => {
  const folder = path.join(server.folder, 'mine');
  mkdirSync(folder);
  const file = path.join(folder, 'ball.nrrd');
  writeBall(file);
  await drop(page, [file]);
  const { volume, surfaces } = await stateWhen(page,
    (now, side) => now.volume?.size.every(each => each === side), SIDE);
  await settled(page);
  assert.match(volume.name, /ball/);
  assert.ok(surfaces.length > 0, 'a first visit is never empty');
});

test('a surface of the dropped ball has the area of a ball', async () => {
  await byId('surface-add').click();
  const { surfaces } = await stateWhen(page, now => now.surfaces.length > 1);
  const name = surfaces.at(-1).name;
  await byId(`iso-${name}`).fill('0.0001');
  await byId(`iso-${name}`).press('Enter');
  const set = await stateWhen(page, (now, name) =>
    now.surfaces.some(each => each.name === name && Math.abs(each.isovalue) < 0.001), name);
  const { area_mm2 } = set.surfaces.find(each => each.name === name);
  const expected = 4 * Math.PI * (SIDE / 3) ** 2;
  assert.ok(Math.abs(area_mm2 / expected - 1) < 0.02, `${area_mm2} mm2, a ball has ${expected}`);
});

/** Begins to open a volume that takes long. */
async function openLong() {
  await byId('open-panel').click();
  await byId('open').locator('details').evaluate(details => { details.open = true; });
  await byId('open-smooth').fill('6');
  await byId('open-resample').fill('480x480x400');
  await byId('open-path').fill('phantom:pelvis');
  await byId('open-go').click();
}

test('long work is shown and can be given up; what was open stays', async () => {
  const before = await settled(page);
  await openPath('phantom:pelvis resample');  // A blank is part of the path: no such phantom.
  await byId('open-error').waitFor();
  await closeMessages();
  await openLong();
  await byId('cancel').click();
  await byId('work').waitFor({ state: 'hidden' });
  const { volume, surfaces } = await stateWhen(page, now => !now.busy);
  // GPs have dropped the old volume once the new one came: then the scene is empty, and says so.
  if (volume) assert.equal((await settled(page)).digest, before.digest);
  else assert.deepEqual(surfaces, []);
  assert.match((await errorsShown(page)).join(' '), /cancel|given up/i);
  await closeMessages();
});

test('an orbit is given up by the same button', async () => {
  if (!(await state(page)).volume) await openTorus();  // The test before may leave none.
  const before = await settled(page);
  const raw = await rawSocket(page, server.url);
  const reply = say(raw, 'orbit 3000');
  await byId('cancel').click();
  assert.equal((await reply).error, 'canceled');
  await byId('work').waitFor({ state: 'hidden' });
  assert.equal((await settled(page)).digest, before.digest);
});

test('when nothing is open any more, no old picture is shown', async () => {
  const small = await serve('phantom:sphere', 'resample=16x16x16', '--set', 'gp.memory_mib=1');
  try {
    const { page, close } = await openPage(browser, small.url);
    await settled(page);
    assert.ok((await lookAtPicture(page)).colors > 100);
    const reply = await say(await rawSocket(page, small.url), 'load phantom:pelvis');
    assert.match(reply.error, /memory/, 'GPs that hold so little had dropped the sphere by then');
    await stateWhen(page, now => now.volume === null && !now.busy);
    assert.equal((await lookAtPicture(page)).colors, 1);
    assert.equal(await page.locator('#corner').isVisible(), false);
    await close();
  } finally {
    const how = await small.stop();
    assert.equal(how.code, 0, how.errors);
  }
});
