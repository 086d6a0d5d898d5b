// How late the screen follows the pointer, and how old the machine's pictures are.
import {h} from '../elements/dom.js';

/**
 * The median and the value that 95 % do not exceed; null for an empty list.
 * @param {number[]} values
 */
export function spreadOf(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (/** @type {number} */ share) =>
    sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
  return sorted.length > 0 ? {median: at(0.5), most: at(0.95)} : null;
}

export class PointerTimes {
  /** @param {import('../panel/app.js').App} app */
  constructor(app) {
    /** @private */
    this.app_ = app;
    this.element = h('p', {class: 'legend', 'data-testid': 'pointer-times', hidden: true});
  }

  /** Shows the newest figures. */
  update() {
    const figures = this.app_.picture.warp?.figures;
    const pointer = spreadOf(figures?.pointer_ms ?? []);
    const picture = spreadOf(figures?.picture_age_ms ?? []);
    this.element.hidden = !pointer || !picture;
    if (pointer && picture) {
      this.element.textContent = 'From the pointer to the screen: '
        + `${pointer.median.toFixed(0)} ms (median), ${pointer.most.toFixed(0)} ms (95 %). `
        + 'Age of the viewpoint that the machine drew: '
        + `${picture.median.toFixed(0)} ms, ${picture.most.toFixed(0)} ms.`;
    }
  }
}
