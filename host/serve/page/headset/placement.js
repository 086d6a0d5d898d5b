// Where the patient stands in the room. The room has meters, x right, y up, z back; the patient has
// LPS millimeters.
import {add, back, compose, inverted, length, matrixOf, minus, product, rotated, times, turnAbout,
  turnBetween, unit} from './rigid.js';

/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {{center_mm: number[], radius_mm: number}} Sphere  Around what is drawn. */

const DISTANCE_M = 0.8;        // From the head to the center of the patient.
const HEIGHT_M = 1.2;
const BELOW_EYES_M = 0.15;     // For a viewer who sits: below the eyes, not above.
const NATURAL = 0.001;         // Meters per millimeter.
const LEAST_DIAMETER_M = 0.2, MOST_DIAMETER_M = 0.6;
const LEAST_SCALE = NATURAL / 20, MOST_SCALE = NATURAL * 20;
// The patient stands upright and faces the viewer: S is up, A is towards the viewer.
const UPRIGHT = turnAbout([1, 0, 0], -Math.PI / 2);

/** One rotation, place and scale of the patient. */
export class Placement {
  constructor() {
    /** Of the patient in the room: the center's position, and the rotation. @type {Pose} */
    this.pose = {position: [0, HEIGHT_M, -DISTANCE_M], turn: UPRIGHT};
    /** Meters per millimeter. */
    this.scale = NATURAL;
    /** @private @type {Vector} The point of the patient at `pose.position`. */
    this.center_mm_ = [0, 0, 0];
  }

  /**
   * Puts the patient upright before a viewer, at natural size unless it is too small or too large.
   * @param {Sphere} sphere
   * @param {Pose} head
   */
  home({center_mm, radius_mm}, head) {
    this.center_mm_ = /** @type {Vector} */ ([...center_mm]);
    const natural_m = 2 * radius_mm * NATURAL;
    this.scale = NATURAL * Math.max(LEAST_DIAMETER_M, Math.min(MOST_DIAMETER_M, natural_m))
      / natural_m;
    const [x, , z] = rotated(head.turn, [0, 0, -1]);
    const yaw = Math.hypot(x, z) < 1e-3 ? 0 : Math.atan2(-x, -z);
    const facing = turnAbout([0, 1, 0], yaw), ahead = rotated(facing, [0, 0, -DISTANCE_M]);
    const height = Math.min(HEIGHT_M, head.position[1] - BELOW_EYES_M);
    this.pose = {position: [head.position[0] + ahead[0], height, head.position[2] + ahead[2]],
      turn: product(facing, UPRIGHT)};
  }

  /** The size at which the patient is shown; 1 is natural. */
  get magnification() {
    return this.scale / NATURAL;
  }

  /** From the patient's millimeters to the room's meters. */
  get patientToWorld() {
    const {position, turn} = this.pose;
    return matrixOf({position: add(position, rotated(turn, times(this.center_mm_, -this.scale))),
      turn}, this.scale);
  }

  /** @param {Vector} p_mm @returns {Vector} meters in the room */
  toWorld(p_mm) {
    return add(this.pose.position,
      rotated(this.pose.turn, times(minus(p_mm, this.center_mm_), this.scale)));
  }

  /** @param {Vector} direction  Of the patient. */
  directionToWorld(direction) {
    return rotated(this.pose.turn, direction);
  }

  /** @param {Vector} direction  Of the room. */
  directionToPatient(direction) {
    return rotated(back(this.pose.turn), direction);
  }

  /**
   * A pose in the patient, with its position in millimeters.
   * @param {Pose} pose  In the room.
   * @returns {Pose}
   */
  toPatient(pose) {
    const {position, turn} = compose(inverted(this.pose), pose);
    return {position: add(times(position, 1 / this.scale), this.center_mm_), turn};
  }

  /**
   * Moves and turns the patient with a hand.
   * @param {Pose} before  Of the hand.
   * @param {Pose} now
   */
  follow(before, now) {
    this.pose = compose(now, compose(inverted(before), this.pose));
  }

  /**
   * Moves, turns and scales the patient with two hands.
   * @param {Vector[]} before  Positions of the hands.
   * @param {Vector[]} now
   */
  stretch(before, now) {
    const [from, to] = [minus(before[1], before[0]), minus(now[1], now[0])];
    if (length(from) < 1e-3 || length(to) < 1e-3) {
      return;
    }
    const middle = (/** @type {Vector[]} */ [a, b]) => times(add(a, b), 0.5);
    const scale = Math.max(LEAST_SCALE, Math.min(MOST_SCALE,
      this.scale * length(to) / length(from)));
    const turn = turnBetween(unit(from), unit(to));
    const arm = times(rotated(turn, minus(this.pose.position, middle(before))),
      scale / this.scale);
    this.pose = {position: add(middle(now), arm), turn: product(turn, this.pose.turn)};
    this.scale = scale;
  }
}
