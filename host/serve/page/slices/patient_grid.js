// Converts between voxels and patient positions. Pure functions; column-major matrices.
import {grouped} from '../elements/numbers.js';

/**
 * @typedef {[number, number, number]} Vector
 * @typedef {object} Grid               What places voxels in the patient: part of VolumeState.
 * @property {number[]} voxel_to_patient   Takes (x, y, place of slice z) to mm, LPS.
 * @property {number[]} slice_places    Position of each slice; empty if slice z is at z.
 * @property {Vector} size              Voxels.
 */

/**
 * @param {number[]} m          4 x 4, affine.
 * @param {ArrayLike<number>} p
 * @returns {Vector}
 */
export function transformed(m, p) {
  const row = (/** @type {number} */ r) =>
    m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
  return [row(0), row(1), row(2)];
}

/**
 * The point that an affine map maps to q.
 * @param {number[]} m          4 x 4, affine.
 * @param {ArrayLike<number>} q
 * @returns {Vector}
 */
export function solved(m, q) {
  const [a, b, c] = [m.slice(0, 3), m.slice(4, 7), m.slice(8, 11)];
  const d = [q[0] - m[12], q[1] - m[13], q[2] - m[14]];
  const whole = tripleProduct(a, b, c);
  return [tripleProduct(d, b, c) / whole, tripleProduct(a, d, c) / whole,
    tripleProduct(a, b, d) / whole];
}

/**
 * @param {number[]} a
 * @param {number[]} b
 * @param {number[]} c
 */
function tripleProduct(a, b, c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
    a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/**
 * Position of a slice, interpolated linearly between slices.
 * @param {number[]} places
 * @param {number} z            Counts slices.
 */
export function placeOf(places, z) {
  if (places.length < 2) {
    return z;
  }
  const k = Math.min(Math.max(Math.floor(z), 0), places.length - 2);
  return places[k] + (z - k) * (places[k + 1] - places[k]);
}

/**
 * The slice number at a position: the inverse of placeOf.
 * @param {number[]} places
 * @param {number} place
 */
export function sliceAt(places, place) {
  if (places.length < 2) {
    return place;
  }
  let k = 0;
  while (k < places.length - 2 && places[k + 1] <= place) {
    ++k;
  }
  return k + (place - places[k]) / (places[k + 1] - places[k]);
}

/**
 * @param {Grid} grid
 * @param {Vector} voxel
 * @returns {Vector}  mm, LPS.
 */
export function toPatient(grid, voxel) {
  const place = placeOf(grid.slice_places, voxel[2]);
  return transformed(grid.voxel_to_patient, [voxel[0], voxel[1], place]);
}

/**
 * @param {Grid} grid
 * @param {Vector} p_mm  LPS.
 * @returns {Vector}     Not rounded.
 */
export function toVoxel(grid, p_mm) {
  const [x, y, place] = solved(grid.voxel_to_patient, p_mm);
  return [x, y, sliceAt(grid.slice_places, place)];
}

/**
 * The nearest voxel inside the volume.
 * @param {Grid} grid
 * @param {Vector} voxel
 * @returns {Vector}
 */
export function nearestVoxel(grid, voxel) {
  const held = (/** @type {number} */ axis) =>
    Math.min(Math.max(Math.round(voxel[axis]), 0), grid.size[axis] - 1);
  return [held(0), held(1), held(2)];
}

/**
 * "R 12.3  P 4.0  S 102.5 mm": a place in the patient as radiologists say it.
 * @param {ArrayLike<number>} p_mm  LPS.
 */
export function patientText(p_mm) {
  const part = (/** @type {number} */ axis) =>
    `${(p_mm[axis] < 0 ? 'RAI' : 'LPS')[axis]} ${grouped(Math.abs(p_mm[axis]), 1)}`;
  return `${part(0)}  ${part(1)}  ${part(2)} mm`;
}
