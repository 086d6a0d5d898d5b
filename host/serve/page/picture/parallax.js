// Looking around: the pointer over the picture, or a phone's orientation, turns the view that is on
// the screen by a few degrees. The view of the scene stays the same.
import {prefersReducedMotion} from '../elements/canvas.js';
import {say} from '../texts/say.js';
import {anglesOf, rotationOf, turn} from './arcball.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('./camera.js').View} View */
/** @typedef {{right: number, up: number}} Turn  Of the viewer around the patient, degrees. */

/** How far the viewer moves. Pictures do not show what lies behind. */
const MOST = {right: 7, up: 5};
const HALFWAY_MS = 70;      // After this time half of the way is done.
const THERE_DEG = 0.02;     // Nearer is there.
const DEGREE = Math.PI / 180;
const NEEDS_HTTPS = say`Browsers report the orientation of a phone only to pages of https:// or
  localhost. Give pxpl5 serve a certificate: --tls-cert and --tls-key.`;
const DENIED = say`The browser did not let this page read the orientation of the device. Allow
  "motion and orientation" for this page in the settings of the browser.`;

/**
 * The axes of a device, from the angles of a `deviceorientation` event.
 * Source  W3C, DeviceOrientation Event Specification, 3.1: rotations about z, x and y, in turn.
 * @param {{alpha: number, beta: number, gamma: number}} angles  Degrees.
 * @returns {[Triple, Triple, Triple]} the device's right, top and screen normal, in the room
 */
export function deviceAxes({alpha, beta, gamma}) {
  const [ca, cb, cg] = [alpha, beta, gamma].map(each => Math.cos(each * DEGREE));
  const [sa, sb, sg] = [alpha, beta, gamma].map(each => Math.sin(each * DEGREE));
  return [[ca * cg - sa * sb * sg, sa * cg + ca * sb * sg, -cb * sg],
    [-sa * cb, ca * cb, sb],
    [ca * sg + sa * sb * cg, sa * sg - ca * sb * cg, cb * cg]];
}

/**
 * How the viewer has moved around a device, as seen from the device's screen, since the device had
 * other axes. The viewer rests while the device turns.
 * @param {[Triple, Triple, Triple]} before
 * @param {[Triple, Triple, Triple]} now
 * @param {number} screenAngle  From the device's top clockwise to the top of the page, degrees.
 * @returns {Turn}
 */
export function turnOfDevice(before, now, screenAngle) {
  const [x, y, z] = before.map(axis =>
    axis.reduce((sum, value, k) => sum + value * now[2][k], 0));
  const right = -Math.atan2(x, z) / DEGREE, up = -Math.atan2(y, z) / DEGREE;
  const [c, s] = [Math.cos(screenAngle * DEGREE), Math.sin(screenAngle * DEGREE)];
  return {right: c * right - s * up, up: c * up + s * right};
}

/** @param {Turn} turn */
function bounded({right, up}) {
  const held = (/** @type {number} */ value, /** @type {number} */ most) =>
    Math.max(-most, Math.min(most, value));
  return {right: held(right, MOST.right), up: held(up, MOST.up)};
}

export class Parallax {
  /** @param {import('./picture.js').PictureView} picture */
  constructor(picture) {
    /** @private */
    this.picture_ = picture;
    /** @private */
    this.isOn_ = false;
    /** @private @type {Turn} */
    this.now_ = {right: 0, up: 0};
    /** @private @type {Turn} */
    this.target_ = {right: 0, up: 0};
    /** @private Axes of the device that show the view itself. */
    this.axes_ = /** @type {[Triple, Triple, Triple] | null} */ (null);
    /** @private */
    this.requested_ = 0;
    /** @private Time of the last step, 0 at rest. */
    this.steppedAt_ = 0;
    /** Is called when the turn has changed. */
    this.onMoved = () => {};

    const {stage} = picture;
    stage.addEventListener('pointermove', event => this.point_(event));
    stage.addEventListener('pointerleave', event => {
      if (event.pointerType !== 'touch') {
        this.aim_({right: 0, up: 0});
      }
    });
    stage.addEventListener('pointerdown', event => {
      this.axes_ = null;  // A touch makes the present orientation the middle.
      if (event.pointerType !== 'touch') {
        this.aim_({right: 0, up: 0});
      }
    });
    addEventListener('deviceorientation', event => this.orient_(event));
  }

  get isOn() {
    return this.isOn_;
  }

  /**
   * Switches on. Call this from the listener of a click, because browsers may ask the user.
   * @returns {Promise<string>} why the orientation of the device has no effect; empty if it may
   *     have one
   */
  async start() {
    this.isOn_ = true;
    this.axes_ = null;
    const ask = /** @type {any} */ (globalThis).DeviceOrientationEvent?.requestPermission;
    const isPhone = matchMedia('(pointer: coarse)').matches;
    if (!isSecureContext) {
      return isPhone ? NEEDS_HTTPS : '';
    }
    try {  // Safari; other browsers do not ask.
      return await ask?.() === 'denied' ? DENIED : '';
    } catch {
      return DENIED;
    }
  }

  /** Switches off; the view returns. */
  stop() {
    this.isOn_ = false;
    this.aim_({right: 0, up: 0});
  }

  /**
   * The view from where the viewer has moved.
   * @param {View} view
   * @returns {View}
   */
  turned(view) {
    const {right, up} = this.now_;
    if (right === 0 && up === 0) {
      return view;
    }
    // The viewer moves to the right as the patient turns to the left.
    const across = turn(rotationOf(view), [0, 1, 0], -right * DEGREE);
    return {zoom: view.zoom, pan_mm: view.pan_mm,
      ...anglesOf(turn(across, [1, 0, 0], up * DEGREE))};
  }

  /** @private @param {PointerEvent} event */
  point_(event) {
    if (this.isOn_ && event.pointerType !== 'touch' && event.buttons === 0) {
      const {x, y, radius} = this.picture_.circleAt(event);
      this.aim_({right: (event.clientX - x) / radius * MOST.right,
        up: (y - event.clientY) / radius * MOST.up});
    }
  }

  /** @private @param {DeviceOrientationEvent} event */
  orient_({alpha, beta, gamma}) {
    if (!this.isOn_ || beta === null || gamma === null) {
      return;  // Computers without sensors send one event without angles.
    }
    const axes = deviceAxes({alpha: alpha ?? 0, beta, gamma});
    this.axes_ ??= axes;
    this.aim_(turnOfDevice(this.axes_, axes, globalThis.screen.orientation?.angle ?? 0));
  }

  /** @private @param {Turn} target */
  aim_(target) {
    this.target_ = bounded(target);
    if (this.requested_ === 0) {
      this.steppedAt_ = performance.now();
      this.requested_ = requestAnimationFrame(() => this.step_());
    }
  }

  /** @private */
  step_() {
    const at = performance.now();
    const share = prefersReducedMotion() ? 1 : 1 - 0.5 ** ((at - this.steppedAt_) / HALFWAY_MS);
    this.steppedAt_ = at;
    const {target_: target, now_: now} = this;
    const isThere = Math.hypot(target.right - now.right, target.up - now.up) < THERE_DEG;
    this.now_ = isThere ? target : {right: now.right + share * (target.right - now.right),
      up: now.up + share * (target.up - now.up)};
    this.requested_ = isThere ? 0 : requestAnimationFrame(() => this.step_());
    this.onMoved();
  }
}
