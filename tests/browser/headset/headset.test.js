// An emulated headset (IWER): a session and its end, two eyes, a machine that stands still, lost
// links, the mirror.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { browser, page, server, shoot, usePage } from '../harness.js';
import { treeOf } from '../processes.js';
import { after, say, settled, socketWithoutSkin, state, stateWhen } from '../steps.js';
import { figures, figuresWhen, leftView, lookThroughEyes, openWithHeadset, setHead, settledPair,
  wear, worn } from './emulated.js';

const EYES_APART_M = 0.063;
const DISTANCE_M = 0.8;        // The page puts the patient there.
const STOPPED_MS = 1000;
const LEAST_PIXELS = 500;      // Of the patient in an eye's picture.
const LEAST_FRAMES_PER_S = 20;

let raw;

// A GP is stopped below, which is no failure of the machine here.
usePage(['phantom:pelvis', 'resample=96x96x48', '--set', 'heartbeat.misses=0'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

const wornHere = (act, options) => worn(browser, server.url, act, options);

test('a page without a headset has no button, and the help says why', async () => {
  assert.ok(await page.getByTestId('headset').isHidden());
  await page.getByTestId('help').click();
  const reason = page.getByTestId('headset-reason');
  assert.match(await reason.textContent(), /The browser has found no headset/);
  await page.keyboard.press('Escape');
  assert.equal((await figures(page)).state, 'off');
});

test('a view-only page and one without WebGL 2 say why their button is off', async () => {
  const watching = await openWithHeadset(browser, server.watchUrl);
  const button = watching.page.getByTestId('headset');
  await button.waitFor();
  assert.ok(await button.isDisabled());
  assert.match(await button.getAttribute('title'), /view-only page cannot use a headset/);
  await watching.close();
  const none = await openWithHeadset(browser, server.url, { scripts: [() => {
    const plain = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      return kind === 'webgl2' ? null : plain.call(this, kind, ...rest);
    };
  }] });
  await none.page.getByTestId('headset').waitFor();
  assert.ok(await none.page.getByTestId('headset').isDisabled());
  await none.page.getByTestId('help').click();
  assert.match(await none.page.getByTestId('headset-reason').textContent(), /no WebGL 2/);
  await none.close();
});

test('two eyes, each with its own frustum, in its own viewport', () => wornHere(async page => {
  const eyes = await lookThroughEyes(page);
  assert.deepEqual(eyes.map(({ eye, x, y, width, height }) => ({ eye, x, y, width, height })),
    [{ eye: 'left', x: 0, y: 0, width: 256, height: 256 },
     { eye: 'right', x: 256, y: 0, width: 256, height: 256 }]);
  // Warped by depth, the other eye's picture would fit, too, but for what only one eye sees.
  const drawn = await page.evaluate(async () => {
    const { WarpPainter } = await import(new URL('picture/warp_painter.js', location.href).href);
    const plain = WarpPainter.prototype.draw, drawn = [];
    WarpPainter.prototype.draw = function (picture, ...rest) {
      const [x] = this.gl.getParameter(this.gl.VIEWPORT);
      drawn.push([picture, x]);
      plain.call(this, picture, ...rest);
    };
    await new Promise(take => { globalThis.afterXrFrame = take; });
    globalThis.afterXrFrame = undefined;
    WarpPainter.prototype.draw = plain;
    return drawn;
  });
  assert.deepEqual(drawn, [[0, 0], [1, 256]]);
  const renderer = await page.evaluate(() => {
    const { context: gl } = globalThis.headset.activeSession.renderState.baseLayer;
    return gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL);
  });
  assert.match(renderer, /SwiftShader|llvmpipe/);
  const [left, right] = eyes.map(each => each.patient);
  assert.ok(Math.min(left.count, right.count) > LEAST_PIXELS, `${left.count} ${right.count}`);
  // Both see the patient before the viewer; the left eye sees it farther to the right.
  assert.ok(Math.abs(left.x + right.x) < 0.03, `${left.x} ${right.x}`);
  const apart = (left.x - right.x) / (EYES_APART_M / DISTANCE_M);
  assert.ok(apart > 0.85 && apart < 1.3, `${apart} of the parallax of the center`);
  assert.ok(Math.abs(left.y - right.y) < 0.005, `${left.y} ${right.y}`);
  // 0.4 m below the eyes.
  assert.ok(Math.abs(left.y + 0.4 / DISTANCE_M) < 0.1, `${left.y}`);
  await shoot(page, 'headset-eyes');
}, { unbundled: true }));

