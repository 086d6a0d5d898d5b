// The triangles of a picture that is shown from other viewpoints.
import {CELL_PX, FULL, MAX_LEAN} from './lean_depths.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */

export const SEAM_COLUMNS = 1024;   // Texels per row of the texture of seams.
const BUCKETS = 14;                 // By the range of depths in a cell: 0, 1, 2 to 3, 4 to 7 ...
const SEAMS = BUCKETS, NOWHERE = 2 * BUCKETS + 1;  // Orders of a cell that has no bucket.
const NARROW = BUCKETS - 1;         // Of cells that the border of the picture makes narrower.
const ROUNDING = 6;                 // Blocks differ from the depths by at most this.
const MOST_MOVED_PX = 0.5;          // And show nothing further from its place than this.

/**
 * The triangles of a picture. Of cells with one surface in all pixels come first those with the
 * smallest range of depths; then come the seams; then the cells that show the background, too,
 * those with the largest range first.
 * @typedef {object} Mesh
 * @property {Uint32Array} triangles  Corners, counterclockwise as seen by the picture's camera.
 * @property {number[]} fullEnds      Where the full cells of each bucket end.
 * @property {number[]} partialEnds   Where the other cells of each bucket end.
 */

/**
 * @param {LeanDepths} lean
 * @param {Uint8Array} covered   Of cells, from coveredCells().
 * @param {number} width         Of the picture, pixels.
 * @param {number} height
 * @param {boolean} [hasBlocks]  Whether 2 x 2 cells that are nearly flat become one quadrilateral.
 * @returns {Mesh}
 */
export function meshOf({columns, rows, corners, seams}, covered, width, height, hasBlocks = true) {
  const across = columns - 1, down = rows - 1;
  // Where each cell is drawn: its bucket, that of seams, or one of those after it.
  const orders = new Uint8Array(covered.length).fill(NOWHERE);
  const counts = new Uint32Array(2 * BUCKETS + 1);  // Triangles.
  for (const {cell, near_pixels} of seams) {
    orders[cell] = SEAMS;
    counts[SEAMS] += near_pixels === 0 ? 2 : 4;
  }
  const blocks = new Blocks(corners, columns, rows);
  if (hasBlocks) {
    blocks.find(cell => covered[cell] === FULL && orders[cell] !== SEAMS);
  }
  blocks.forEach((corner, ring) => { counts[blocks.bucketOf(corner)] += ring === 4 ? 2 : ring; });
  for (let row = 0, cell = 0; row < down; ++row) {
    for (let column = 0; column < across; ++column, ++cell) {
      if (!covered[cell] || orders[cell] === SEAMS || blocks.has(column, row)) {
        continue;
      }
      const isNarrow = CELL_PX * (column + 1) > width || CELL_PX * (row + 1) > height;
      const range = rangeOf(corners, row * columns + column, columns);
      const bucket = isNarrow ? NARROW : bucketOf(range);
      const order = covered[cell] === FULL ? bucket : 2 * BUCKETS - bucket;
      orders[cell] = order;
      counts[order] += 2;
    }
  }
  const ends = new Uint32Array(counts.length);
  counts.reduce((end, count, order) => (ends[order] = end + 3 * count), 0);
  const next = ends.map((end, order) => end - 3 * counts[order]);
  const triangles = new Uint32Array(ends[2 * BUCKETS]);
  const add = (/** @type {number} */ order, /** @type {number} */ a, /** @type {number} */ b,
    /** @type {number} */ c) => {
    const at = next[order];
    next[order] = at + 3;
    triangles[at] = a;
    triangles[at + 1] = b;
    triangles[at + 2] = c;
  };
  const addCell = (/** @type {number} */ order, /** @type {number} */ corner,
    /** @type {number} */ below) => {
    add(order, corner, below, corner + 1);
    add(order, corner + 1, below, below + 1);
  };
  blocks.forEach((corner, count) => {
    const order = blocks.bucketOf(corner), {ring} = blocks, middle = corner + columns + 1;
    if (count === 4) {
      add(order, ring[0], ring[1], ring[3]);
      add(order, ring[3], ring[1], ring[2]);
      return;
    }
    for (let at = 0; at < count; ++at) {
      add(order, middle, ring[at], ring[at + 1 === count ? 0 : at + 1]);
    }
  });
  for (let row = 0, cell = 0; row < down; ++row) {
    for (let column = 0; column < across; ++column, ++cell) {
      if (orders[cell] !== SEAMS && orders[cell] !== NOWHERE) {
        const corner = row * columns + column;
        addCell(orders[cell], corner, corner + columns);
      }
    }
  }
  for (let surface = 0; surface < counts[SEAMS] / 2; ++surface) {
    const first = columns * rows + 4 * surface;
    addCell(SEAMS, first, first + 2);
  }
  return {triangles, fullEnds: [...ends.subarray(0, BUCKETS)],
    partialEnds: [...ends.subarray(BUCKETS + 1)].reverse()};
}

