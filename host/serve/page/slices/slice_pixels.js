// Parses the answer to `ask slice`, and converts between pixels and voxels. Pure functions.
import {say} from '../texts/say.js';
import {onPlane, voxelOnPlane} from './oblique_plane.js';
import {placeOf, sliceAt} from './patient_grid.js';
import {WHOLE} from './slice_zoom.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_zoom.js').Zoom} Zoom */
/** @typedef {'x' | 'y' | 'z'} Axis */
/**
 * @typedef {{grid: import('./patient_grid.js').Grid, plane: import('./oblique_plane.js').Plane}}
 *   Oblique
 */
/**
 * @typedef {{surface: string, color: string, isovalue: number, first: number, count: number,
 *   left_out?: number}} Contour */

/**
 * @typedef {object} Slice
 * @property {Axis | 'oblique'} axis  Voxel axis perpendicular to the slice.
 * @property {number} index
 * @property {number} frame         Number of its volume in the time series.
 * @property {Oblique} [oblique]    The slice is oblique: it has no axes, flips and index.
 * @property {number} width         Pixels.
 * @property {number} height
 * @property {[number, number]} spacing_mm      Across, down.
 * @property {[number[] | null, number[] | null]} [places_mm]   Across, down: middles of all
 *     voxels from the first one's; null where they are evenly spaced.
 * @property {number} [skew_deg]    90 minus the angle between the sides.
 * @property {{left: string, right: string, top: string, bottom: string}} letters
 * @property {[number, number, number]} axes    Voxel axis across, down, through.
 * @property {[boolean, boolean]} flips         Whether pixels run against the voxels.
 * @property {ArrayLike<number>} values         Row by row from the top left.
 * @property {Contour[]} contours               `first` and `count` count segments.
 * @property {import('./slice_slab.js').ShownSlab} [slab]  `values` are those of a slab.
 * @property {ArrayLike<number>} own            The values of the slice itself, as `values`.
 * @property {Float32Array} segments            x, y, x, y of each, in pixels.
 */

/**
 * The arrays of the types of values.
 * @type {Record<string, any>}
 */
export const ARRAYS = {
  uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, float32: Float32Array,
};
const ALIGNMENT = 8;
const FLOATS_PER_SEGMENT = 4;

/**
 * @param {import('./slice_source.js').Question} question
 * @param {{json: any, bytes: ArrayBuffer}} answer  To `ask slice`.
 * @returns {Slice}
 * @throws {Error} if the bytes are fewer than the JSON says
 */
export function sliceOf({axis, index = 0, oblique}, {json, bytes}) {
  const array = ARRAYS[json.type];
  if (!array) {
    throw new Error(say`slice: values of type '${json.type}' are not known here`);
  }
  const count = json.width * json.height;
  const segments = json.contours.reduce(
    (/** @type {number} */ most, /** @type {Contour} */ c) => Math.max(most, c.first + c.count), 0);
  const behind = Math.ceil(count * array.BYTES_PER_ELEMENT / ALIGNMENT) * ALIGNMENT;
  const middle = behind + segments * FLOATS_PER_SEGMENT * 4;  // The slice in a slab's middle.
  const own = json.slab ? ARRAYS[json.slab.type] : array;
  const needed = middle + (json.slab ? count * own.BYTES_PER_ELEMENT : 0);
  if (bytes.byteLength < needed) {
    throw new Error(say`slice: ${bytes.byteLength} bytes came, its description needs ${needed}`);
  }
  const values = new array(bytes, 0, count);
  return {
    ...json, axis, index, oblique, values, own: json.slab ? new own(bytes, middle, count) : values,
    segments: new Float32Array(bytes, behind, segments * FLOATS_PER_SEGMENT),
  };
}

/**
 * The voxel that pixel (x, y) shows, of a volume of that size. Not rounded.
 * @param {Slice} slice
 * @param {Vector} size
 * @param {number} x
 * @param {number} y
 * @returns {Vector}
 */
export function voxelAt(slice, size, x, y) {
  if (slice.oblique) {
    return voxelOnPlane(slice.oblique.grid, slice.oblique.plane, x, y);
  }
  const [across, down, through] = slice.axes;
  /** @type {Vector} */
  const voxel = [0, 0, 0];
  voxel[across] = slice.flips[0] ? size[across] - 1 - x : x;
  voxel[down] = slice.flips[1] ? size[down] - 1 - y : y;
  voxel[through] = slice.index;
  return voxel;
}

/**
 * The pixel that shows a voxel: the inverse of voxelAt.
 * @param {Slice} slice
 * @param {Vector} size
 * @param {Vector} voxel
 * @returns {[number, number]}
 */
export function pixelAt(slice, size, voxel) {
  if (slice.oblique) {
    return onPlane(slice.oblique.grid, slice.oblique.plane, voxel).pixel;
  }
  const [across, down] = slice.axes;
  return [slice.flips[0] ? size[across] - 1 - voxel[across] : voxel[across],
    slice.flips[1] ? size[down] - 1 - voxel[down] : voxel[down]];
}

/**
 * Whether a place is on a slice.
 * @param {Slice} slice
 * @param {[number, number]} pixel  Not rounded.
 */
