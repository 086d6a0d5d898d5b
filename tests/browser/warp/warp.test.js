// The newest picture from the newest viewpoint: decoded depths, cameras, warped pictures, and what
// is on the screen while the machine is late.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import path from 'node:path';
import test from 'node:test';
import { bin, browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, drag, middleOf, say, settled, socketWithoutSkin, state, stateWhen, unfold }
  from '../steps.js';
import { checkWarped, keptOf, LEAST_PSNR_DB, pixelsOf, warpedAndLate, whileStopped }
  from './screen.js';
import { comparePictures, keepFrames, loadModules, PAINTERS, warpedFrame } from './warping.js';

const SEED = process.env.PXPL5_SEED ?? '1993';
const SCREEN_GAIN_DB = 4;  // On the screen, where the background counts, too.
const STOPPED_MS = 1000;

let raw;

// A GP is stopped below, which is no failure of the machine here.
usePage(['phantom:pelvis', 'resample=128x128x96', '--set', 'heartbeat.misses=0'], async () => {
  // The transparent skin of the phantom is the subject of layers.test.js.
  raw = await socketWithoutSkin(page, server.url);
});

/** A page that keeps its resting frames of one sample with depths. */
async function openKeeping() {
  const keeping = await openPage(browser, `${server.url}&video=off`, { script: keepFrames });
  await keeping.page.evaluate(loadModules);
  return keeping;
}

test(`the page decodes what the server packed, bit for bit (seed ${SEED})`, async () => {
  const lines = execFileSync(path.join(bin, '../tests/test_lean_depth_cases'), [SEED],
                             { encoding: 'utf8', maxBuffer: 1 << 26 }).trim().split('\n');
  assert.ok(lines.length > 30);
  let count = 0;
  for (const line of lines) {
    const wanted = JSON.parse(line);
    const found = await page.evaluate(async ({ packed, width, height }) => {
      const { unpack } = await import(new URL('picture/lean_depths.js', location.href).href);
      const lean = await unpack(new Uint8Array(packed), width, height);
      return { ...lean, corners: [...lean.corners], mask: [...lean.mask] };
    }, wanted);
    const { columns, rows, corners, mask, seams } = wanted;
    assert.deepEqual(found, { columns, rows, corners, mask, seams }, wanted.name);
    count += seams.length;
  }
  assert.ok(count > 100, `${count} seams`);
});

test('depths of another size are refused with both numbers', async () => {
  const said = await page.evaluate(async () => {
    const { unpack } = await import(new URL('picture/lean_depths.js', location.href).href);
    const packing = new Blob([new Uint8Array(10)]).stream()
      .pipeThrough(new CompressionStream('deflate-raw'));
    const packed = new Uint8Array(await new Response(packing).arrayBuffer());
    return unpack(packed, 8, 4).catch(error => error.message);
  });
  assert.match(said, /10 bytes, but a picture of 8 x 4 pixels with 0 seams has 17/);
});

test('the page and the server have the same cameras', async () => {
  let random = Number(SEED);
  const next = (least, most) => {
    random = (random * 1103515245 + 12345) % 2147483648;
    return least + (most - least) * random / 2147483648;
  };
  await page.evaluate(loadModules);
  for (let i = 0; i < 40; i++) {
    const pan = [next(-80, 80), next(-80, 80)].map(mm => mm.toFixed(2));
    const angles = [next(0, 360), next(-90, 90)].map(degrees => degrees.toFixed(2)).join(' ');
    const { revision } = await say(raw, `view ${angles} roll=${next(-180, 180).toFixed(2)} ` +
      `zoom=${next(0.3, 8).toFixed(4)} pan=${pan}`);
    const { camera, size } = await stateWhen(page, (now, wanted) => now.revision >= wanted,
                                             revision);
    const own = await page.evaluate(([camera, size]) => {
      const found = globalThis.modules.camera.cameraAt(camera, camera, size[0] / size[1]);
      return { eye: found.patient_to_eye, clip: found.patient_to_clip };
    }, [camera, size]);
    [[own.eye, camera.patient_to_eye], [own.clip, camera.patient_to_clip]].forEach(([a, b]) =>
      a.forEach((value, k) => assert.ok(Math.abs(value - b[k]) <= 1e-6,
        `element ${k}: the page has ${value}, the server ${b[k]} of ${JSON.stringify(camera)}`)));
  }
});

