// Lengths, angles and statistics of measurements.
import {say} from '../texts/say.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('./measures.js').Values} Values */

/**
 * The length of a path through points.
 * @param {Triple[]} points_mm
 */
export function lengthOf(points_mm) {
  return points_mm.slice(1).reduce((sum, p, k) => sum + Math.hypot(p[0] - points_mm[k][0],
    p[1] - points_mm[k][1], p[2] - points_mm[k][2]), 0);
}

/**
 * The angle at the second of three points, in degrees.
 * @param {Triple[]} points_mm
 * @throws {Error} if the vertex is one of the others
 */
export function angleOf([a, vertex, b]) {
  const from = (/** @type {Triple} */ p) => p.map((value, k) => value - vertex[k]);
  const [u, v] = [from(a), from(b)];
  const lengths = Math.hypot(...u) * Math.hypot(...v);
  if (lengths === 0) {
    throw new Error(say`Two points of the angle are the same. Click three different points.`);
  }
  // By sine and cosine: the cosine alone is inexact near 0 and 180 degrees.
  const cross = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
    u[0] * v[1] - u[1] * v[0]);
  return Math.atan2(cross, u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * 180 / Math.PI;
}

/**
 * Mean, standard deviation (divided by n - 1), least and largest value.
 * @param {number[]} values
 * @returns {Values}
 * @throws {Error} without values
 */
export function valuesOf(values) {
  if (values.length === 0) {
    throw new Error(say`The region contains no voxel center. Draw a larger region.`);
  }
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const squares = values.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return {voxels: values.length, mean,
    deviation: values.length > 1 ? Math.sqrt(squares / (values.length - 1)) : null,
    least: values.reduce((a, b) => Math.min(a, b)), most: values.reduce((a, b) => Math.max(a, b))};
}