/**
 * The texels of the corners of seams, whose surfaces are vertices after the corners of the picture:
 * depth and pixels of the surface, and the place of its cell.
 * @param {LeanDepths} lean
 */
export function seamTexels({columns, seams}) {
  const across = columns - 1;
  const surfaces = seams.flatMap(({cell, near_pixels, near, far}) => [
    {cell, pixels: ~near_pixels & 0xffff, depths: far},
    ...(near_pixels === 0 ? [] : [{cell, pixels: near_pixels, depths: near}])]);
  const texelRows = Math.max(1, Math.ceil(4 * surfaces.length / SEAM_COLUMNS));
  const texels = new Uint32Array(2 * SEAM_COLUMNS * texelRows);
  surfaces.forEach(({cell, pixels, depths}, index) => {
    const place = cell % across | Math.floor(cell / across) << 16;
    depths.forEach((depth, corner) => {
      texels[2 * (4 * index + corner)] = depth | pixels << 16;
      texels[2 * (4 * index + corner) + 1] = place;
    });
  });
  return {texels, texelRows};
}

/** Blocks of 2 x 2 cells whose corners are nearly those of one quadrilateral. */
class Blocks {
  /**
   * @param {Uint16Array} corners
   * @param {number} columns
   * @param {number} rows
   */
  constructor(corners, columns, rows) {
    this.corners_ = corners;
    this.columns_ = columns;
    this.across_ = columns - 1 >> 1;
    this.down_ = rows - 1 >> 1;
    this.areBlocks_ = new Uint8Array(this.across_ * this.down_);
    /** The corners of a block and of its neighbors' cells on its border, counterclockwise. */
    this.ring = new Uint32Array(8);
  }

  /** @param {(cell: number) => boolean} isFull */
  find(isFull) {
    const {columns_: columns, across_: across} = this, cells = columns - 1;
    for (let row = 0, block = 0; row < this.down_; ++row) {
      for (let column = 0; column < across; ++column, ++block) {
        const cell = 2 * row * cells + 2 * column;
        this.areBlocks_[block] = isFull(cell) && isFull(cell + 1) && isFull(cell + cells)
          && isFull(cell + cells + 1) && this.isFlat_(2 * row * columns + 2 * column) ? 1 : 0;
      }
    }
  }

  /** Whether a cell belongs to a block. @param {number} column @param {number} row */
  has(column, row) {
    return this.isBlock_(column >> 1, row >> 1);
  }

  /**
   * Sets the ring of each block.
   * @param {(corner: number, count: number) => void} take  The upper left corner of the block, and
   *   the number of corners in the ring.
   */
  forEach(take) {
    const {columns_: columns, ring} = this;
    for (let row = 0; row < this.down_; ++row) {
      for (let column = 0; column < this.across_; ++column) {
        if (!this.isBlock_(column, row)) {
          continue;
        }
        const corner = 2 * row * columns + 2 * column, below = corner + 2 * columns;
        let count = 0;
        ring[count++] = corner;
        if (!this.isBlock_(column - 1, row)) {
          ring[count++] = corner + columns;
        }
        ring[count++] = below;
        if (!this.isBlock_(column, row + 1)) {
          ring[count++] = below + 1;
        }
        ring[count++] = below + 2;
        if (!this.isBlock_(column + 1, row)) {
          ring[count++] = corner + columns + 2;
        }
        ring[count++] = corner + 2;
        if (!this.isBlock_(column, row - 1)) {
          ring[count++] = corner + 1;
        }
        take(corner, count);
      }
    }
  }

  /** The bucket of a block. @param {number} corner  Its upper left one. */
  bucketOf(corner) {
    const {corners_: z, columns_: columns} = this, below = corner + columns;
    const ranges = [corner, corner + 1, below, below + 1].map(at => rangeOf(z, at, columns));
    return bucketOf(ROUNDING + Math.max(...ranges));
  }

  /** @private @param {number} column @param {number} row */
  isBlock_(column, row) {
    return column >= 0 && row >= 0 && column < this.across_ && row < this.down_
      && this.areBlocks_[row * this.across_ + column] === 1;
  }