test('a drag leads to the view that the page has shown', async () => {
  await after(page, () => say(raw, 'view anterior fit=yes'));
  const at = await middleOf(byId('stage'));
  let random = Number(SEED) + 7;
  const next = most => {
    random = (random * 1103515245 + 12345) % 2147483648;
    return (random / 2147483648 - 0.5) * 2 * most;
  };
  for (let i = 0; i < 6; i++) {
    const steps = [0, 1, 2].map(() => ({ x: at.x + next(150), y: at.y + next(150) }));
    let shown;
    const now = await after(page, async () => {
      await page.mouse.move(at.x, at.y);
      await page.mouse.down();
      for (const step of steps) await page.mouse.move(step.x, step.y, { steps: 4 });
      shown = await page.evaluate(() => new Promise(take => requestAnimationFrame(() =>
        take(globalThis.pxpl5.warp.view))));
      await page.mouse.up();
    });
    const { camera } = now.state;
    for (const key of ['elevation_deg', 'zoom']) {
      assert.ok(Math.abs(camera[key] - shown[key]) < 1e-6, `${key} ${camera[key]} ${shown[key]}`);
    }
    for (const key of ['azimuth_deg', 'roll_deg']) {
      const turned = camera[key] - shown[key];
      assert.ok(Math.abs(turned - 360 * Math.round(turned / 360)) < 1e-6,
                `${key} ${camera[key]} ${shown[key]}`);
    }
  }
});

test('from the viewpoint drawn for, the warped picture is the picture', async () => {
  const keeping = await openKeeping();
  const index = await keptOf(raw, keeping.page, 'view 30 15 roll=5 fit=yes');
  for (const painter of PAINTERS) {
    const { differing, covered, background } = await keeping.page.evaluate(
      warpedFrame, [painter, 'kept', index, 0]);
    assert.equal(differing, 0, `${painter}: ${differing} pixels differ, of ${covered}`);
    assert.ok(covered > 10_000 && background > 10_000, `${covered} ${background}`);
  }
  await keeping.close();
});

test('from a viewpoint aside, the warped picture is nearly the exact one', async t => {
  const keeping = await openKeeping();
  await after(keeping.page, () => say(raw, 'view 30 15 roll=0 fit=yes'));
  const { zoom, pan_mm } = (await state(keeping.page)).camera;
  const moves = { '1 degree': { azimuth_deg: 31 }, '5 degrees': { azimuth_deg: 35 },
                  '3 degrees up': { elevation_deg: 18 },
                  moved: { pan_mm: [pan_mm[0] + 12, pan_mm[1] - 7] },
                  zoomed: { zoom: Number((zoom * 1.1).toFixed(4)) } };
  for (const [name, view] of Object.entries(moves)) {
    const from = { azimuth_deg: 30, elevation_deg: 15, roll_deg: 0, zoom, pan_mm };
    const words = now => `view ${now.azimuth_deg} ${now.elevation_deg} roll=0 zoom=${now.zoom} ` +
      `pan=${now.pan_mm}`;
    const pair = [await keptOf(raw, keeping.page, words(from)),
                  await keptOf(raw, keeping.page, words({ ...from, ...view }))];
    const found = await keeping.page.evaluate(comparePictures,
                                              pair.map(index => ['kept', index]));
    for (const painter of PAINTERS) checkWarped(t, `${painter}, ${name}`, found[painter]);
  }
  await keeping.close();
});

