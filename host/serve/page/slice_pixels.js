// A slice's answer taken apart: values, contours, grey levels, and which voxel a pixel is. Pure.

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {'x' | 'y' | 'z'} Axis */
/** @typedef {{surface: string, color: string, first: number, count: number}} Contour */

/**
 * @typedef {object} Slice
 * @property {Axis} axis            Voxel axis that it stands across.
 * @property {number} index
 * @property {number} width         Pixels.
 * @property {number} height
 * @property {[number, number]} spacing_mm      Across, down.
 * @property {{left: string, right: string, top: string, bottom: string}} letters
 * @property {[number, number, number]} axes    Voxel axis across, down, through.
 * @property {[boolean, boolean]} flips         Whether pixels run against the voxels.
 * @property {ArrayLike<number>} values         Row by row from the top left.
 * @property {Contour[]} contours               `first` and `count` count segments.
 * @property {Float32Array} segments            x, y, x, y of each, in pixels.
 */

/** @type {Record<string, any>} */
const ARRAYS = {
  uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, float32: Float32Array,
};
const ALIGNMENT = 8;
const FLOATS_PER_SEGMENT = 4;

/**
 * @param {Axis} axis
 * @param {number} index
 * @param {{json: any, bytes: ArrayBuffer}} answer  To `ask slice`.
 * @returns {Slice}
 * @throws {Error} if the bytes are fewer than the JSON says
 */
export function sliceOf(axis, index, {json, bytes}) {
  const array = ARRAYS[json.type];
  if (!array) {
    throw new Error(`slice: values of type '${json.type}' are not known here`);
  }
  const count = json.width * json.height;
  const segments = json.contours.reduce(
    (/** @type {number} */ most, /** @type {Contour} */ c) => Math.max(most, c.first + c.count), 0);
  const behind = Math.ceil(count * array.BYTES_PER_ELEMENT / ALIGNMENT) * ALIGNMENT;
  const needed = behind + segments * FLOATS_PER_SEGMENT * 4;
  if (bytes.byteLength < needed) {
    throw new Error(`slice: ${bytes.byteLength} bytes came, its description needs ${needed}`);
  }
  return {
    ...json, axis, index, values: new array(bytes, 0, count),
    segments: new Float32Array(bytes, behind, segments * FLOATS_PER_SEGMENT),
  };
}

/** @typedef {{window: number, level: number}} Window  Values shown from level - window / 2 on. */

/**
 * Windows that radiologists know, by name, in Hounsfield units.
 * @type {{name: string, window: number, level: number}[]}
 */
export const CT_WINDOWS = [
  {name: 'Soft tissue', window: 400, level: 40},
  {name: 'Bone', window: 1800, level: 400},
  {name: 'Lung', window: 1500, level: -600},
];

/**
 * The window that a volume is first seen through.
 * @param {{modality: string, minimum: number, maximum: number}} volume
 * @returns {Window}
 */
export function firstWindow(volume) {
  const range = volume.maximum - volume.minimum || 1;
  if (volume.modality === 'CT') {
    return {window: CT_WINDOWS[0].window, level: CT_WINDOWS[0].level};
  }
  return {window: range, level: volume.minimum + range / 2};
}

/**
 * Writes grey levels into RGBA pixels.
 * @param {ArrayLike<number>} values
 * @param {Window} through
 * @param {Uint8ClampedArray} rgba  4 * values.length; rounded and held at 0..255 by its type.
 */
export function paintGrey(values, {window, level}, rgba) {
  const slope = 255 / Math.max(window, Number.MIN_VALUE);
  const first = level - window / 2;
  for (let i = 0, out = 0; i < values.length; ++i, out += 4) {
    rgba[out] = rgba[out + 1] = rgba[out + 2] = (values[i] - first) * slope;
    rgba[out + 3] = 255;
  }
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
  const [across, down] = slice.axes;
  return [slice.flips[0] ? size[across] - 1 - voxel[across] : voxel[across],
    slice.flips[1] ? size[down] - 1 - voxel[down] : voxel[down]];
}

/**
 * Where the slice stands in a box, its millimetres alike across and down.
 * @param {Slice} slice
 * @param {number} width    Of the box.
 * @param {number} height
 * @returns {{x: number, y: number, width: number, height: number}}
 */
export function placedIn(slice, width, height) {
  const across = slice.width * slice.spacing_mm[0], down = slice.height * slice.spacing_mm[1];
  const scale = Math.min(width / across, height / down);
  return {
    x: (width - across * scale) / 2, y: (height - down * scale) / 2,
    width: across * scale, height: down * scale,
  };
}