  /** @private @param {number} corner */
  isFlat_(corner) {
    const {corners_: z, columns_: columns} = this;
    const middle = corner + columns + 1, below = middle + columns + 1;
    const a = z[corner], b = z[corner + 2], c = z[below - 2], d = z[below];
    return isNear(z[corner + 1], a, b) && isNear(z[middle - 1], a, c) && isNear(z[middle], b, c)
      && isNear(z[middle + 1], b, d) && isNear(z[below - 1], c, d)
      // Around the middle, triangles divide two of the cells along their other diagonals.
      && isSmooth(z[corner + 1] + z[middle - 1], a + z[middle])
      && isSmooth(z[middle + 1] + z[below - 1], z[middle] + d);
  }
}

/** Whether both diagonals of a cell meet at nearly one depth. Each is the sum of its ends. */
function isSmooth(/** @type {number} */ a, /** @type {number} */ b) {
  return Math.abs(a - b) <= 2 * ROUNDING;
}

/** Whether a depth is nearly the mean of two. */
function isNear(/** @type {number} */ depth, /** @type {number} */ a, /** @type {number} */ b) {
  return Math.abs(2 * depth - a - b) <= 2 * ROUNDING;
}

/**
 * The largest difference of depths in a cell.
 * @param {Uint16Array} corners
 * @param {number} corner   Its upper left one.
 * @param {number} columns
 */
function rangeOf(corners, corner, columns) {
  const a = corners[corner], b = corners[corner + 1];
  const c = corners[corner + columns], d = corners[corner + columns + 1];
  return Math.max(a, b, c, d) - Math.min(a, b, c, d);
}

/** @param {number} range */
function bucketOf(range) {
  return 32 - Math.clz32(range);
}

/**
 * Whether blocks show everything nearly where their cells do.
 * @param {Float32Array} warp  As for calmBuckets().
 * @param {{width: number, height: number}} viewport
 */
export function canShowBlocks(warp, {width, height}) {
  const least = leastW(warp);
  const moved = Math.hypot(width / 2 * warp[8], height / 2 * warp[9])
    + Math.hypot(width, height) / 2 * Math.abs(warp[11]);
  return moved * 2 * ROUNDING / MAX_LEAN <= MOST_MOVED_PX * least;
}

/** The least w of what the picture may show. @param {Float32Array} warp */
function leastW(warp) {
  return warp[15] - Math.abs(warp[3]) - Math.abs(warp[7]) - Math.abs(warp[11]);
}

/**
 * In how many buckets, from that of the smallest range, no cell becomes longer than `most` times.
 *
 * A place p of the picture with depth z moves to q = (A p + a z) / w, where w changes by b along p
 * and by c along z. A cell where z changes by g per pixel becomes at most
 * (|A| + |a| g + |q| (|b| + |c| g)) / w times longer.
 *
 * @param {Float32Array} warp  From the clip space of the picture to the new clip space.
 * @param {{width: number, height: number}} picture   Pixels.
 * @param {{width: number, height: number}} viewport  Pixels.
 * @param {number} most
 */
export function calmBuckets(warp, picture, viewport, most) {
  const halfWidth = viewport.width / 2, halfHeight = viewport.height / 2;
  const perX = 2 / picture.width, perY = 2 / picture.height;
  const stretch = largestStretch(halfWidth * warp[0] * perX, halfWidth * warp[4] * perY,
    halfHeight * warp[1] * perX, halfHeight * warp[5] * perY);
  const shift = Math.hypot(halfWidth * warp[8], halfHeight * warp[9]);
  const far = Math.hypot(halfWidth, halfHeight);  // Largest |q| from the middle.
  const slope = (most * leastW(warp) - stretch - far * Math.hypot(warp[3] * perX, warp[7] * perY))
    / (shift + far * Math.abs(warp[11]));
  // Depths of clip space change by 2 over all MAX_LEAN depths. A triangle with this range has at
  // most this slope along both sides of its cell.
  const range = slope * CELL_PX * MAX_LEAN / (2 * Math.SQRT2);
  return range >= 0 ? Math.min(NARROW, Math.floor(Math.log2(range + 1)) + 1) : 0;
}

/** The larger singular value of a matrix of two rows. */
function largestStretch(/** @type {number} */ a, /** @type {number} */ b,
  /** @type {number} */ c, /** @type {number} */ d) {
  const sum = a * a + b * b + c * c + d * d, area = a * d - b * c;
  return Math.sqrt((sum + Math.sqrt(Math.max(0, sum * sum - 4 * area * area))) / 2);
}