export function isInside({width, height}, [x, y]) {
  return x >= -0.5 && y >= -0.5 && x <= width - 0.5 && y <= height - 0.5;
}

/**
 * How far a voxel is from a slice, in slices; from an oblique one, in pixels.
 * @param {Slice} slice
 * @param {Vector} voxel
 */
export function depthOf({axes, index, oblique}, voxel) {
  return oblique ? onPlane(oblique.grid, oblique.plane, voxel).depth : voxel[axes[2]] - index;
}

/**
 * The distance from the center of the first pixel to the center of a pixel along a side,
 * interpolated linearly, also beyond the ends.
 * @param {Slice} slice
 * @param {0 | 1} side      Across, down.
 * @param {number} number   Counts pixels, not rounded.
 * @returns {number}        mm
 */
export function placeAlong(slice, side, number) {
  const places = slice.places_mm?.[side];
  return places ? placeOf(places, number) : number * slice.spacing_mm[side];
}

/**
 * The inverse of placeAlong.
 * @param {Slice} slice
 * @param {0 | 1} side
 * @param {number} place_mm
 */
export function numberAlong(slice, side, place_mm) {
  const places = slice.places_mm?.[side];
  return places ? sliceAt(places, place_mm) : place_mm / slice.spacing_mm[side];
}

/**
 * Where the slice stands in a box, its millimeters alike across and down: pixels of the box at
 * (x, y) are at (first[0] + (x - left) / scale, ...) mm of the slice's sides.
 * @typedef {{left: number, top: number, width: number, height: number, scale: number,
 *   first: [number, number]}} Placed
 */

/**
 * @param {Slice} slice
 * @param {number} width    Width of the box.
 * @param {number} height
 * @param {Zoom} [zoom]     The whole slice, if not given.
 * @returns {Placed}
 */
export function placedIn(slice, width, height, {times, center} = WHOLE) {
  /** @type {[number, number]} */
  const first = [placeAlong(slice, 0, -0.5), placeAlong(slice, 1, -0.5)];
  const across_mm = placeAlong(slice, 0, slice.width - 0.5) - first[0];
  const down_mm = placeAlong(slice, 1, slice.height - 0.5) - first[1];
  const scale = times * Math.min(width / across_mm, height / down_mm);
  const across = across_mm * scale, down = down_mm * scale;
  return {
    left: width / 2 - center[0] * across, top: height / 2 - center[1] * down,
    width: across, height: down, scale, first,
  };
}

/**
 * The values of the pixels whose middles lie in a region between two corners, and its area. Pixels
 * count as in voxelAt().
 * @param {Slice} slice
 * @param {'ellipse' | 'rectangle'} kind
 * @param {[number, number]} a  A corner of the box around the region.
 * @param {[number, number]} b  The opposite one.
 * @returns {{values: number[], area_mm2: number}}
 */
export function valuesIn(slice, kind, a, b) {
  const along = (/** @type {0 | 1} */ side) => {
    const [p, q] = [placeAlong(slice, side, a[side]), placeAlong(slice, side, b[side])];
    return {middle: (p + q) / 2, radius: Math.abs(q - p) / 2};
  };
  const across = along(0), down = along(1);
  /** How far a pixel is from the middle; 1 on the edge of the box. */
  const far = (/** @type {{middle: number, radius: number}} */ {middle, radius},
    /** @type {0 | 1} */ side, /** @type {number} */ number) =>
    radius === 0 ? Infinity : Math.abs(placeAlong(slice, side, number) - middle) / radius;
  /** @type {number[]} */
  const values = [];
  for (let y = 0; y < slice.height; ++y) {
    const v = far(down, 1, y);
    for (let x = 0; v <= 1 && x < slice.width; ++x) {
      const u = far(across, 0, x);
      if (kind === 'ellipse' ? u * u + v * v <= 1 : u <= 1) {
        values.push(slice.values[y * slice.width + x]);
      }
    }
  }
  const shape = kind === 'ellipse' ? Math.PI : 4;
  const shear = Math.cos((slice.skew_deg ?? 0) * Math.PI / 180);
  return {values, area_mm2: shape * across.radius * down.radius * shear};
}

/**
 * A place in the box from slice pixels.
 * @param {Slice} slice
 * @param {Placed} placed
 * @param {number} x        Pixels of the slice, middles are whole.
 * @param {number} y
 * @returns {[number, number]}
 */
export function boxAt(slice, placed, x, y) {
  return [placed.left + (placeAlong(slice, 0, x) - placed.first[0]) * placed.scale,
    placed.top + (placeAlong(slice, 1, y) - placed.first[1]) * placed.scale];
}

/**
 * Slice pixels from a place in the box: the inverse of boxAt.
 * @param {Slice} slice
 * @param {Placed} placed
 * @param {number} x
 * @param {number} y
 * @returns {[number, number]}
 */
export function sliceAtBox(slice, placed, x, y) {
  return [numberAlong(slice, 0, (x - placed.left) / placed.scale + placed.first[0]),
    numberAlong(slice, 1, (y - placed.top) / placed.scale + placed.first[1])];
}
