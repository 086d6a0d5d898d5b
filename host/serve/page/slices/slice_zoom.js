// Which part of a slice a view shows. Pure functions.

/**
 * @typedef {object} Zoom
 * @property {number} times             1: the whole slice fits into the view.
 * @property {[number, number]} center  The place in the middle of the view, across and down, as
 *     shares of the slice: 0 is its left or top edge, 1 the other one.
 */

/** @type {Zoom} */
export const WHOLE = {times: 1, center: [0.5, 0.5]};
export const MOST_TIMES = 32;
export const ZOOM_STEP = 1.25;     // Of one key, one button, or one notch of a wheel.
const MARGIN = 0.08;  // revealed() keeps this share of the view free beside a place.

/** @param {number} times */
export function limitedTimes(times) {
  return Math.min(Math.max(times, 1), MOST_TIMES);
}

/**
 * Zooms so that a place of the slice stays where the view shows it. A whole slice is in the middle.
 * @param {Zoom} zoom
 * @param {number} times
 * @param {[number, number]} place  As a center.
 * @returns {Zoom}
 */
export function zoomedAt(zoom, times, place) {
  const side = (/** @type {0 | 1} */ k) =>
    place[k] - (place[k] - zoom.center[k]) * zoom.times / times;
  return times === 1 ? WHOLE : movedTo({times, center: zoom.center}, [side(0), side(1)]);
}

/**
 * The middle of the view always shows a place of the slice; a whole slice does not move.
 * @param {Zoom} zoom
 * @param {[number, number]} center
 * @returns {Zoom}
 */
export function movedTo({times}, [across, down]) {
  const limited = (/** @type {number} */ place) => Math.min(Math.max(place, 0), 1);
  return times === 1 ? WHOLE : {times, center: [limited(across), limited(down)]};
}

/**
 * The center nearest to `center` that brings a place into the view.
 * @param {number} center
 * @param {number} shown    Length of the view as a share of the slice's.
 * @param {number} place
 */
export function revealed(center, shown, place) {
  const reach = (0.5 - MARGIN) * shown;
  return Math.min(Math.max(center, place - reach), place + reach);
}
