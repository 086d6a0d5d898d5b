// Requests slices, newest only: one request per view is in flight, and the newest waits. On a slow
// link, slices are packed, and the next one in the direction of the last step is asked for at the
// same time, so that the link carries it right after the first.
import {CAN_UNPACK, unpacked} from './slice_packing.js';
import {sliceOf} from './slice_pixels.js';

/** @typedef {import('./slice_pixels.js').Slice} Slice */
/**
 * A slice across an axis, or an oblique one.
 * @typedef {object} Question
 * @property {import('./slice_pixels.js').Axis | 'oblique'} axis
 * @property {number} [index]
 * @property {number} [count]  Of the slices across the axis.
 * @property {import('./slice_slab.js').Slab} [slab]
 * @property {import('./slice_pixels.js').Oblique} [oblique]
 */

const KEPT_BYTES = 24 * 2 ** 20;  // Values of the slices that a view keeps.
const MOST_LONGER = 4;            // Times that a plain slice may take of a packed one.
const SLOW_MS = 40;               // A link that takes longer for a slice is slow.

export class SliceSource {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {{slice: (slice: Slice) => void, failed: (sentence: string) => void}} to
   */
  constructor(connection, to) {
    /** @private */ this.connection_ = connection;
    /** @private */ this.to_ = to;
    /** @private @type {Wish | null} */ this.next_ = null;
    /** @private */ this.busy_ = false;
    /** @private  The last request; '' to send it again. */
    this.asked_ = '';
    /** @private  Counts requests. */ this.number_ = 0;
    /** @private  The request whose slice is shown. */ this.shown_ = 0;
    /** @private @type {{question: Question, of: string} | null} */ this.last_ = null;
    /** @private @type {Map<string, Promise<Slice>>} Requests without an answer. */
    this.flying_ = new Map();
    /** @private  Time of the newest answer. */ this.answered_ms_ = 0;
    /** @private  -1 or 1 after a step to the next slice, else 0. */ this.step_ = 0;
    /** @private */ this.isSlow_ = CAN_UNPACK;
    /** @private @type {Map<string, Slice>} The oldest use first. */ this.kept_ = new Map();
    /** @private  Of the kept slices. */
    this.bytes_ = 0;
    /** @private  Answers to questions of earlier epochs are dropped. */
    this.epoch_ = 0;
  }

  /** Drops what is under way, because another volume is open. */
  forget() {
    this.asked_ = '';
    this.next_ = null;
    this.last_ = null;
    this.step_ = 0;
    this.kept_.clear();
    this.flying_.clear();
    this.bytes_ = 0;
    ++this.epoch_;
  }

  /**
   * @param {Question} question
   * @param {string} of       Identifies volume and contours, to skip repeated requests.
   */
  want(question, of) {
    const asked = keyOf(question, of);
    if (asked === this.asked_) {
      return;
    }
    const step = (question.index ?? 0) - (this.last_?.question.index ?? NaN);
    this.step_ = Math.abs(step) === 1 && isPlain(question) ? step : 0;
    this.last_ = {question, of};
    this.asked_ = asked;
    this.next_ = {question, of, number: ++this.number_};
    const kept = this.kept_.get(asked);
    if (kept) {
      this.keep_(asked, kept);
      this.show_(kept, this.next_);
      this.next_ = null;
      this.askAhead_();
    } else if (!this.busy_) {
      void this.work_();
    }
  }

  /** @private */
  async work_() {
    this.busy_ = true;
    for (let wish = this.next_; wish; wish = this.next_) {
      this.next_ = null;
      const epoch = this.epoch_, key = keyOf(wish.question, wish.of);
      try {
        const slice = this.kept_.get(key) ?? this.wanted_(wish.question, key);
        this.askAhead_();
        this.show_(await slice, wish, epoch);
      } catch (error) {
        if (epoch === this.epoch_ && wish.number > this.shown_) {
          this.asked_ = '';
          this.to_.failed(error instanceof Error ? error.message : String(error));
        }
      }
    }
    this.busy_ = false;
  }

