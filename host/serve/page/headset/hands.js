// The controllers: grab and turn, cut, change the isovalue, measure, recenter.
import {grouped, short} from '../elements/numbers.js';
import {isoCommand, plain, roundIso} from '../link/lines.js';
import {SIDES} from '../picture/projection.js';
import {add, dot, length, minus, poseOf, rotated} from './rigid.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {import('./placement.js').Placement} Placement */

/**
 * A tracked controller, or a hand that pinches.
 * @typedef {object} Hand
 * @property {Pose} grip     Of its ray, in the room.
 * @property {Vector} tip    In the room.
 */

// Buttons and axes of the mapping `xr-standard`.
const SQUEEZE = 1, RECENTER = 4, MEASURE = 5, STICK_AXIS = 3;
const TIP_M = 0.08;          // From the origin of the ray.
const DEAD = 0.15;           // The stick is at rest.
const SWEEP_S = 4;           // Through all values, with the stick at its end.
const LEAST_CUT_MM = 0.2;
const MOST_LENGTHS = 8;

export class Hands {
  /**
   * @param {App} app
   * @param {Placement} placement  Moved by the hands.
   * @param {() => void} recenter
   */
  constructor(app, placement, recenter) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.placement_ = placement;
    /** @private */
    this.recenter_ = recenter;
    /** @private @type {Set<XRInputSource>} Hold the patient. */
    this.grabbing_ = new Set();
    /** @private Holds the plane. @type {XRInputSource | null} */
    this.cutting_ = null;
    /** @private @type {Map<XRInputSource, Hand>} */
    this.hands_ = new Map();
    /** @private @type {Map<XRInputSource, number>} Bits of the buttons that are pressed. */
    this.pressed_ = new Map();
    /** The cut under a hand. @type {{letter: string, at_mm: number} | null} */
    this.cut = null;
    /** @private While the stick changes it. @type {{surface: string, value: number} | null} */
    this.iso_ = null;
    /** About the isovalue that is being changed; '' if none is. */
    this.value = '';
    /** @private The first point of a length. @type {Vector | null} */
    this.first_mm_ = null;
    /** @type {import('./room.js').Length[]} */
    this.lengths = [];
  }

  /** @param {XRSession} session */
  attach(session) {
    const on = (/** @type {string} */ name, /** @type {(source: XRInputSource) => void} */ act) =>
      session.addEventListener(name, event =>
        act(/** @type {XRInputSourceEvent} */ (event).inputSource));
    // What has no squeeze button, such as a hand that pinches, grabs with its only action.
    const canSqueeze = (/** @type {XRInputSource} */ source) =>
      (source.gamepad?.buttons.length ?? 0) > SQUEEZE;
    on('squeezestart', source => this.grabbing_.add(source));
    on('squeezeend', source => this.grabbing_.delete(source));
    on('selectstart', source => {
      if (canSqueeze(source)) {
        this.beginCut_(source);
      } else {
        this.grabbing_.add(source);
      }
    });
    on('selectend', source => {
      this.grabbing_.delete(source);
      this.endCut_(source);
    });
  }

  /** The hands that are tracked. */
  get all() {
    return [...this.hands_.values()];
  }

  /**
   * Follows the controllers. Call once in each frame of the headset.
   * @param {XRFrame} frame
   * @param {XRReferenceSpace} space
   * @param {number} passed_s  Since the last call.
   */
  update(frame, space, passed_s) {
    const before = this.hands_;
    this.hands_ = new Map();
    for (const source of frame.session.inputSources) {
      const pose = frame.getPose(source.targetRaySpace, space);
      if (pose) {
        const grip = poseOf(pose.transform);
        this.hands_.set(source,
          {grip, tip: add(grip.position, rotated(grip.turn, [0, 0, -TIP_M]))});
      }
    }
    // A controller that is only hidden for a moment still holds what it held.
    const present = new Set(frame.session.inputSources);
    for (const source of [...this.grabbing_, ...this.pressed_.keys()]) {
      if (!present.has(source)) {
        this.grabbing_.delete(source);
        this.pressed_.delete(source);
      }
    }
    if (this.cutting_ && !present.has(this.cutting_)) {
      this.endCut_(this.cutting_);
    }
    this.grab_(before);
    this.moveCut_();
    this.changeIso_(passed_s);
    this.press_();
  }

  /**
   * @private
   * @param {Map<XRInputSource, Hand>} before
   */
  grab_(before) {
    const pairs = [...this.grabbing_].flatMap(source => {
      const [was, is] = [before.get(source), this.hands_.get(source)];
      return was && is ? [{was, is}] : [];
    });
    if (pairs.length === 1) {
      this.placement_.follow(pairs[0].was.grip, pairs[0].is.grip);
    } else if (pairs.length > 1) {
      const [a, b] = pairs;
      this.placement_.stretch([a.was.grip.position, b.was.grip.position],
        [a.is.grip.position, b.is.grip.position]);
    }
  }

  /** @private @param {XRInputSource} source */
  beginCut_(source) {
    const hand = this.hands_.get(source);
    if (!hand || this.cutting_ || !this.app_.store.state?.volume) {
      return;
    }
    // What lies behind the plane stays: the side that the hand points to.
    const ahead = this.placement_.directionToPatient(rotated(hand.grip.turn, [0, 0, -1]));
    const [side] = [...SIDES].sort((a, b) => dot(b.towards, ahead) - dot(a.towards, ahead));
    this.cutting_ = source;
    this.cut = {letter: side.letter, at_mm: Infinity};
    this.app_.connection.mark();
  }

  /** @private */
  moveCut_() {
    const hand = this.cutting_ && this.hands_.get(this.cutting_);
    if (!hand || !this.cut) {
      return;
    }
    const {letter} = this.cut;
    const towards = SIDES.find(each => each.letter === letter)?.towards ?? [0, 0, 1];
    const {position} = this.placement_.toPatient({position: hand.tip, turn: hand.grip.turn});
    const at_mm = dot(position, towards);
    if (Math.abs(at_mm - this.cut.at_mm) >= LEAST_CUT_MM) {
      this.cut = {letter, at_mm};
      void this.app_.connection.set({name: 'clip', words: [letter, plain(at_mm, 1)]});
    }
  }

  /** @private @param {XRInputSource} source */
  endCut_(source) {
    if (this.cutting_ !== source || !this.cut) {
      return;
    }
    const {letter, at_mm} = this.cut, camera = this.app_.store.state?.camera;
    const towards = SIDES.find(each => each.letter === letter)?.towards ?? [0, 0, 1];
    this.cutting_ = null;
    this.cut = null;
    const cutsNothing = camera
      && at_mm < dot(/** @type {Vector} */ (camera.center_mm), towards) - camera.radius_mm;
    if (cutsNothing) {  // The hand has pulled the plane out of the patient.
      void this.app_.connection.do(`clip ${letter} off`);
    }
  }

  /** @private @param {number} passed_s */
  changeIso_(passed_s) {
    const tilts = [...this.hands_.keys()].map(({gamepad}) => gamepad?.axes[STICK_AXIS] ?? 0);
    const tilt = -(tilts.find(each => Math.abs(each) > DEAD) ?? 0);  // Up is negative.
    const {store, selection, connection} = this.app_, volume = store.state?.volume;
    const surface = store.state?.surfaces.find(({name}) => name === selection.name);
    if (tilt === 0 || !volume || !surface) {
      this.iso_ = null;
      this.value = '';
      return;
    }
    if (this.iso_?.surface !== surface.name) {
      this.iso_ = {surface: surface.name, value: surface.isovalue};
      connection.mark();
    }
    const {minimum, maximum} = volume, share = (Math.abs(tilt) - DEAD) / (1 - DEAD);
    const step = Math.sign(tilt) * share ** 2 * (maximum - minimum) / SWEEP_S * passed_s;
    this.iso_.value = Math.max(minimum, Math.min(maximum, this.iso_.value + step));
    const value = roundIso(this.iso_.value, volume);
    this.value = [surface.name, short(value), volume.unit].filter(Boolean).join(' ');
    void connection.set(isoCommand(surface.name, value));
  }

  /** Does what a button says when it goes down. @private */
  press_() {
    for (const [source, hand] of this.hands_) {
      const isDown = (/** @type {number} */ button) =>
        source.gamepad?.buttons[button]?.pressed ? 1 << button : 0;
      const bits = isDown(RECENTER) | isDown(MEASURE);
      const down = bits & ~(this.pressed_.get(source) ?? 0);
      this.pressed_.set(source, bits);
      if (down & 1 << RECENTER) {
        this.recenter_();
      }
      if (down & 1 << MEASURE) {
        this.measure_(hand);
      }
    }
  }

  /** @private @param {Hand} hand */
  measure_({tip, grip}) {
    const {position} = this.placement_.toPatient({position: tip, turn: grip.turn});
    const a_mm = this.first_mm_;
    if (!a_mm) {
      this.first_mm_ = position;
      return;
    }
    this.first_mm_ = null;
    const distance_mm = length(minus(position, a_mm));
    this.lengths = [...this.lengths, {a_mm, b_mm: position, text: lengthText(distance_mm)}]
      .slice(-MOST_LENGTHS);
    const refusal = this.app_.measures.add({kind: 'distance', points_mm: [a_mm, position],
      value: distance_mm});
    if (refusal) {
      this.app_.toasts.error(refusal);
    }
  }

  /** The lengths, and that from the first point to the hand. */
  get shownLengths() {
    const [hand] = this.all, a_mm = this.first_mm_;
    if (!a_mm || !hand) {
      return this.lengths;
    }
    const {position} = this.placement_.toPatient({position: hand.tip, turn: hand.grip.turn});
    return [...this.lengths, {a_mm, b_mm: position, text: lengthText(length(minus(position,
      a_mm)))}];
  }

  /** Another volume: lengths of the former one have no meaning. */
  forget() {
    this.lengths = [];
    this.first_mm_ = null;
  }
}

/** @param {number} mm */
function lengthText(mm) {
  return `${grouped(mm, mm < 100 ? 1 : 0)} mm`;
}
