// Stereo pictures: where each eye's picture lies in the whole picture. Pure functions.

/** @typedef {import('../link/vocabulary.js').State} State */

/**
 * What the command `stereo` has set.
 * @typedef {object} Stereo
 * @property {string} mode            off, anaglyph, sbs, cross or rows
 * @property {number} separation_mm   0: by the distance and the zoom.
 * @property {number} convergence_mm  0: the camera's distance.
 */

/**
 * The part of a picture that an eye sees.
 * @typedef {object} Part
 * @property {number[]} eyes  0: left, 1: right. Two: both see the part.
 * @property {number} left    From the left edge of the picture, as a share of its width.
 * @property {number} width   Share of the width.
 */

/**
 * @param {State} state
 * @returns {Stereo}
 */
export function stereoOf({stereo, stereo_separation_mm, stereo_convergence_mm}) {
  return {mode: stereo, separation_mm: stereo_separation_mm,
    convergence_mm: stereo_convergence_mm};
}

/**
 * The parts of a picture, from left to right, as composed() in host/scene/stereo.cpp makes them.
 * @param {string} mode
 * @returns {Part[]}
 */
export function partsOf(mode) {
  if (mode !== 'sbs' && mode !== 'cross') {
    return [{eyes: mode === 'off' ? [0] : [0, 1], left: 0, width: 1}];
  }
  return [0, 1].map(side =>
    ({eyes: [mode === 'cross' ? 1 - side : side], left: side / 2, width: 0.5}));
}

/**
 * The size of a picture with the parts of both eyes.
 * @param {number[]} size  Of one eye's picture.
 * @param {string} mode
 * @returns {[number, number]}
 */
export function composedSize([width, height], mode) {
  return [width * partsOf(mode).length, height];
}
