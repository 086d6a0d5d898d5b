// The place of an oblique slice in the patient. Pure functions.
import {toPatient, toVoxel} from './patient_grid.js';

/** @typedef {import('./patient_grid.js').Grid} Grid */
/** @typedef {import('./patient_grid.js').Vector} Vector */
/**
 * A picture's plane, LPS; `right` and `down` have the length 1 and are at a right angle.
 * @typedef {object} Plane
 * @property {Vector} center_mm     Middle of the picture.
 * @property {Vector} right
 * @property {Vector} down
 * @property {number} width         Pixels.
 * @property {number} height
 * @property {number} pixel_mm      Distance between the middles of neighbors.
 */
/**
 * Turns from the axial plane, in degrees. `tilt` turns about the axis from right to left: 90 is
 * coronal. `turn` then turns about the axis from top to bottom of the picture.
 * @typedef {{tilt: number, turn: number}} Angles
 */

const MOST_PX = 512;

/**
 * @param {Vector} a
 * @param {Vector} b
 */
export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/**
 * p + q * times
 * @param {Vector} p
 * @param {Vector} q
 * @param {number} times
 * @returns {Vector}
 */
export function moved(p, q, times) {
  return [p[0] + q[0] * times, p[1] + q[1] * times, p[2] + q[2] * times];
}

/**
 * Away from the viewer.
 * @param {Pick<Plane, 'right' | 'down'>} plane
 * @returns {Vector}
 */
export function normalOf({right: a, down: b}) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/**
 * @param {Angles} angles
 * @returns {{right: Vector, down: Vector}}
 */
export function sidesOf({tilt, turn}) {
  const [t, u] = [tilt, turn].map(degrees => degrees * Math.PI / 180);
  // Anterior on top; tilted, superior comes to the top.
  const down = /** @type {Vector} */ ([0, Math.cos(t), -Math.sin(t)]);
  const through = normalOf({right: [1, 0, 0], down});
  return {down, right: moved([Math.cos(u), 0, 0], through, Math.sin(u))};
}

/**
 * The plane through a place that shows the whole volume: its picture is around the middle of the
 * volume, as large as the diagonal of the volume, in pixels as large as the smallest distance of
 * voxels, but at most 512.
 * @param {Grid & {spacing_mm: number[]}} volume
 * @param {Angles} angles
 * @param {Vector} through_mm
 * @returns {Plane}
 */
export function planeThrough(volume, angles, through_mm) {
  const last = volume.size.map(count => count - 1);
  const [first_mm, end_mm] = [toPatient(volume, [0, 0, 0]),
    toPatient(volume, [last[0], last[1], last[2]])];
  const middle = moved(first_mm, moved(end_mm, first_mm, -1), 0.5);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(corner => toPatient(volume,
    [corner & 1 ? last[0] : 0, corner & 2 ? last[1] : 0, corner & 4 ? last[2] : 0]));
  const length_mm = 2 * Math.max(...corners.map(p => Math.hypot(...moved(p, middle, -1))));
  const pixel_mm = Math.max(Math.min(...volume.spacing_mm), length_mm / (MOST_PX - 1));
  const count = Math.min(Math.max(Math.ceil(length_mm / pixel_mm) + 1, 2), MOST_PX);
  const {right, down} = sidesOf(angles);
  const normal = normalOf({right, down});
  return {right, down, pixel_mm, width: count, height: count,
    center_mm: moved(middle, normal, dot(normal, moved(through_mm, middle, -1)))};
}

/**
 * @param {Grid} grid
 * @param {Plane} plane
 * @param {number} x        Pixels, not rounded.
 * @param {number} y
 * @returns {Vector}
 */
export function voxelOnPlane(grid, {center_mm, right, down, width, height, pixel_mm}, x, y) {
  return toVoxel(grid, moved(moved(center_mm, right, (x - (width - 1) / 2) * pixel_mm),
    down, (y - (height - 1) / 2) * pixel_mm));
}

/**
 * The pixel at the foot of the perpendicular from a voxel, and the distance in pixels.
 * @param {Grid} grid
 * @param {Plane} plane
 * @param {Vector} voxel
 * @returns {{pixel: [number, number], depth: number}}
 */
export function onPlane(grid, plane, voxel) {
  const from = moved(toPatient(grid, voxel), plane.center_mm, -1);
  return {pixel: [dot(from, plane.right) / plane.pixel_mm + (plane.width - 1) / 2,
    dot(from, plane.down) / plane.pixel_mm + (plane.height - 1) / 2],
  depth: dot(from, normalOf(plane)) / plane.pixel_mm};
}
