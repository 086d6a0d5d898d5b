// Pairs of pictures with depths: the page composes them exactly at rest, and warps them on the way.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, usePage } from '../harness.js';
import { after, middleOf, say, settled, socketWithoutSkin } from '../steps.js';
import { pixelsOf, warpedAndLate } from '../warp/screen.js';
import { keepFrames, loadModules, PAINTERS } from '../warp/warping.js';

const MODES = ['anaglyph', 'sbs', 'cross', 'rows'];
const MOST_OFF = 3;          // Of 255: the anaglyph of a painter and that of the host.
const LEAST_PSNR_DB = 26;    // Of a warped picture a few degrees aside, in means of 4 x 4 pixels.
const LEAST_GAIN_DB = 4;     // Over the picture as it was.

let raw;

usePage(['phantom:pelvis', 'resample=96x96x72', '--set', 'heartbeat.misses=0'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

test('at rest, the page composes exactly the picture of the host', async () => {
  await say(raw, 'view 25 10 fit=yes');
  const plain = await openPage(browser, `${server.url}&warp=off`);
  for (const mode of MODES) {
    await after(page, () => say(raw, `stereo ${mode}`));
    const { digest } = await settled(page);
    assert.equal((await settled(plain.page)).digest, digest);
    assert.equal(await pixelsOf(plain.page), await pixelsOf(page), mode);
    assert.equal(await byId('badge-digest').textContent(), digest);
  }
  await plain.close();
});

/** Runs in the page: a kept pair, composed exactly and by a painter at the viewpoint drawn for. */
async function compare([name, index, mode]) {
  const { modules, kept } = globalThis;
  const load = name => import(new URL(name, location.href).href);
  const { drawPair } = await load('picture/compose.js');
  const { camerasAt } = await load('picture/camera.js');
  const { partsOf } = await load('picture/stereo.js');
  const { message } = kept.at(index);
  const { header, picture, depths } = modules.messages.parseFrame(message);
  const pair = await createImageBitmap(new Blob([picture], { type: 'image/png' }));
  const { width, height } = header;
  const leans = await Promise.all(depths.map(each => modules.lean.unpack(each, width, height)));
  const context = document.createElement('canvas').getContext('2d');
  drawPair(context, pair, mode);
  const exact = context.getImageData(0, 0, context.canvas.width, height);
  const canvas = document.createElement('canvas');
  const painter = modules.painterOf(name, canvas);
  painter.take(pair, leans);
  const { camera, background } = globalThis.pxpl5.state, stereo = { mode, separation_mm: 0,
    convergence_mm: 0 };
  const cameras = camerasAt(camera, camera, width / height, stereo);
  const begin = mode === 'anaglyph' ? 'beginAnaglyph' : 'begin';
  painter[begin](width * partsOf(mode).length, height, background);
  partsOf(mode).forEach((part, place) => part.eyes.forEach(eye => {
    const { patient_to_clip: clip } = cameras[eye];
    painter.draw(eye, modules.camera.multiply(clip, modules.camera.inverse(clip)), 1, 1,
                 { left: width * (mode === 'anaglyph' ? eye : place), width, height,
                   rows: mode === 'rows' ? eye : undefined });
  }));
  painter.end();
  const found = modules.read(canvas);
  let most = 0, colors = 0;
  for (let at = 0; at < found.length; at++) {
    most = Math.max(most, Math.abs(exact.data[at] - found[at]));
    colors += exact.data[at] !== exact.data[at % 4] ? 1 : 0;
  }
  painter.gl?.getExtension('WEBGL_lose_context').loseContext();
  return { most, colors, views: header.views };
}

test('at the viewpoint drawn for, painters compose the picture of the host', async t => {
  const keeping = await openPage(browser, `${server.url}&video=off`, { script: keepFrames });
  await keeping.page.evaluate(loadModules);
  for (const mode of MODES) {
    const { revision } = await after(keeping.page, () => say(raw, `stereo ${mode}`));
    let index = -1;
    for (let tries = 0; tries < 8 && index < 0; tries++) {
      if (tries > 0) await after(keeping.page, () => say(raw, `view ${25 + tries} 10`));
      index = await keeping.page.evaluate(revision =>
        globalThis.kept.findIndex(each => each.revision >= revision), revision);
      if (index >= 0 && tries > 0) index = -2;
    }
    for (const painter of PAINTERS) {
      const { most, colors, views } = await keeping.page.evaluate(
        compare, [painter, index === -2 ? -1 : index, mode]);
      t.diagnostic(`${painter}, ${mode}: off by ${most} of 255 at most`);
      assert.equal(views, 2);
      assert.ok(colors > 10_000, `${colors}`);
      assert.ok(most <= (mode === 'anaglyph' ? MOST_OFF : 0), `${painter}, ${mode}: ${most}`);
    }
  }
  await keeping.close();
});

test('while the machine is late, both eyes follow the pointer', async t => {
  for (const mode of MODES) {
    await after(page, () => say(raw, `stereo ${mode} separation=120`));
    await after(page, () => say(raw, 'view anterior fit=yes'));
    const { x, y } = await middleOf(byId('stage'));
    const { found, before } = await warpedAndLate(page, { x: x - 100, y },
                                                  `stereo-warped-${mode}`);
    t.diagnostic(`${mode}: ${found.toFixed(1)} dB, as it was ${before.toFixed(1)} dB`);
    assert.ok(found >= LEAST_PSNR_DB && found >= before + LEAST_GAIN_DB, `${found} ${before} dB`);
  }
});
