// A warped picture is hatched where it does not know what is there.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, middleOf, say, settled, socketWithoutSkin, state } from '../steps.js';
import { keptOf, MOST_UNLIKE, whileStopped } from './screen.js';
import { hatchedPixels, keepFrames, loadModules, PAINTERS } from './warping.js';

const LEAST_HATCHED = 0.9;   // Share of the unknown pixels that show a surface.
const MOST_FALSE = 0.25;     // Hatched pixels that show the background, per pixel of a surface.

let raw;

// A GP is stopped below, which is no failure of the machine here.
usePage(['phantom:pelvis', 'resample=128x128x96', '--set', 'heartbeat.misses=0'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

/** Checks the result of hatchedPixels(). */
function checkHatched(t, name, found, isLarge) {
  t.diagnostic(`${name}: of ${found.covered} pixels with a surface ${found.unknown} are ` +
    `unknown, ${found.hatched} hatched; hatched before the background: ${found.false}; ` +
    `other painter: ${(100 * found.unlike).toFixed(2)} % differ`);
  assert.ok(found.unlike < MOST_UNLIKE, `${name}: the painters differ in ${found.unlike}`);
  assert.equal(found.changed, 0, `${name}: ${found.changed} known pixels are hatched`);
  assert.equal(found.untested, 0, `${name}: ${found.untested} pixels differ if all are tested`);
  if (name.endsWith('nowhere')) {
    assert.deepEqual([found.unknown, found.hatched, found.false], [0, 0, 0]);
    return;
  }
  assert.ok(found.unknown > 50, `${name}: ${found.unknown} are unknown`);
  assert.ok(found.hatched >= LEAST_HATCHED * found.unknown,
            `${name}: ${found.hatched} of ${found.unknown} are hatched`);
  assert.ok(isLarge || found.false <= MOST_FALSE * found.covered,
            `${name}: ${found.false} hatched pixels show the background`);
}

test('unknown surfaces are hatched, known ones never', async t => {
  const keeping = await openPage(browser, `${server.url}&video=off`, { script: keepFrames });
  await keeping.page.evaluate(loadModules);
  await after(keeping.page, () => say(raw, 'view 30 15 roll=0 fit=yes'));
  const { zoom, pan_mm: [right, up] } = (await state(keeping.page)).camera;
  const viewOf = ({ azimuth = 30, elevation = 15, size = zoom, pan = [right, up] }) =>
    `view ${azimuth} ${elevation} roll=0 zoom=${size.toFixed(4)} pan=${pan}`;
  const large = 3 * zoom;
  const moves = { nowhere: [{}, {}], '5 degrees': [{}, { azimuth: 35 }],
                  '20 degrees': [{}, { azimuth: 50 }], '15 degrees up': [{}, { elevation: 30 }],
                  '40 degrees': [{}, { azimuth: 70 }],
                  moved: [{ size: large }, { size: large, pan: [right + 25, up] }],
                  smaller: [{ size: large }, { size: 2 * zoom }] };
  for (const [name, [from, to]] of Object.entries(moves)) {
    const pair = [await keptOf(raw, keeping.page, viewOf(from)),
                  await keptOf(raw, keeping.page, viewOf(to))];
    const found = await keeping.page.evaluate(hatchedPixels, pair.map(index => ['kept', index]));
    for (const painter of PAINTERS) {
      checkHatched(t, `${painter}, ${name}`, found[painter], Boolean(from.size));
    }
  }
  await keeping.close();
});

/** How many pixels of a screenshot have the color of the hatch's lines. */
function inkOf(page, screenshot) {
  return page.evaluate(async file => {
    const bytes = Uint8Array.from(atob(file), each => each.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const { background } = globalThis.pxpl5.state;  // Dark here: the ink is light.
    const lines = [1, 3, 5].map(at => 0.6 * parseInt(background.slice(at, at + 2), 16)
      + 0.4 * 204);
    let count = 0;
    for (let at = 0; at < data.length; at += 4) {
      count += lines.every((part, k) => Math.abs(data[at + k] - part) <= 3) ? 1 : 0;
    }
    return count;
  }, screenshot.toString('base64'));
}

test('a large drag without the machine shows the hatch, and the status line explains it',
     async () => {
  await after(page, () => say(raw, 'view anterior fit=yes'));
  await page.waitForFunction(() => globalThis.pxpl5.warp.ready);
  const at = await middleOf(byId('stage'));
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const before = await inkOf(page, await byId('stage').screenshot());
  await whileStopped(async () => {
    for (const [name, x, y] of [['small', 12, 4], ['large', 60, 20]]) {
      await page.mouse.move(at.x + x, at.y + y, { steps: 4 });
      await page.waitForFunction(() => globalThis.pxpl5.warp.warped);
      await page.evaluate(() => new Promise(requestAnimationFrame));
      await shoot(page, `warp-hatched-${name}`);
    }
    const ink = await inkOf(page, await byId('stage').screenshot());
    assert.ok(ink > before + 500, `${ink} pixels have the color of hatch lines, ${before} before`);
    assert.match(await byId('badge-quality').getAttribute('title'), /Hatched parts are not known/);
  });
  await page.mouse.up();
  await settled(page);
});
