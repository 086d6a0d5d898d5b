// The address of a step of the tour: #tour=3, or #tour=3&pixel=256,200 for a pixel that the user
// has chosen.

export const STEP_COUNT = 6;

/** @typedef {{x: number, y: number}} Pixel */

/**
 * The step that an address names.
 * @param {string} hash  Of the address, with its '#'.
 * @returns {{step: number, pixel: Pixel | null} | null}  step: 1 to 6; null for another address.
 */
export function stepOf(hash) {
  const words = new URLSearchParams(hash.slice(1));
  const step = Number(words.get('tour') ?? NaN);
  if (!Number.isInteger(step) || step < 1 || step > STEP_COUNT) {
    return null;
  }
  const found = /^(\d{1,5}),(\d{1,5})$/.exec(words.get('pixel') ?? '');
  return {step, pixel: found && {x: Number(found[1]), y: Number(found[2])}};
}

/**
 * @param {number} step
 * @param {Pixel | null} pixel  Of the user; null if the tour chooses.
 */
export function hashOf(step, pixel) {
  return `#tour=${step}${pixel ? `&pixel=${pixel.x},${pixel.y}` : ''}`;
}
