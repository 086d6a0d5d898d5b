// Requests slices, newest only: one request per view is in flight, and the newest waits.
import {sliceOf} from './slice_pixels.js';

/** @typedef {import('./slice_pixels.js').Axis} Axis */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/** @typedef {import('./slice_slab.js').Slab} Slab */

export class SliceSource {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {{slice: (slice: Slice) => void, failed: (sentence: string) => void}} to
   */
  constructor(connection, to) {
    /** @private */ this.connection_ = connection;
    /** @private */ this.to_ = to;
    /** @private @type {{axis: Axis, index: number, slab: Slab} | null} */ this.next_ = null;
    /** @private */ this.busy_ = false;
    /** @private  The last request; '' to send it again. */
    this.asked_ = '';
    /** @private  Answers to questions of earlier epochs are dropped. */
    this.epoch_ = 0;
  }

  /** Drops what is under way, because another volume is open. */
  forget() {
    this.asked_ = '';
    this.next_ = null;
    ++this.epoch_;
  }

  /**
   * @param {Axis} axis
   * @param {number} index
   * @param {Slab} slab
   * @param {string} of       Identifies volume and contours, to skip repeated requests.
   */
  want(axis, index, slab, of) {
    const asked = `${axis} ${index} ${slab.mm > 0 ? `${slab.mm} ${slab.kind}` : ''} ${of}`;
    if (asked === this.asked_) {
      return;
    }
    this.asked_ = asked;
    this.next_ = {axis, index, slab};
    if (!this.busy_) {
      void this.work_();
    }
  }

  /** @private */
  async work_() {
    this.busy_ = true;
    while (this.next_) {
      const {axis, index, slab: {mm, kind}} = this.next_;
      this.next_ = null;
      const epoch = this.epoch_;
      try {
        const answer = await this.connection_.ask({ask: 'slice', axis, index,
          ...mm > 0 && {slab_mm: mm, kind}});
        if (epoch === this.epoch_) {
          this.to_.slice(sliceOf(axis, index, answer));
        }
      } catch (error) {
        if (epoch === this.epoch_) {
          this.asked_ = '';
          this.to_.failed(error instanceof Error ? error.message : String(error));
        }
      }
    }
    this.busy_ = false;
  }
}
