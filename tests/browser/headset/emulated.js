// A page with an emulated headset (IWER) before its own code.
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { openPage } from '../harness.js';

const iwer = readFileSync(path.join(process.env.PXPL5_NODE_MODULES, 'iwer/build/iwer.min.js'),
                          'utf8');

/**
 * Opens a page that finds a headset.
 * @param {(() => void)[]} [scripts]  Run in the page after the headset is there.
 */
export function openWithHeadset(browser, url, { scripts = [], ...options } = {}) {
  return openPage(browser, url, { scripts: [iwer, emulate, ...scripts], ...options });
}

/**
 * Runs in the page: a headset whose eyes have the asymmetric frusta of real ones. IWER's eyes share
 * one symmetric frustum. `framesOf` are the frames of the sessions, with what the page has drawn.
 */
function emulate() {
  const { IWER } = globalThis;
  const device = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true, ipd: 0.063 });
  device.installRuntime({ forceInstall: true });  // Chromium has a navigator.xr without a device.
  device.controlMode = 'programmatic';
  device.position.set(0, 1.6, 0);
  globalThis.headset = device;
  // Tangents of the left eye's edges; mirrored for the right eye.
  const fov = { out: 1.15, in: 0.9, up: 0.95, down: 1.1 };
  const plain = XRFrame.prototype.getViewerPose;
  XRFrame.prototype.getViewerPose = function (space) {
    const pose = plain.call(this, space);
    const { depthNear: near, depthFar: far } = this.session.renderState;
    for (const view of pose?.views ?? []) {
      const [left, right] = view.eye === 'left' ? [fov.out, fov.in] : [fov.in, fov.out];
      const { up, down } = fov;
      const value = new Float32Array([2 / (left + right), 0, 0, 0, 0, 2 / (up + down), 0, 0,
        (right - left) / (left + right), (up - down) / (up + down), -(far + near) / (far - near),
        -1, 0, 0, -2 * far * near / (far - near), 0]);
      Object.defineProperty(view, 'projectionMatrix', { value });
    }
    globalThis.viewerPose = pose;
    return pose;
  };
  const request = XRSession.prototype.requestAnimationFrame;
  XRSession.prototype.requestAnimationFrame = function (act) {
    return request.call(this, (time, frame) => {
      act(time, frame);
      globalThis.afterXrFrame?.(frame);
    });
  };
}

/**
 * Puts on the headset: presses the button and waits for frames.
 * @param {number} eyePx  Pixels of one eye, each way: IWER shows both eyes in the window.
 */
export async function wear(page, eyePx = 256) {
  await page.setViewportSize({ width: 2 * eyePx, height: eyePx });
  await page.getByTestId('headset').click();
  await page.waitForFunction(() => globalThis.pxpl5.headset.frames > 2);
}

/** Moves the head: meters, degrees. */
export function setHead(page, x, y, z, yawDegrees = 0, pitchDegrees = 0) {
  return page.evaluate(([x, y, z, yaw, pitch]) => {
    globalThis.headset.position.set(x, y, z);
    const [sy, cy, sp, cp] = [Math.sin(yaw / 2), Math.cos(yaw / 2), Math.sin(pitch / 2),
                              Math.cos(pitch / 2)];
    globalThis.headset.quaternion.set(cy * sp, sy * cp, -sy * sp, cy * cp);
  }, [x, y, z, yawDegrees * Math.PI / 180, pitchDegrees * Math.PI / 180]);
}

/**
 * Both eyes within the next frame of the headset: their viewports, positions, and where the patient
 * is in their pictures.
 * @returns {Promise<{eye: string, x: number, y: number, width: number, height: number,
 *   position: number[], patient: {x: number, y: number, count: number}}[]>}
 */
export function lookThroughEyes(page) {
  return page.evaluate(() => new Promise(take => {
    /**
     * The mean of the tangents of the patient's pixels, to the right and up, and the number of
     * these pixels. Bone is reddish; letters and lines of the room are gray or blue.
     */
    const patientIn = (gl, { x, y, width, height }, projection) => {
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(x, y, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      const [red, green, blue] = pixels.subarray(4 * width * (height - 1));  // Shows nothing.
      const sum = { x: 0, y: 0, count: 0 };
      for (let at = 0; at < pixels.length; at += 4) {
        if (pixels[at] - pixels[at + 2] > 12 + red - blue && pixels[at + 1] > green) {
          sum.x += at / 4 % width + 0.5;
          sum.y += Math.floor(at / 4 / width) + 0.5;
          sum.count += 1;
        }
      }
      const { count } = sum, [right, up] = [sum.x / count / width, sum.y / count / height]
        .map(share => share * 2 - 1);
      return { x: (right + projection[8]) / projection[0], y: (up + projection[9]) / projection[5],
               count };
    };
    globalThis.afterXrFrame = frame => {
      globalThis.afterXrFrame = undefined;
      const layer = frame.session.renderState.baseLayer;
      take(globalThis.viewerPose.views.map(({ eye, projectionMatrix, transform }, at) => {
        const viewport = layer.getViewport(globalThis.viewerPose.views[at]);
        const { x, y, width, height } = viewport, { position } = transform;
        return { eye, x, y, width, height, position: [position.x, position.y, position.z],
                 patient: patientIn(layer.context, viewport, projectionMatrix) };
      }));
    };
  }));
}

/** Waits until a pair of the current pose is shown. */
export function settledPair(page) {
  return page.evaluate(async () => {
    const { headset } = globalThis.pxpl5;
    // A pose that is not followed by another for some frames is the newest.
    for (let same = 0, last = -1; same < 12;) {
      await new Promise(requestAnimationFrame);
      same = headset.pose === last && headset.pose > 0 ? same + 1 : 0;
      last = headset.pose;
    }
    return headset.pose;
  });
}

/** Runs steps with a worn headset, and takes it off. */
export async function worn(browser, url, act, options = {}) {
  const own = await openWithHeadset(browser, url, options);
  await wear(own.page);
  await settledPair(own.page);
  await act(own.page);
  await own.page.evaluate(() => globalThis.headset.activeSession?.end());
  await own.close();
}

/** Waits until the figures of the headset are as wanted. */
export function figuresWhen(page, holds, wanted) {
  // A function made here: the page's policy forbids to make one from text there.
  return page.waitForFunction(new Function('wanted',
    `return (${holds})(globalThis.pxpl5.headset, wanted);`), wanted);
}

/** Where the patient is in the picture of the left eye. */
export async function leftView(page) {
  return (await lookThroughEyes(page))[0].patient;
}

/** The figures of the headset, as metrics.js describes them. */
export const figures = page => page.evaluate(() => globalThis.pxpl5.headset);
