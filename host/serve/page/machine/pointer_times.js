// How late the screen follows the pointer or the head, and how old the machine's pictures are.
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';

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
      this.element.textContent = say`From the pointer to the screen:
        ${grouped(pointer.median)} ms (median), ${grouped(pointer.most)} ms (95 %).
        Age of the viewpoint that the machine drew:
        ${grouped(picture.median)} ms, ${grouped(picture.most)} ms.`;
    }
  }
}

/** The same for a headset, as long as it is worn and afterwards. */
export class HeadsetTimes {
  constructor() {
    this.element = h('p', {class: 'legend', 'data-testid': 'headset-times', hidden: true});
  }

  /** Shows the newest figures. */
  update() {
    const {pose_to_pixels_ms, pose_age_ms, prediction_error_mm} = window.pxpl5.headset;
    const pose = spreadOf(pose_to_pixels_ms), age = spreadOf(pose_age_ms);
    const error = spreadOf(prediction_error_mm);
    this.element.hidden = !pose || !age;
    if (pose && age) {
      this.element.textContent = say`Headset, from the pose to the pixels:
        ${grouped(pose.median)} ms (median), ${grouped(pose.most)} ms (95 %).
        Age of the pose that the machine drew: ${grouped(age.median)} ms,
        ${grouped(age.most)} ms.`
        + (error ? ` ${say`Error of the predicted pose: ${grouped(error.median, 1)} mm,
          ${grouped(error.most, 1)} mm.`}` : '');
    }
  }
}
