// Where planes cut a slice. Pure functions.
import {toPatient} from './patient_grid.js';
import {placeAlong, voxelAt} from './slice_pixels.js';

/** @typedef {import('./patient_grid.js').Grid} Grid */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/**
 * A straight line on a slice, in mm along its sides as placeAlong() has them, and the direction, of
 * unit length, to the side that is kept; null if both are.
 * @typedef {{from: [number, number], to: [number, number], kept: [number, number] | null}} Cut
 */

/**
 * Where clip planes cut a slice, and another slice does.
 * @param {Slice} slice
 * @param {Grid} grid
 * @param {ArrayLike<number>[]} clips
 * @param {ArrayLike<number> | null} other
 * @returns {Cut[]}
 */
export function cutsOf(slice, grid, clips, other) {
  const line = other && !slice.oblique && cutOf(slice, grid, other);
  return [...clips.flatMap(plane => cutOf(slice, grid, plane) ?? []),
    ...line ? [{...line, kept: null}] : []];
}

/**
 * The line on which a plane cuts a slice, from border to border; null if it does not.
 * @param {Slice} slice
 * @param {Grid} grid
 * @param {ArrayLike<number>} plane  Kept is plane . (p, 1) >= 0, in mm, LPS.
 * @returns {Cut | null}
 */
export function cutOf(slice, grid, plane) {
  const low = [placeAlong(slice, 0, -0.5), placeAlong(slice, 1, -0.5)];
  const high = [placeAlong(slice, 0, slice.width - 0.5), placeAlong(slice, 1, slice.height - 0.5)];
  const depth = (/** @type {number} */ x, /** @type {number} */ y) => {
    const p = toPatient(grid, voxelAt(slice, grid.size, x, y));
    return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
  };
  // The depth is linear in mm along the sides, also of a sheared slice.
  const at = depth(0, 0), across_mm = placeAlong(slice, 0, 1), down_mm = placeAlong(slice, 1, 1);
  const across = (depth(1, 0) - at) / across_mm, down = (depth(0, 1) - at) / down_mm;
  const steep = Math.hypot(across, down);
  if (steep < 1e-9) {
    return null;
  }
  /** @type {[number, number][]} */
  const ends = [];
  const add = (/** @type {number} */ u, /** @type {number} */ v) => {
    const isWithin = u >= low[0] - 1e-9 && u <= high[0] + 1e-9 && v >= low[1] - 1e-9 &&
      v <= high[1] + 1e-9;
    if (isWithin && !ends.some(end => Math.hypot(end[0] - u, end[1] - v) < 1e-9)) {
      ends.push([u, v]);
    }
  };
  for (const u of down === 0 ? [] : [low[0], high[0]]) {
    add(u, -(at + across * u) / down);
  }
  for (const v of across === 0 ? [] : [low[1], high[1]]) {
    add(-(at + down * v) / across, v);
  }
  return ends.length < 2 ? null
    : {from: ends[0], to: ends[1], kept: [across / steep, down / steep]};
}
