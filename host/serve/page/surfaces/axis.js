// A linear axis: values along a line of pixels, with labels at round values.
import {s, update} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';

const TICK = 6;             // Pixels of a mark.
const STEPS = [1, 2, 5, 10];

export class Scale {
  /**
   * @param {number} low     Value at `left`.
   * @param {number} high    Value at `right`; other than `low`.
   * @param {number} left    Pixels.
   * @param {number} right
   */
  constructor(low = 0, high = 1, left = 0, right = 1) {
    this.low = low;
    this.high = high;
    this.left = left;
    this.right = right;
  }

  /**
   * The place of a value, also beyond the ends.
   * @param {number} value
   */
  at(value) {
    return this.left + (value - this.low) / (this.high - this.low) * (this.right - this.left);
  }

  /**
   * The value at a place, also beyond the ends.
   * @param {number} x
   */
  valueAt(x) {
    return this.low + (x - this.left) / (this.right - this.left) * (this.high - this.low);
  }
}

/**
 * Round values from `low` to `high`, about `count` of them: multiples of 1, 2 or 5 times a power
 * of ten.
 * @param {number} low
 * @param {number} high    Greater than `low`.
 * @param {number} count   At least 1.
 * @returns {{values: number[], digits: number}}  Digits after the point of each value.
 */
export function roundValues(low, high, count) {
  const rough = (high - low) / count;
  const power = Math.floor(Math.log10(rough));
  const unit = 10 ** power;
  // The step whose ratio to the rough one is nearest to 1.
  const ratio = (/** @type {number} */ k) => Math.abs(Math.log(k * unit / rough));
  const factor = STEPS.reduce((best, k) => ratio(k) < ratio(best) ? k : best);
  const digits = Math.max(0, factor === 10 ? -power - 1 : -power);
  const step = factor * unit;
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  const values = Array.from({length: last - first + 1},
    (_, k) => Number(((first + k) * step).toFixed(digits)));
  return {values, digits};
}

/**
 * The outline of bars of equal width, from the first bar's left end to the last bar's right end.
 * @param {number[]} tops   y of each bar, pixels.
 * @param {number} base     y of the bottom.
 * @param {(k: number) => number} x  x of the left end of bar k; of the right end for k = length.
 */
export function outline(tops, base, x) {
  const bars = tops.map((y, k) => `V${short(y)}H${short(x(k + 1))}`);
  return `M${short(x(0))} ${short(base)}${bars.join('')}V${short(base)}Z`;
}

/** @param {number} pixels */
function short(pixels) {
  return String(Math.round(pixels * 100) / 100);
}

/**
 * Draws a line with marks and labels into a group.
 * @param {SVGGElement} group
 * @param {Scale} scale
 * @param {number} count  Wished number of labels.
 */
export function drawAxis(group, scale, count) {
  const {values, digits} = roundValues(scale.low, scale.high, count);
  const line = s('path', {fill: 'none', d: `M${short(scale.left)} 0.5H${short(scale.right)}`});
  group.replaceChildren(line, ...values.map(value =>
    s('g', {transform: `translate(${short(scale.at(value))} 0)`}, s('line', {y2: TICK}),
      s('text', {y: TICK + 3, dy: '0.71em'}, grouped(value, digits)))));
  update(group, {'text-anchor': 'middle'});
}
