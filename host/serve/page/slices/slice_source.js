// Requests slices, newest only: one request per view is in flight, and the newest waits.
import {sliceOf} from './slice_pixels.js';

/** @typedef {import('./slice_pixels.js').Slice} Slice */
/**
 * A slice across an axis, or an oblique one.
 * @typedef {object} Question
 * @property {import('./slice_pixels.js').Axis | 'oblique'} axis
 * @property {number} [index]
 * @property {import('./slice_slab.js').Slab} [slab]
 * @property {import('./slice_pixels.js').Oblique} [oblique]
 */

export class SliceSource {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {{slice: (slice: Slice) => void, failed: (sentence: string) => void}} to
   */
  constructor(connection, to) {
    /** @private */ this.connection_ = connection;
    /** @private */ this.to_ = to;
    /** @private @type {Question | null} */ this.next_ = null;
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
   * @param {Question} question
   * @param {string} of       Identifies volume and contours, to skip repeated requests.
   */
  want(question, of) {
    const asked = `${JSON.stringify(sent(question))} ${of}`;
    if (asked === this.asked_) {
      return;
    }
    this.asked_ = asked;
    this.next_ = question;
    if (!this.busy_) {
      void this.work_();
    }
  }

  /** @private */
  async work_() {
    this.busy_ = true;
    while (this.next_) {
      const question = this.next_;
      this.next_ = null;
      const epoch = this.epoch_;
      try {
        const answer = await this.connection_.ask({ask: 'slice', ...sent(question)});
        if (epoch === this.epoch_) {
          this.to_.slice(sliceOf(question, answer));
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

/**
 * The question as the server reads it.
 * @param {Question} question
 */
function sent({axis, index, slab, oblique}) {
  return {axis, index, ...oblique?.plane, ...slab && slab.mm > 0 &&
    {slab_mm: slab.mm, kind: slab.kind}};
}
