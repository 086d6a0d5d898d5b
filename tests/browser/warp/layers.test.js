// Pictures with one transparent surface, as on the first visit: the page gets two layers, and
// shows both from the newest viewpoint.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, drag, middleOf, rawSocket, say, settled, state } from '../steps.js';
import { checkWarped, LEAST_PSNR_DB, pixelsOf, similarity, whileStopped } from './screen.js';
import { compareMoving, comparePictures, keepFrames, loadModules, meanSimilarity, PAINTERS,
         sameSize, warpedFrame, watchMoving } from './warping.js';

const SCREEN_GAIN_DB = 3;   // On the screen, where the background counts, too.
const ROUNDING = 1;         // Of a blended channel.
const TRIES = 10;

let raw;

// A GP is stopped below, which is no failure of the machine here.
usePage(['phantom:pelvis', 'resample=128x128x96', '--set', 'heartbeat.misses=0'], async () => {
  raw = await rawSocket(page, server.url);
});

/** Shows a view; returns the number of the kept frame of two layers. */
async function layersOf(page, view) {
  await after(page, () => say(raw, 'view 200 40'));
  const { revision } = await after(page, () => say(raw, view));
  await page.waitForFunction(revision =>
    globalThis.layered.some(each => each.revision === revision), revision);
  return page.evaluate(revision =>
    globalThis.layered.findLastIndex(each => each.revision === revision), revision);
}

/** The same for two views. A busy machine may draw one of them smaller: then both come again. */
async function pairOf(page, ...views) {
  for (let tries = 0; tries < TRIES; tries++) {
    const pair = [];
    for (const view of views) pair.push(['layered', await layersOf(page, view)]);
    if (await page.evaluate(sameSize, pair)) return pair;
  }
  throw new Error(`${views}: no pictures of one size in ${TRIES} tries`);
}

async function openKeeping() {
  const keeping = await openPage(browser, `${server.url}&video=off`, { script: keepFrames });
  await keeping.page.evaluate(loadModules);
  return keeping;
}

test('on the first visit the picture follows the first drag, although its skin is transparent',
     async t => {
  const { surfaces } = await state(page);
  assert.deepEqual(surfaces.map(each => [each.visible, each.opacity < 1]),
                   [[true, false], [true, true]]);
  await settled(page);
  await page.waitForFunction(() => globalThis.pxpl5.warp.ready);
  const at = await middleOf(byId('stage'));
  const late = await byId('stage').screenshot();
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const warped = await whileStopped(async () => {
    await page.mouse.move(at.x + 9, at.y + 5);
    await page.waitForFunction(() => globalThis.pxpl5.warp.warped);
    await shoot(page, 'warp-first-visit');
    return byId('stage').screenshot();
  });
  await page.waitForFunction(() => !globalThis.pxpl5.warp.warped);
  const { digest } = await settled(page);
  const exact = await byId('stage').screenshot();
  await page.mouse.up();
  const [found, before] = [await similarity(page, warped, exact),
                          await similarity(page, late, exact)];
  t.diagnostic(`${found.toFixed(1)} dB, as it was ${before.toFixed(1)} dB`);
  assert.ok(found >= LEAST_PSNR_DB && found >= before + SCREEN_GAIN_DB, `${found} ${before} dB`);
  const plain = await openPage(browser, `${server.url}&warp=off`);
  assert.equal((await settled(plain.page)).digest, digest);
  assert.equal(await pixelsOf(plain.page), await pixelsOf(page));
  await plain.close();
});

test('a page that comes while the picture rests can follow the pointer, too', async () => {
  await settled(page);
  const late = await openPage(browser, server.url);
  await settled(late.page);
  await late.page.waitForFunction(() => globalThis.pxpl5.warp.ready);
  const at = await middleOf(late.page.getByTestId('stage'));
  await late.page.mouse.move(at.x, at.y);
  await late.page.mouse.down();
  await whileStopped(async () => {
    await late.page.mouse.move(at.x + 20, at.y);
    await late.page.waitForFunction(() => globalThis.pxpl5.warp.warped);
  });
  await late.page.mouse.up();
  await settled(late.page);
  await late.close();
});

test('from the viewpoint drawn for, the layers are blended exactly', async () => {
  const keeping = await openKeeping();
  for (const view of ['view anterior fit=yes', 'view 30 15 roll=5', 'view 90 60']) {
    const index = await layersOf(keeping.page, view);
    for (const painter of PAINTERS) {
      const { differing, covered, background } = await keeping.page.evaluate(
        warpedFrame, [painter, 'layered', index, ROUNDING]);
      assert.equal(differing, 0, `${painter}, ${view}: ${differing} differ, of ${covered}`);
      assert.ok(covered > 2000 && background > 2000, `${covered} ${background}`);
    }
    const db = await keeping.page.evaluate(meanSimilarity, index);
    assert.ok(db > LEAST_PSNR_DB, `${view}: beside the resting picture ${db} dB`);
  }
  await keeping.close();
});

test('from a viewpoint aside, the warped layers are nearly the exact picture', async t => {
  const keeping = await openKeeping();
  await after(keeping.page, () => say(raw, 'view 30 15 roll=0 fit=yes'));
  const { zoom, pan_mm } = (await state(keeping.page)).camera;
  const from = { azimuth_deg: 30, elevation_deg: 15, zoom };
  const moves = { '5 degrees': { azimuth_deg: 35 }, '3 degrees up': { elevation_deg: 18 },
                  zoomed: { zoom: Number((zoom * 1.1).toFixed(4)) } };
  for (const [name, view] of Object.entries(moves)) {
    const words = now => `view ${now.azimuth_deg} ${now.elevation_deg} roll=0 zoom=${now.zoom} ` +
      `pan=${pan_mm}`;
    const pair = await pairOf(keeping.page, words(from), words({ ...from, ...view }));
    const found = await keeping.page.evaluate(comparePictures, pair);
    for (const painter of PAINTERS) checkWarped(t, `${painter}, ${name}`, found[painter]);
  }
  await keeping.close();
});

test('the canvas below shows the blended layers of a moving picture', async () => {
  const keeping = await openKeeping();
  await settled(keeping.page);
  await keeping.page.evaluate(watchMoving);
  const at = await middleOf(keeping.page.getByTestId('stage'));
  await after(keeping.page, () => drag(keeping.page, at, { x: at.x + 90, y: at.y + 20 },
                                       { steps: 12 }));
  const { differing, covered } = await keeping.page.evaluate(compareMoving, 2 * ROUNDING);
  assert.ok(covered > 2000 && differing === 0, `${differing} differ; ${covered} show a surface`);
  await keeping.close();
});
