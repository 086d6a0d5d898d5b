// The page while a volume or a session opens: nothing of the volume before, the progress of an
// upload, the reason of a failure, and advice that can be followed.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { writeSeries } from './dicom.js';
import { holdMessages } from './holding.js';
import { browser, byId, openPage, page, server, usePage } from './harness.js';
import { after, errorsShown, lookAtPicture, rawSocket, say, settled, state, stateWhen }
  from './steps.js';

const PLANES = ['axial', 'coronal', 'sagittal'];

usePage();

/** A NRRD file of a ball whose slices are shifted sideways by that much per slice. */
function writeSheared(name, shift, side = 12) {
  const values = new Float32Array(side ** 3).map((_, i) => {
    const at = [i % side, Math.floor(i / side) % side, Math.floor(i / side ** 2)];
    return side / 3 - Math.hypot(...at.map(each => each - (side - 1) / 2));
  });
  const header = ['NRRD0004', 'type: float', 'dimension: 3', `sizes: ${side} ${side} ${side}`,
                  'space: left-posterior-superior',
                  `space directions: (1,0,0) (0,1,0) (0,${shift},1)`, 'space origin: (0,0,0)',
                  'endian: little', 'encoding: raw', '', ''].join('\n');
  const file = path.join(server.folder, name);
  writeFileSync(file, Buffer.concat([Buffer.from(header), Buffer.from(values.buffer)]));
  return file;
}

async function openPath(at, text) {
  await at.getByTestId('open-panel').click();
  await at.getByTestId('open-path').fill(text);
  await at.getByTestId('open-go').click();
}

/** In the page: whether a canvas has one color only. */
function isBlank(canvas) {
  if (canvas.width === 0) return true;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return new Uint32Array(data.buffer).every((pixel, _, all) => pixel === all[0]);
}

test('a new volume clears picture, slices and crosshair at once', async () => {
  const held = await openPage(browser, server.url, { script: holdMessages });
  const at = id => held.page.getByTestId(id);
  await settled(held.page);
  for (const plane of PLANES) {
    await held.page.waitForFunction(plane => document.querySelector(
      `[data-testid=slice-${plane}]`).getAttribute('aria-label').includes('of'), plane);
  }
  await held.page.evaluate(() => { globalThis.holds = 'binary'; });
  await openPath(held.page, 'phantom:torus');
  await stateWhen(held.page, now => now.volume?.source === 'phantom:torus' && !now.busy);
  assert.match(await at('title-volume').innerText(), /torus/);
  await held.page.evaluate(() => new Promise(drawn =>
    requestAnimationFrame(() => requestAnimationFrame(drawn))));
  assert.equal((await lookAtPicture(held.page)).colors, 1, 'the pelvis under the name of a torus');
  for (const plane of PLANES) assert.ok(await at(`slice-${plane}`).evaluate(isBlank), plane);
  assert.equal(await at('crosshair').getAttribute('visibility'), 'hidden');
  for (const number of [0, 1, 2]) assert.equal(await at(`slice-count-${number}`).innerText(), '');

  await held.page.evaluate(() => globalThis.release());
  await settled(held.page);
  assert.ok((await lookAtPicture(held.page)).colors > 100);
  await at('slice-count-0').getByText('/').waitFor();
  await held.close();
});

