// The cameras of the newest states: frames arrive later than the states that they show.
import {stereoOf} from './stereo.js';

/** @typedef {import('../link/vocabulary.js').CameraState} CameraState */
/** @typedef {import('../link/vocabulary.js').State} State */
/** @typedef {import('./stereo.js').Stereo} Stereo */

const KEPT = 64;

export class Cameras {
  constructor() {
    /** @private @type {{revision: number, camera: CameraState, stereo: Stereo}[]} */
    this.list_ = [];
  }

  /** @param {State} state */
  add(state) {
    this.list_.push({revision: state.revision, camera: state.camera, stereo: stereoOf(state)});
    this.list_.splice(0, this.list_.length - KEPT);
  }

  forget() {
    this.list_ = [];
  }

  /**
   * What a frame was drawn with.
   * @param {number} revision
   * @param {State | null} state  The newest.
   * @returns {{camera: CameraState | null, stereo: Stereo}}
   */
  of(revision, state) {
    return this.list_.filter(each => each.revision <= revision).at(-1)
      ?? {camera: state?.camera ?? null, stereo: state ? stereoOf(state)
        : {mode: 'off', separation_mm: 0, convergence_mm: 0}};
  }
}
