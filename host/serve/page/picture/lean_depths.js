// The depths of a picture as the server sends them: host/serve/depths/lean_packing.hpp.
import {inflate} from '../link/inflate.js';
import {say} from '../texts/say.js';

export const CELL_PX = 4;    // Width and height of a cell.
export const MAX_LEAN = 4095;
const SEAM_BYTES = 18;       // The near pixels and eight depths, of two bytes each.

/**
 * Depths at the corners of cells, and which pixels show a surface. The C++ struct of this name has
 * the same fields.
 * @typedef {object} LeanDepths
 * @property {number} columns       Of corners: one more than of cells.
 * @property {number} rows
 * @property {Uint16Array} corners  0: no surface around; else 1 (near plane) to MAX_LEAN.
 * @property {Uint8Array} mask      Rows of bytes: a bit per pixel, the left pixel lowest.
 * @property {Seam[]} seams         In order of cells.
 */

/**
 * A cell that its corners do not describe, because it shows two surfaces or lies beside an edge.
 * @typedef {object} Seam
 * @property {number} cell          Row by row, from 0.
 * @property {number} near_pixels   Bit x + 4 y: the pixel shows the near surface. 0: one surface.
 * @property {number[]} near        Depths at the upper left, upper right, lower left, lower right.
 * @property {number[]} far
 */

/** @param {number} width */
export function maskRowBytes(width) {
  return Math.ceil(width / 8);
}

/** Whether this browser can decode depths. */
export function canUnpack() {
  try {
    return Boolean(new DecompressionStream('deflate-raw'));
  } catch {
    return false;  // Browsers before 2023.
  }
}

/**
 * @param {Uint8Array} packed
 * @param {number} width   Of the picture, pixels.
 * @param {number} height
 * @returns {Promise<LeanDepths>}
 * @throws {Error} if the bytes are not those of a picture of this size
 */
export async function unpack(packed, width, height) {
  const columns = Math.ceil(width / CELL_PX) + 1, rows = Math.ceil(height / CELL_PX) + 1;
  const maskBytes = maskRowBytes(width) * height, count = columns * rows;
  const bytes = new Uint8Array(await inflate(packed, 'deflate-raw'));
  const seamsAt = maskBytes + 2 * count, cellBytes = Math.ceil((columns - 1) * (rows - 1) / 8);
  const cells = setBits(bytes.subarray(seamsAt, seamsAt + cellBytes));
  const end = seamsAt + cellBytes + SEAM_BYTES * cells.length;
  if (bytes.length !== end) {
    throw new Error(say`depths: ${bytes.length} bytes, but a picture of ${width} x ${height} pixels
      with ${cells.length} seams has ${end}. Load the page again; it may be older than the
      server.`);
  }
  const mask = bytes.slice(0, maskBytes);
  for (let above = 0, at = maskRowBytes(width); at < maskBytes; ++above, ++at) {
    mask[at] ^= mask[above];
  }
  const corners = undone(bytes.subarray(maskBytes, maskBytes + count),
    bytes.subarray(maskBytes + count, seamsAt), columns);
  clearUnused(corners, coveredCells({columns, rows, mask}, width, height), columns, rows);
  const seams = seamsOf(cells, bytes.subarray(seamsAt + cellBytes), corners, columns);
  return {columns, rows, corners, mask, seams};
}

/**
 * The numbers of the bits that are set, the lowest bit of the first byte first.
 * @param {Uint8Array} bytes
 */
function setBits(bytes) {
  /** @type {number[]} */
  const found = [];
  for (let at = 0; at < bytes.length; ++at) {
    const byte = bytes[at];
    for (let bit = 0; byte >> bit !== 0; ++bit) {
      if (byte >> bit & 1) {
        found.push(8 * at + bit);
      }
    }
  }
  return found;
}

/** @param {number} folded  A difference whose sign is in bit 0. */
function unfolded(folded) {
  return folded >> 1 ^ -(folded & 1);
}