test('the newest pose is drawn at once, whatever the machine does', () => wornHere(async page => {
  const gps = treeOf(server.child.pid).filter(pid =>
    readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0')[0].endsWith('pxpl5-gp'));
  assert.ok(gps.length > 0);
  const before = await figures(page);
  const was = await leftView(page);
  for (const pid of gps) process.kill(pid, 'SIGSTOP');
  let stopped, moved, frames;
  try {
    frames = await page.evaluate(async ms => {
      const { headset } = globalThis.pxpl5, first = headset.frames, begin = performance.now();
      while (performance.now() - begin < ms) {
        const t = (performance.now() - begin) / ms;
        globalThis.headset.position.set(0.05 * t, 1.6, 0);
        await new Promise(requestAnimationFrame);
      }
      return 1000 * (headset.frames - first) / (performance.now() - begin);
    }, STOPPED_MS);
    await setHead(page, 0.05, 1.6, 0);
    moved = await leftView(page);
    stopped = await figures(page);
    assert.ok(frames > LEAST_FRAMES_PER_S, `${frames} frames per second`);
    assert.ok(stopped.pose <= before.pose + 1, 'what was under way may still have arrived');
    assert.ok(stopped.pose_age_ms.at(-1) > STOPPED_MS / 2, `${stopped.pose_age_ms.at(-1)} ms`);
    const followed = (was.x - moved.x) / (0.05 / DISTANCE_M);
    assert.ok(followed > 0.8 && followed < 1.3, `${followed} of the way`);
  } finally {
    for (const pid of gps) process.kill(pid, 'SIGCONT');
  }
  await figuresWhen(page, (now, age) => now.pose_age_ms.at(-1) < age,
                    stopped.pose_age_ms.at(-1) / 2);
  await settledPair(page);
  assert.ok((await figures(page)).pose > stopped.pose);
}));

test('a new pose is on the screen within the same frame', () => wornHere(async page => {
  // The head moves before each frame; the pixels follow in that frame.
  const seen = [];
  for (let i = 0; i < 6; i++) {
    await setHead(page, 0.01 * i, 1.6, 0);
    const eyes = await lookThroughEyes(page);
    assert.ok(Math.abs(eyes[0].position[0] + EYES_APART_M / 2 - 0.01 * i) < 1e-6);
    seen.push(eyes[0].patient.x);
  }
  seen.slice(1).forEach((x, k) => {
    const followed = (seen[k] - x) / (0.01 / DISTANCE_M);
    assert.ok(followed > 0.3 && followed < 1.7, `step ${k}: ${followed} of the way`);
  });
}));

test('nothing goes back in time while the head moves, and figures are kept', t => wornHere(
  async page => {
    const poses = await page.evaluate(async () => {
      const { headset } = globalThis.pxpl5, poses = [];
      const begin = performance.now(), first = headset.pairs;
      while (headset.pairs < first + 12) {
        const t = performance.now() - begin;
        globalThis.headset.position.set(0.06 * Math.sin(t / 400), 1.6, 0.02);
        await new Promise(requestAnimationFrame);
        poses.push(headset.pose);
      }
      return poses;
    });
    poses.slice(1).forEach((pose, k) => assert.ok(pose >= poses[k], `${pose} after ${poses[k]}`));
    assert.ok(new Set(poses).size > 6, `${poses}`);
    const now = await figures(page);
    for (const key of ['pose_to_pixels_ms', 'pose_age_ms', 'round_trip_ms', 'prediction_error_mm',
                       'unpredicted_error_mm']) {
      const sorted = [...now[key]].sort((a, b) => a - b);
      assert.ok(sorted.length > 0 && sorted[0] >= 0 && sorted.at(-1) < 60_000, `${key} ${sorted}`);
      t.diagnostic(`${key}: median ${sorted[sorted.length >> 1].toFixed(1)}, 95 % ` +
        `${sorted[Math.floor(0.95 * sorted.length)].toFixed(1)} of ${sorted.length}`);
    }
  }));

test('a lost link: frames go on with the last pair, and new poses after it', () => wornHere(
  async page => {
    const before = await figures(page);
    // The page connects again soon: what it does meanwhile is watched within it.
    const lost = await page.evaluate(() => new Promise(take => {
      const { headset } = globalThis.pxpl5, first = headset.frames;
      globalThis.onLink = () => take({ frames: headset.frames - first, pose: headset.pose });
      globalThis.cutLink();
    }));
    assert.ok(lost.frames > 0, `${lost.frames} frames`);
    assert.equal(lost.pose, before.pose);
    assert.ok((await leftView(page)).count > LEAST_PIXELS);
    // The new connection knows nothing of the headset, even if the head rests.
    await figuresWhen(page, (now, pose) => now.pose > pose, before.pose);
    await settledPair(page);
    const { sent } = await page.evaluate(() => ({ sent: globalThis.sentPoses }));
    sent.slice(1).forEach((pose, k) => assert.ok(pose > sent[k], `${sent}`));
  }, { scripts: [() => {
    const Plain = globalThis.WebSocket;
    globalThis.sentPoses = [];
    globalThis.WebSocket = class extends Plain {
      constructor(...words) {
        super(...words);
        globalThis.cutLink = () => this.close();
        this.addEventListener('open', () => globalThis.onLink?.());
      }
      send(text) {
        const pose = JSON.parse(text).eyes?.pose;
        if (pose) globalThis.sentPoses.push(pose);
        super.send(text);
      }
    };
  }] }));

test('the end of a session gives the picture back, however it ends', async () => {
  const own = await openWithHeadset(browser, server.url), { page } = own;
  const { digest } = await settled(page);
  const canvases = await page.locator('canvas').count();
  const ends = {
    button: () => page.evaluate(() =>
      document.querySelector('[data-testid=headset-end]').click()),
    headset: () => page.evaluate(() => globalThis.headset.activeSession.end()),
    'lost WebGL': () => page.evaluate(() => globalThis.headset.activeSession.renderState.baseLayer
      .context.getExtension('WEBGL_lose_context').loseContext()),
  };
  for (const [how, end] of Object.entries(ends)) {
    await page.setViewportSize({ width: 1280, height: 720 });
    await wear(page);
    await settledPair(page);
    assert.equal(await page.getByTestId('headset').getAttribute('aria-pressed'), 'true');
    assert.ok(await page.getByTestId('headset-mirror').evaluate(each => !each.hidden));
    await end();
    await figuresWhen(page, now => now.state === 'off');
    await page.setViewportSize({ width: 1280, height: 720 });
    assert.ok(await page.getByTestId('headset-mirror').isHidden(), how);
    assert.ok(await page.getByTestId('frame').isVisible(), how);
    assert.equal(await page.locator('canvas').count(), canvases, how);
    await stateWhen(page, (now, [width, height]) =>
      Math.abs(now.size[0] / now.size[1] - width / height) < 0.02,
      await page.getByTestId('stage').evaluate(each => [each.clientWidth, each.clientHeight]));
    assert.equal((await settled(page)).digest, digest, how);
  }
  await page.getByTestId('toast-error').getByText('the browser has taken WebGL back').waitFor();
  // IWER itself draws once with the lost context.
  const theirs = own.complaints.filter(each => /onDeviceFrame/.test(each));
  own.complaints.splice(0, Infinity, ...own.complaints.filter(each => !theirs.includes(each)));
  await own.close();
});

test('a headset that is taken off, and one that shows its own menu', () => wornHere(async page => {
  const said = page.getByTestId('headset-state');
  for (const [how, words] of [['visible-blurred', /menu of its own/], ['hidden', /paused/],
                              ['visible', /Shown in the headset/]]) {
    await page.evaluate(how => globalThis.headset.updateVisibilityState(how), how);
    await figuresWhen(page, (now, how) => now.state === how, how);
    assert.match(await said.textContent(), words);
  }
  await settledPair(page);
}));

test('the mirror shows the left eye on the page', async () => {
  // Headsets have a framebuffer of their own; IWER draws into the canvas.
  const own = await openWithHeadset(browser, server.url, { scripts: [() => {
    const made = new WeakMap();
    const make = layer => {
      const { context: gl } = layer, framebuffer = gl.createFramebuffer();
      const [color, depth] = [gl.createRenderbuffer(), gl.createRenderbuffer()];
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      for (const [buffer, format, place] of [[color, gl.RGBA8, gl.COLOR_ATTACHMENT0],
        [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
        gl.renderbufferStorage(gl.RENDERBUFFER, format, 512, 256);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
      }
      made.set(layer, framebuffer);
      return framebuffer;
    };
    Object.defineProperty(XRWebGLLayer.prototype, 'framebuffer',
                          { get() { return made.get(this) ?? make(this); } });
    XRWebGLLayer.prototype.getViewport = view =>
      ({ x: view.eye === 'right' ? 256 : 0, y: 0, width: 256, height: 256 });
    globalThis.keepCanvas = () => {
      document.querySelector('#mirror .view').append(
        globalThis.headset.activeSession.renderState.baseLayer.context.canvas);
    };
  }] });
  await wear(own.page);
  await own.page.setViewportSize({ width: 1280, height: 720 });
  await own.page.evaluate(() => globalThis.keepCanvas());
  await settledPair(own.page);
  const canvas = own.page.locator('#mirror canvas');
  assert.deepEqual(await canvas.evaluate(each => [each.width, each.height]), [256, 256]);
  await own.page.evaluate(least => new Promise(take => {
    const canvas = document.querySelector('#mirror canvas'), gl = canvas.getContext('webgl2');
    globalThis.afterXrFrame = () => {
      const pixels = new Uint8Array(4 * 256 * 256);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const count = pixels.reduce((sum, each, k) =>
        sum + (k % 4 === 0 && each > pixels[k + 2] ? 1 : 0), 0);  // Bone is reddish.
      if (count > least) {
        globalThis.afterXrFrame = undefined;
        take();
      }
    };
  }), LEAST_PIXELS);
  await shoot(own.page, 'headset-mirror');
  // A layer of IWER lies over the page, so that no pointer reaches the button.
  await own.page.getByTestId('headset-end').evaluate(each => each.click());
  await figuresWhen(own.page, now => now.state === 'off');
  await own.close();
});