test('while a GP is stopped the picture follows the pointer, and rests exact afterwards',
     async () => {
  await after(page, () => say(raw, 'view anterior fit=yes'));
  const at = await middleOf(byId('stage'));
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x + 8, at.y);
  await page.waitForFunction(() => globalThis.pxpl5.warp.draws > 0);
  await whileStopped(async () => {
    // What was under way when the GPs stopped may still arrive.
    let frames = -1, last;
    const pictures = new Set();
    const begin = performance.now();
    for (let i = 1; i < 8 || performance.now() - begin < STOPPED_MS; i++) {
      await page.mouse.move(at.x + 8 + 6 * i, at.y + 2 * i);
      await page.evaluate(() => new Promise(requestAnimationFrame));
      const now = await page.evaluate(() => globalThis.pxpl5.frames);
      if (i === 3) frames = now;
      if (i >= 3) pictures.add((await byId('stage').screenshot()).toString('base64'));
      last = { frames: now, i };
    }
    assert.equal(last.frames, frames, 'the machine draws although its GPs are stopped');
    assert.equal(pictures.size, last.i - 2, 'each move shows another picture');
    assert.ok(await page.evaluate(() => globalThis.pxpl5.warp.warped));
    assert.match(await byId('badge-quality').textContent(), /^warped\b/);
    assert.equal(await byId('badge-digest').textContent(), '');
    await shoot(page, 'warp-stopped');
  });
  await page.mouse.up();
  await page.waitForFunction(() => !globalThis.pxpl5.warp.warped);
  const rested = await settled(page);
  assert.match(await byId('badge-quality').textContent(), /^lossless/);
  assert.equal(await byId('badge-digest').textContent(), rested.digest);
  const plain = await openPage(browser, `${server.url}&warp=off`);
  assert.equal((await settled(plain.page)).digest, rested.digest);
  assert.equal(await pixelsOf(plain.page), await pixelsOf(page));
  await plain.close();
});

test('the screen shows where the picture will be', async t => {
  await after(page, () => say(raw, 'view anterior fit=yes'));
  const { found, before } = await warpedAndLate(page, await middleOf(byId('stage')));
  t.diagnostic(`${found.toFixed(1)} dB, as it was ${before.toFixed(1)} dB`);
  assert.ok(found >= LEAST_PSNR_DB && found >= before + SCREEN_GAIN_DB, `${found} ${before} dB`);
});

test('the view on the screen never goes back while it turns one way', async () => {
  await after(page, () => say(raw, 'view 180 0 roll=0 fit=yes'));
  const at = await middleOf(byId('stage'));
  await page.evaluate(() => {
    const seen = { views: [], warped: 0, frames: globalThis.pxpl5.frames, ends: false };
    globalThis.seen = seen;
    const look = () => {
      const { view, warped } = globalThis.pxpl5.warp;
      seen.views.push(view.azimuth_deg);
      seen.warped += warped ? 1 : 0;
      if (!seen.ends) requestAnimationFrame(look);
    };
    look();
  });
  await page.mouse.move(at.x - 200, at.y);
  await page.mouse.down();
  for (let i = -200; i <= 200; i += 4) await page.mouse.move(at.x + i, at.y);
  await page.mouse.up();
  await settled(page);
  const { views, warped, frames } = await page.evaluate(() => {
    globalThis.seen.ends = true;
    return { ...globalThis.seen, frames: globalThis.pxpl5.frames - globalThis.seen.frames };
  });
  assert.ok(warped > 3 && frames > 3, `${warped} warped, ${frames} frames`);
  const back = views.findIndex((azimuth, k) => k > 0 && azimuth > views[k - 1] + 1e-6);
  assert.equal(back, -1, `goes back at ${back}: ${views}`);
  assert.ok(views[0] - views.at(-1) > 30, `${views}`);
  const { pointer_ms, picture_age_ms } = await page.evaluate(() => globalThis.pxpl5.warp);
  for (const list of [pointer_ms, picture_age_ms]) {
    assert.ok(list.length > 0 && list.every(ms => ms >= 0 && ms < 60_000), `${list}`);
  }
  await byId('tab-machine').click();
  await byId('pointer-times').getByText(/From the pointer to the screen: \d+ ms \(median\)/)
    .waitFor();
});

test('the wheel and a command: zoomed at once, and a named view is not warped', async () => {
  await after(page, () => say(raw, 'view anterior fit=yes'));
  const at = await middleOf(byId('stage'));
  const { zoom } = (await state(page)).camera;
  await page.mouse.move(at.x, at.y);
  await whileStopped(async () => {
    await page.mouse.wheel(0, -120);
    await page.waitForFunction(() => globalThis.pxpl5.warp.warped);
    const { view } = await page.evaluate(() => globalThis.pxpl5.warp);
    assert.ok(view.zoom > zoom * 1.1, `${view.zoom} ${zoom}`);
    await page.mouse.dblclick(at.x, at.y);
    await page.waitForFunction(() => !globalThis.pxpl5.warp.warped);
  });
  await settled(page);
});

