// The triangles of a picture that is shown from other viewpoints.
import {cornerOf} from './lean_depths.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */

export const SEAM_COLUMNS = 1024;   // Texels per row of the texture of seams.
const STEEP = 6;                    // Cells with a smaller range of depths never tear.

/**
 * The triangles of all cells that show something, counterclockwise as seen by the camera of the
 * picture, and the texels of the corners of seams. Cells that may tear come last.
 * @param {LeanDepths} lean
 * @param {Uint8Array} covered  Of cells.
 */
export function meshOf({columns, rows, corners, seams}, covered) {
  const inner = covered.slice();
  for (const {cell} of seams) {
    inner[cell] = 0;
  }
  const surfaces = seams.flatMap(({cell, near_pixels, near, far}) => [
    {cell, pixels: ~near_pixels & 0xffff, depths: far},
    ...(near_pixels === 0 ? [] : [{cell, pixels: near_pixels, depths: near}])]);
  let cells = 0;
  for (const each of inner) {
    cells += each;
  }
  const triangles = new Uint32Array(6 * (cells + surfaces.length));
  let at = 0;
  // Two triangles. No arrays are made: there are ten thousands of cells.
  const add = (/** @type {number} */ corner, /** @type {number} */ right,
    /** @type {number} */ below) => {
    triangles[at++] = corner;
    triangles[at++] = below;
    triangles[at++] = corner + right;
    triangles[at++] = corner + right;
    triangles[at++] = below;
    triangles[at++] = below + right;
  };
  const steep = [];
  for (let cell = 0; cell < inner.length; ++cell) {
    if (inner[cell]) {
      const corner = cornerOf(cell, columns), below = corner + columns;
      const a = corners[corner], b = corners[corner + 1];
      const c = corners[below], d = corners[below + 1];
      if (Math.max(a, b, c, d) - Math.min(a, b, c, d) >= STEEP) {
        steep.push(corner);
      } else {
        add(corner, 1, below);
      }
    }
  }
  const steepAt = at;
  for (const corner of steep) {
    add(corner, 1, corner + columns);
  }
  const texelRows = Math.max(1, Math.ceil(4 * surfaces.length / SEAM_COLUMNS));
  const texels = new Uint32Array(2 * SEAM_COLUMNS * texelRows);
  surfaces.forEach(({cell, pixels, depths}, index) => {
    const first = columns * rows + 4 * index;
    add(first, 1, first + 2);
    const place = cell % (columns - 1) | Math.floor(cell / (columns - 1)) << 16;
    depths.forEach((depth, corner) => {
      texels[2 * (4 * index + corner)] = depth | pixels << 16;
      texels[2 * (4 * index + corner) + 1] = place;
    });
  });
  return {triangles, steepAt, texels, texelRows};
}