/**
 * @param {number[]} cells
 * @param {Uint8Array} bytes     Planes of low and of high bytes.
 * @param {Uint16Array} corners
 * @param {number} columns
 * @returns {Seam[]}
 */
function seamsOf(cells, bytes, corners, columns) {
  const count = cells.length;
  return cells.map((cell, at) => {
    const value = (/** @type {number} */ plane) =>
      bytes[2 * plane * count + at] | bytes[(2 * plane + 1) * count + at] << 8;
    const corner = cornerOf(cell, columns), below = corner + columns;
    const depth = (/** @type {number} */ at, /** @type {number} */ plane) =>
      corners[at] + unfolded(value(plane)) & MAX_LEAN;
    const depths = (/** @type {number} */ first) => [depth(corner, first),
      depth(corner + 1, first + 1), depth(below, first + 2), depth(below + 1, first + 3)];
    return {cell, near_pixels: value(0), near: depths(1), far: depths(5)};
  });
}

/**
 * The upper left corner of a cell.
 * @param {number} cell
 * @param {number} columns  Of corners.
 */
export function cornerOf(cell, columns) {
  return cell + Math.floor(cell / (columns - 1));
}

/**
 * Adds the differences to what is predicted.
 * @param {Uint8Array} low   Bytes of all differences.
 * @param {Uint8Array} high
 * @param {number} columns
 */
function undone(low, high, columns) {
  const corners = new Uint16Array(low.length);
  for (let at = 0; at < corners.length;) {
    // The row above the first row, and the column at the left of the first column, are 0.
    let left = 0, upperLeft = 0;
    for (const end = at + columns; at < end; ++at) {
      const up = at < columns ? 0 : corners[at - columns];
      const predicted = Math.max(1, Math.min(MAX_LEAN, left + up - upperLeft));
      left = predicted + unfolded(low[at] | high[at] << 8) & MAX_LEAN;
      corners[at] = left;
      upperLeft = up;
    }
  }
  return corners;
}

export const FULL = 2;  // A cell whose pixels all show a surface.

/**
 * Which cells show a surface: 0, 1, or FULL for each, row by row.
 * @param {{columns: number, rows: number, mask: Uint8Array}} lean
 * @param {number} width
 * @param {number} height
 */
export function coveredCells({columns, rows, mask}, width, height) {
  const across = columns - 1, rowBytes = maskRowBytes(width);
  const covered = new Uint8Array(across * (rows - 1));
  for (let row = 0; row + 1 < rows; ++row) {
    for (let k = 0; k < rowBytes; ++k) {
      let any = 0, all = 0xff;
      for (let y = CELL_PX * row; y < CELL_PX * (row + 1); ++y) {
        const bits = y < height ? mask[y * rowBytes + k] : 0;
        any |= bits;
        all &= bits;
      }
      const cell = row * across + 2 * k;
      if (any & 0x0f) {
        covered[cell] = (all & 0x0f) === 0x0f ? FULL : 1;
      }
      if (any & 0xf0) {
        covered[cell + 1] = (all & 0xf0) === 0xf0 ? FULL : 1;
      }
    }
  }
  return covered;
}

/**
 * Sets the corners without a surface around to 0: they are sent as what was predicted.
 * @param {Uint16Array} corners
 * @param {Uint8Array} covered  Of cells.
 * @param {number} columns
 * @param {number} rows
 */
function clearUnused(corners, covered, columns, rows) {
  const used = new Uint8Array(corners.length);
  for (let row = 0, cell = 0; row + 1 < rows; ++row) {
    for (let column = 0; column + 1 < columns; ++column, ++cell) {
      if (covered[cell]) {
        const corner = row * columns + column;
        used[corner] = used[corner + 1] = used[corner + columns] = used[corner + columns + 1] = 1;
      }
    }
  }
  for (let at = 0; at < corners.length; ++at) {
    if (!used[at]) {
      corners[at] = 0;
    }
  }
}