  /**
   * Asks for the slice that the user steps to next, if that takes long. A refusal is not told: the
   * user has not asked for it.
   * @private
   */
  askAhead_() {
    const {last_: last, step_: step} = this;
    if (!last || step === 0 || !this.isSlow_) {
      return;
    }
    this.step_ = 0;  // Once for each step, also if it fails.
    const {question: {index: at = 0, count = 0}, of} = last;
    const index = at + step, question = {...last.question, index}, key = keyOf(question, of);
    if (index >= 0 && index < count && !this.kept_.has(key)) {
      this.begun_(question, key, true).catch(() => {});
    }
  }

  /**
   * The request for a slice that the user wants now. One that was asked for ahead may be refused,
   * because a newer one has taken its place.
   * @private
   * @param {Question} question
   * @param {string} key
   */
  wanted_(question, key) {
    return this.flying_.get(key)?.catch(() => this.begun_(question, key)) ??
      this.begun_(question, key);
  }

  /**
   * The request for a slice, which may have begun before.
   * @private
   * @param {Question} question
   * @param {string} key
   * @param {boolean} isAhead
   */
  begun_(question, key, isAhead = false) {
    const epoch = this.epoch_;
    const slice = this.flying_.get(key) ?? this.fetch_(question, isAhead).then(fetched => {
      if (epoch === this.epoch_) {
        this.keep_(key, fetched);
      }
      return fetched;
    }).finally(() => {
      if (this.flying_.get(key) === slice) {
        this.flying_.delete(key);
      }
    });
    this.flying_.set(key, slice);
    return slice;
  }

  /**
   * @private
   * @param {Question} question
   * @param {boolean} isAhead
   */
  async fetch_(question, isAhead) {
    const begin = performance.now();
    const answer = await this.connection_.ask({ask: 'slice', ...sent(question),
      ...this.isSlow_ && {packed: true}, ...isAhead && {ahead: true}});
    // The link carried another answer before.
    const took = performance.now() - Math.max(begin, this.answered_ms_) -
      (answer.json.packed?.ms ?? 0);
    this.answered_ms_ = performance.now();
    // Without packing. A few bytes take about as long as none.
    const longer = (answer.json.packed?.bytes ?? 0) / Math.max(answer.bytes.byteLength, 1);
    if (isPlain(question)) {  // Slabs and oblique slices take the server's time, too.
      this.isSlow_ = CAN_UNPACK && took * Math.min(Math.max(longer, 1), MOST_LONGER) > SLOW_MS;
    }
    return sliceOf(question, await unpacked(answer));
  }

  /**
   * Keeps a slice as the newest, and drops the oldest ones beyond the limit.
   * @private
   * @param {string} key
   * @param {Slice} slice
   */
  keep_(key, slice) {
    this.drop_(key);
    this.kept_.set(key, slice);
    this.bytes_ += bytesOf(slice);
    for (const each of this.kept_.keys()) {
      if (this.bytes_ <= KEPT_BYTES || each === key) {
        break;
      }
      this.drop_(each);
    }
  }

  /**
   * @private
   * @param {string} key
   */
  drop_(key) {
    const slice = this.kept_.get(key);
    this.bytes_ -= slice ? bytesOf(slice) : 0;
    this.kept_.delete(key);
  }

  /**
   * Shows a slice unless that of a later request is shown.
   * @private
   * @param {Slice} slice
   * @param {Wish} wish
   * @param {number} epoch  Of the request.
   */
  show_(slice, {number}, epoch = this.epoch_) {
    if (number > this.shown_ && epoch === this.epoch_) {
      this.shown_ = number;
      this.to_.slice(slice);
    }
  }
}

/** @typedef {{question: Question, of: string, number: number}} Wish */

/**
 * @param {Question} question
 * @param {string} of
 */
function keyOf(question, of) {
  return `${JSON.stringify(sent(question))} ${of}`;
}

/**
 * Values and segments share their memory.
 * @param {Slice} slice
 */
function bytesOf({segments}) {
  return segments.buffer.byteLength;
}

/**
 * Whether a question is about one slice across an axis.
 * @param {Question} question
 */
function isPlain({index, slab, oblique}) {
  return index !== undefined && !oblique && !(slab && slab.mm > 0);
}

/**
 * The question as the server reads it.
 * @param {Question} question
 */
function sent({axis, index, slab, oblique}) {
  return {axis, index, ...oblique?.plane, ...slab && slab.mm > 0 &&
    {slab_mm: slab.mm, kind: slab.kind}};
}
