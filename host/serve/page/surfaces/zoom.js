// The part of the values that the histogram shows.
import {h} from '../elements/dom.js';
import {timesOf} from '../elements/wheel.js';
import {say} from '../texts/say.js';

/** @typedef {{low: number, high: number}} Range  Values; low is less than high. */

const STEP = 2;             // A button shows half or twice as many values.
const WHEEL_STEP = 1.25;    // The same of a notch of the wheel.
const FEWEST_BINS = 8;      // Of the histogram, side by side.

/**
 * Shows `times` as many details. `value` keeps its place, as far as the ends allow.
 * @param {Range} shown
 * @param {Range} all
 * @param {number} times      Less than 1 shows more values.
 * @param {number} value
 * @param {number} narrowest  Least difference of the ends.
 * @returns {Range}
 */
export function zoomedAt(shown, all, times, value, narrowest) {
  const wished = (shown.high - shown.low) / times;
  const width = Math.min(Math.max(wished, narrowest), all.high - all.low);
  const share = (value - shown.low) / (shown.high - shown.low);
  return within(value - share * width, width, all);
}

/**
 * The same width, `by` further up.
 * @param {Range} shown
 * @param {Range} all
 * @param {number} by
 */
export function movedBy(shown, all, by) {
  return within(shown.low + by, shown.high - shown.low, all);
}

/**
 * @param {number} low
 * @param {number} width
 * @param {Range} all
 * @returns {Range}
 */
function within(low, width, all) {
  if (width >= all.high - all.low) {
    return {...all};
  }
  const first = Math.min(Math.max(low, all.low), all.high - width);
  return {low: first, high: first + width};
}

/**
 * @typedef {object} Shows
 * @property {(x: number) => number} valueAt  The value at a place, CSS pixels from the left.
 * @property {() => number | null} chosen     The isovalue of the chosen surface.
 * @property {() => void} draw                The shown values are others.
 */

export class Zoom {
  /**
   * @param {SVGSVGElement} svg  Its empty places can be dragged, and it takes Ctrl and the wheel.
   * @param {Shows} shows
   */
  constructor(svg, shows) {
    /** @private */
    this.svg_ = svg;
    /** @private */
    this.shows_ = shows;
    /** @private @type {Range} */
    this.all_ = {low: 0, high: 1};
    /** @private @type {Range} */
    this.shown_ = this.all_;
    /** @private */
    this.narrowest_ = 1;
    const button = (/** @type {string} */ id, /** @type {string} */ text,
                    /** @type {string} */ label, /** @type {() => void} */ onclick) =>
      h('button', {class: 'quiet icon', 'data-testid': id, 'aria-label': label, title: label,
        onclick}, text);
    /** @private */
    this.showsMore_ = button('values-more', '−', say`Show more values`, () => this.showMore_());
    /** @private */
    this.showsFewer_ = button('values-fewer', '+',
      say`Show fewer values, around the isovalue of the chosen surface`, () => this.showFewer_());
    /** @private */
    this.whole_ = button('values-all', say`All`, say`Show all values`, () => this.show_(this.all_));
    this.buttons = h('span', {class: 'row', role: 'group', 'aria-label': say`Values shown`},
      this.showsMore_, this.showsFewer_, this.whole_);
    svg.addEventListener('wheel', event => this.wheel_(event), {passive: false});
    svg.addEventListener('pointerdown', event => this.grab_(event));
    this.setAll({low: 0, high: 1}, 1);
  }

  /** @returns {Range} */
  get all() {
    return this.all_;
  }

  /** @returns {Range} */
  get shown() {
    return this.shown_;
  }

  /**
   * Other values, for example of another volume: all of them are shown.
   * @param {Range} all
   * @param {number} bin   Width of a bin.
   */
  setAll(all, bin) {
    this.all_ = {...all};
    this.shown_ = this.all_;
    this.narrowest_ = Math.min(FEWEST_BINS * bin, all.high - all.low);
    this.mark_();
  }

  /**
   * Shows a value that is beyond the ends in the middle.
   * @param {number} value
   */
  follow(value) {
    const {low, high} = this.shown_;
    if (value < low || value > high) {
      this.show_(movedBy(this.shown_, this.all_, value - (low + high) / 2));
    }
  }

  /** @private */
  showMore_() {
    const {low, high} = this.shown_;
    this.show_(zoomedAt(this.shown_, this.all_, 1 / STEP, (low + high) / 2, this.narrowest_));
  }

  /** @private */
  showFewer_() {
    const {low, high} = this.shown_, middle = (low + high) / 2;
    const fewer = zoomedAt(this.shown_, this.all_, STEP, middle, this.narrowest_);
    this.show_(movedBy(fewer, this.all_, (this.shows_.chosen() ?? middle)
      - (fewer.low + fewer.high) / 2));
  }

  /**
   * @private
   * @param {Range} shown
   */
  show_(shown) {
    this.shown_ = {...shown};
    this.mark_();
    this.shows_.draw();
  }

  /** @private */
  mark_() {
    const {low, high} = this.shown_, isWhole = high - low >= this.all_.high - this.all_.low;
    this.showsMore_.disabled = this.whole_.disabled = isWhole;
    this.showsFewer_.disabled = high - low <= this.narrowest_ * 1.001;
    this.svg_.classList.toggle('part', !isWhole);
  }

  /**
   * @private
   * @param {WheelEvent} event
   */
  wheel_(event) {
    if (!event.ctrlKey && !event.metaKey || event.deltaY === 0) {
      return;  // Scrolls the side.
    }
    event.preventDefault();
    const x = event.clientX - this.svg_.getBoundingClientRect().left;
    this.show_(zoomedAt(this.shown_, this.all_, timesOf(event, WHEEL_STEP),
                        this.shows_.valueAt(x), this.narrowest_));
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  grab_(event) {
    if (event.button !== 0 || this.whole_.disabled ||
        /** @type {Element} */ (event.target).closest('.handle')) {
      return;
    }
    const from = this.shown_;
    const left = this.svg_.getBoundingClientRect().left, value = this.shows_.valueAt;
    const perPixel = value(1) - value(0), start = event.clientX - left;
    const all = this.all_;
    const move = (/** @type {PointerEvent} */ moved) => {
      if (this.all_ !== all) {
        end();  // Another volume is open.
      } else if (moved.pointerId === event.pointerId) {
        this.show_(movedBy(from, all, (start - (moved.clientX - left)) * perPixel));
      }
    };
    const end = () => {
      this.svg_.removeEventListener('pointermove', move);
      this.svg_.removeEventListener('pointerup', end);
      this.svg_.removeEventListener('pointercancel', end);
    };
    this.svg_.setPointerCapture(event.pointerId);
    this.svg_.addEventListener('pointermove', move);
    this.svg_.addEventListener('pointerup', end);
    this.svg_.addEventListener('pointercancel', end);
  }
}
