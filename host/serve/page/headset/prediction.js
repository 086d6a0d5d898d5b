// Where the head will be when a picture that is asked for now is about to appear.
import {add, minus, slerp, times} from './rigid.js';

/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {{at: number, pose: Pose}} Sample  at: performance.now(). */

const KEPT_MS = 500;
const BASE_MS = 60;        // The motion is taken from samples of this time.
const LEAST_BASE_MS = 8;
const MOST_AHEAD_MS = 150;

/**
 * The pose at a time beside two samples, on a straight line and an arc through both.
 * @param {Sample} a
 * @param {Sample} b  Not at the same time.
 * @param {number} at
 * @returns {Pose}
 */
export function poseBetween(a, b, at) {
  const share = (at - a.at) / (b.at - a.at);
  return {position: add(a.pose.position, times(minus(b.pose.position, a.pose.position), share)),
    turn: slerp(a.pose.turn, b.pose.turn, share)};
}

/** The newest poses of the head in the patient. */
export class HeadTrack {
  constructor() {
    /** @private @type {Sample[]} In order of time. */
    this.samples_ = [];
  }

  /**
   * @param {number} at  Later than before.
   * @param {Pose} pose
   */
  add(at, pose) {
    this.samples_.push({at, pose});
    while (this.samples_[0].at < at - KEPT_MS) {
      this.samples_.shift();
    }
  }

  /** After a jump, for example when the patient was put elsewhere. */
  forget() {
    this.samples_ = [];
  }

  /**
   * The pose some time after the newest sample, by linear extrapolation.
   * @param {number} ahead_ms  At most MOST_AHEAD_MS are used.
   * @returns {Sample | null}  Null before the first sample.
   */
  predict(ahead_ms) {
    const newest = this.samples_.at(-1);
    if (!newest) {
      return null;
    }
    const at = newest.at + Math.max(0, Math.min(MOST_AHEAD_MS, ahead_ms));
    const base = this.samples_.find(each => each.at >= newest.at - BASE_MS) ?? newest;
    const isShort = newest.at - base.at < LEAST_BASE_MS;
    return {at, pose: isShort ? newest.pose : poseBetween(base, newest, at)};
  }

  /**
   * The pose at a time in the past, between two samples.
   * @param {number} at
   * @returns {Pose | null}  Null if the time is not between two samples.
   */
  at(at) {
    const next = this.samples_.findIndex(each => each.at >= at);
    return next <= 0 ? null : poseBetween(this.samples_[next - 1], this.samples_[next], at);
  }

  /** The time of the newest sample; 0 before the first. */
  get newestAt() {
    return this.samples_.at(-1)?.at ?? 0;
  }
}