test('a pane is labeled by the slice that it shows', async () => {
  const held = await openPage(browser, server.url, { script: holdMessages });
  const count = held.page.getByTestId('slice-count-0');
  await count.getByText('/').waitFor();
  const before = await count.innerText();
  await held.page.evaluate(() => { globalThis.holds = 'binary'; });
  await held.page.getByTestId('slice-index-0').fill('3');
  assert.equal(await count.innerText(), before, 'the slice that is still shown');
  await held.page.evaluate(() => globalThis.release());
  await count.getByText(/^4 \//).waitFor();
  await held.close();
});

/**
 * In the page: changes the view and asks for a slice at once, so that the server has both before
 * it can begin to refine; reports which of the two came first, the slice or four samples.
 */
function askWhileDrawing(self) {
  return new Promise(resolve => {
    const order = [];
    let drawn = false;
    self.socket.addEventListener('message', ({ data }) => {
      if (typeof data === 'string') return;
      const view = new DataView(data);
      const isFrame = view.getUint32(0, true) === 0x46523550;
      const samples = isFrame ? view.getUint8(18) : 0;
      drawn ||= isFrame && samples === 1;
      // A refined picture before the first frame of the new view is of the view before.
      if (isFrame && (samples === 1 || !drawn)) return;
      order.push(isFrame ? `${samples} samples` : 'slice');
      if (order.length === 2) resolve(order);
    });
    void self.do('view 77 11');
    void self.ask({ ask: 'slice', axis: 'z', index: 5 });
  });
}

test('a slice is answered before the picture is refined', async () => {
  const raw = await rawSocket(page, server.url);
  assert.deepEqual(await raw.evaluate(askWhileDrawing), ['slice', '4 samples']);
});

test('a session that fails half-way says so until it is read, and the scene is back', async () => {
  await openPath(page, 'phantom:pelvis');
  await stateWhen(page, now => now.volume?.source === 'phantom:pelvis' && !now.busy);
  const before = await after(page, async () => {
    await byId('stage').focus();
    await page.keyboard.press('ArrowRight');
  });
  const file = path.join(server.folder, 'half.pxpl5');
  writeFileSync(file, 'load phantom:sphere\nload gone.nrrd\nload phantom:letters\n');
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await page.getByTestId('toast-error').waitFor();
  await stateWhen(page, now => !now.busy);
  await settled(page);
  const told = (await errorsShown(page)).join(' ');
  assert.match(told, /gone\.nrrd.*open again/s);
  assert.equal((await settled(page)).digest, before.digest);
  const { volume, undo } = await state(page);
  assert.equal(volume.source, 'phantom:pelvis');
  assert.equal(undo, before.state.undo, 'what was done can still be undone');
  await page.getByTestId('toast-error').getByRole('button').click();
  assert.deepEqual(await errorsShown(page), []);
});

test('a later success takes the message of a failed opening away', async () => {
  const raw = await rawSocket(page, server.url);
  const file = path.join(server.folder, 'gone.pxpl5');
  writeFileSync(file, 'load nothing.nrrd\nload phantom:torus\n');
  await byId('save-menu').click();
  await byId('session-open').setInputFiles(file);
  await page.getByTestId('toast-error').waitFor();
  assert.equal((await say(raw, 'info')).ok, true);
  await byId('open-panel').click();
  await byId('phantom-torus').click();
  await page.getByTestId('toast-error').waitFor({ state: 'detached' });
});

test('a tilt is told from 0.1 degrees on, and never as 0.0', async () => {
  await byId('tab-slices').click();
  await openPath(page, writeSheared('straight.nrrd', 0.0004));
  await stateWhen(page, now => now.volume?.source.endsWith('straight.nrrd') && !now.busy);
  await byId('slice-count-2').getByText('/ 12').waitFor();
  await settled(page);
  assert.equal(await byId('slices-notes').innerText(), '');
  const shift_mm = Math.tan(5 * Math.PI / 180);
  await openPath(page, writeSheared('sheared.nrrd', shift_mm));
  await byId('slices-notes').getByText(/slices are sheared by 5\.0°/).waitFor();
  for (const [modality, words] of [['CT', 'gantry was tilted'], ['MR', 'slices are sheared']]) {
    const folder = path.join(server.folder, modality);
    writeSeries(folder, [{ description: 'Head', side: 12, modality, shift_mm }]);
    await openPath(page, folder);
    await stateWhen(page, (now, is) => now.volume?.modality === is && !now.busy, modality);
    await byId('slices-notes').getByText(new RegExp(`${words} by 5\\.0°`)).waitFor();
  }
});

test('slices say what the picture hides', async () => {
  const note = byId('slices-beyond'), raw = await rawSocket(page, server.url);
  const { surfaces } = await state(page);
  assert.equal(await note.isVisible(), false);
  assert.equal((await say(raw, 'clip L')).ok, true);
  await note.getByText('Not in the 3D picture: parts behind clip planes.').waitFor();
  assert.equal((await say(raw, `components ${surfaces[0].name} show=largest`)).ok, true);
  await note.getByText(`behind clip planes and components of ${surfaces[0].name}.`).waitFor();
  const { result, text } = await say(raw, 'slice z 5');
  assert.match(result.hidden_in_3d.join(), /^clip L [-\d.]+,components of /);
  assert.match(text, /the 3D picture hides parts that the slice shows: clip L /);
  for (const line of ['clip off', `components ${surfaces[0].name} show=all`]) {
    assert.equal((await say(raw, line)).ok, true);
  }
  await note.waitFor({ state: 'hidden' });
});

test('an upload tells its name in a line and its progress, of one file, too', async () => {
  const slow = await openPage(browser, server.url);
  const session = await slow.context.newCDPSession(slow.page);
  await session.send('Network.enable');
  await session.send('Network.emulateNetworkConditions', { offline: false, latency: 0,
    downloadThroughput: -1, uploadThroughput: 400_000 });
  const file = path.join(server.folder, 'a-scan-of-somebody.nrrd');
  writeFileSync(file, Buffer.alloc(4_000_000));
  await slow.page.getByTestId('open-panel').click();
  await slow.page.getByTestId('open-files').setInputFiles(file);
  const box = slow.page.getByTestId('uploading');
  await box.waitFor();
  const text = await box.locator('p').boundingBox();
  assert.ok(text.width > 120 && text.height < 60, `a text of ${JSON.stringify(text)}`);
  await slow.page.waitForFunction(() => {
    const bar = document.querySelector('[data-testid=uploading] progress');
    return bar === null || bar.value > 0;
  });
  const share = await box.locator('progress').evaluate(bar => bar.position);
  assert.ok(share > 0 && share < 1, `a share of ${share}`);
  await box.getByRole('button').click();
  await box.waitFor({ state: 'detached' });
  assert.deepEqual(await errorsShown(slow.page), []);
  await slow.close();
});

test('every option of `load` that an error may advise has a field', async () => {
  const raw = await rawSocket(page, server.url);
  const { text } = await say(raw, 'help load');
  const options = [...text.matchAll(/\b(\w+)=/g)].map(([, name]) => name);
  assert.ok(options.includes('spacing'), text);
  for (const name of options) assert.equal(await byId(`open-${name}`).count(), 1, name);
  const file = path.join(server.folder, 'bare.raw');
  writeFileSync(file, Buffer.alloc(8 * 8 * 8, 7));
  await byId('open-panel').click();
  await byId('open').locator('details').evaluate(details => { details.open = true; });
  await byId('open-path').fill(file);
  await byId('open-raw').fill('8x8x8,uint8');
  await byId('open-spacing').fill('1,1,2');
  await byId('open-read').selectOption('gps');
  await byId('open-gradient').selectOption('smooth');
  await byId('open-go').click();
  const { volume } = await stateWhen(page, now => now.volume?.size.every(each => each === 8));
  assert.deepEqual(volume.spacing_mm, [1, 1, 2]);
  assert.match(await byId('volume-facts').innerText(), /Shading\s*smooth/);
  assert.match((await say(raw, 'history')).text, /bare\.raw gradient=smooth .*read=gps/);
});

test('no text names a control that is not there', async () => {
  // No modality, no air, no bone: no tissues to choose.
  const { surfaces } = await state(page);
  for (const { name } of surfaces) {
    await byId(`choose-${name}`).click();
    await byId(`surface-remove-${name}`).click();
  }
  await byId('no-surfaces').waitFor();
  assert.doesNotMatch(await byId('no-surfaces').innerText(), /tissue/);
  const watcher = await openPage(browser, server.watchUrl);
  for (const tab of ['measure', 'inspector']) {
    await watcher.page.getByTestId(`tab-${tab}`).click();
    assert.doesNotMatch(await watcher.page.getByTestId(`${tab}-message`).innerText(), /Press/);
  }
  await watcher.close();
});