/** Turns by a drag; returns how many warped pictures it showed. */
async function warpedWhileTurning(page) {
  const draws = () => page.evaluate(() => globalThis.pxpl5.warp.draws);
  const before = await draws();
  const at = await middleOf(page.getByTestId('stage'));
  await after(page, () => drag(page, at, { x: at.x + 90, y: at.y + 20 }, { steps: 12 }));
  return await draws() - before;
}

test('without warp and with two screen doors the page shows each picture itself', async () => {
  assert.ok(await warpedWhileTurning(page) > 0);
  await after(page, () => say(raw, 'surface bone opacity=0.5'));
  assert.ok(await warpedWhileTurning(page) > 0);
  await after(page, () => say(raw, 'surface skin visible=yes'));
  assert.equal(await warpedWhileTurning(page), 0, 'two screen doors');
  await after(page, () => say(raw, 'surface bone opacity=1'));
  await after(page, () => say(raw, 'surface skin visible=no'));
  assert.ok(await warpedWhileTurning(page) > 0);
  await unfold(page);
  await byId('warp-switch').uncheck();
  assert.equal(await warpedWhileTurning(page), 0, 'switched off');
  await byId('warp-switch').check();
  await after(page, () => say(raw, 'view 5 5'));
  assert.ok(await warpedWhileTurning(page) > 0);
  const off = await openPage(browser, `${server.url}&warp=off`);
  await unfold(off.page);
  assert.equal(await off.page.getByTestId('warp-switch').isChecked(), false);
  assert.equal(await warpedWhileTurning(off.page), 0, '?warp=off');
  await off.close();
});

test('where WebGL is a program the page draws without it, unless the address wants it',
     async () => {
  const kindOf = page => page.getByTestId('warp').evaluate(canvas =>
    ['2d', 'webgl2'].find(kind => canvas.getContext(kind)));
  assert.ok(await warpedWhileTurning(page) > 0);
  assert.equal(await kindOf(page), '2d');
  for (const [wanted, kind] of [['webgl', 'webgl2'], ['software', '2d']]) {
    const other = await openPage(browser, `${server.url}&warp=${wanted}`);
    assert.ok(await warpedWhileTurning(other.page) > 0, wanted);
    assert.equal(await kindOf(other.page), kind);
    await other.close();
  }
});

test('WebGL that the browser takes and gives back goes on', async () => {
  const other = await openPage(browser, `${server.url}&warp=webgl`);
  assert.ok(await warpedWhileTurning(other.page) > 0);
  await unfold(other.page);
  const box = other.page.getByTestId('warp-switch');
  await other.page.getByTestId('warp').evaluate(canvas => {
    history.replaceState(null, '', location.href.replace('warp=webgl', 'warp=software'));
    globalThis.taken = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    globalThis.taken.loseContext();
  });
  await other.page.waitForFunction(box => box.disabled, await box.elementHandle());
  assert.match(await box.locator('..').getAttribute('title'), /taken WebGL back/);
  await other.page.evaluate(() => globalThis.taken.restoreContext());
  await other.page.waitForFunction(box => !box.disabled, await box.elementHandle());
  assert.ok(await warpedWhileTurning(other.page) > 0);
  await other.close();
});

test('without WebGL 2 the picture follows the pointer, too', async () => {
  const none = await openPage(browser, server.url, { script: () => {
    const plain = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind === 'webgl2' ? null : plain.call(this, kind, ...rest);
    };
  } });
  assert.ok(await warpedWhileTurning(none.page) > 0);
  await none.close();
});

test('a browser that falsifies colors says so, and shows each picture itself', async () => {
  const none = await openPage(browser, server.url, { script: () => {
    const plain = OffscreenCanvasRenderingContext2D.prototype.getImageData;
    OffscreenCanvasRenderingContext2D.prototype.getImageData = function (...where) {
      const found = plain.apply(this, where);
      found.data.forEach((part, at) => { found.data[at] = part ^ 77; });
      return found;
    };
  } });
  await unfold(none.page);
  const box = none.page.getByTestId('warp-switch');
  assert.ok(await box.isDisabled());
  assert.match(await box.locator('..').getAttribute('title'), /does not let the page read/);
  assert.equal(await warpedWhileTurning(none.page), 0);
  await none.close();
});
