// Fills triangles by the processor. Programs that compute WebGL take several times as long for
// triangles of a few pixels.
import {CELL_PX, maskRowBytes} from './lean_depths.js';

/** Depths of the planes between which surfaces are drawn. FAR is also where nothing is drawn. */
const NEAR = -1, FAR = 1;
const STEPS = 256;     // Parts of a pixel, for places of corners and shares of neighboring colors.
const RIGHT = 6;       // Where edges at the right begin.
const ON_EDGE = 1e-9;  // A pixel whose middle is on the edge of two triangles belongs to both.
/** The pixels of a surface that is alone in its cell. */
export const ONE_SURFACE = 0xffff;

/**
 * The picture whose colors are drawn.
 * @typedef {object} Source
 * @property {Uint32Array} words  Rows of pixels, as ImageData has them.
 * @property {number} first       Where the picture begins.
 * @property {number} width
 * @property {number} height
 * @property {Uint8Array} mask    The pixels that show a surface: a field of LeanDepths.
 */

/**
 * Vertices on the canvas.
 * @typedef {object} Vertices
 * @property {Float64Array} places   x to the right, y down in pixels, depth. NaN: behind the eye.
 * @property {Float32Array} sources  x, y in the picture, pixels.
 * @property {Uint32Array} seams     Pixels of the surface or ONE_SURFACE, and the place of the cell
 *                                   in cells: 16 bits across, 16 bits down.
 */

/** @param {number} value  In pixels. @returns {number} the nearest place that a corner may have */
export function snapped(value) {
  return Math.round(value * STEPS) / STEPS;
}

/** @param {number} a @param {number} b @param {number} share  Of b, in STEPS. */
function mixed(a, b, share) {
  const rest = STEPS - share;
  const redBlue = (a & 0xff00ff) * rest + (b & 0xff00ff) * share + 0x800080 >>> 8 & 0xff00ff;
  return redBlue | (a >>> 8 & 0xff) * rest + (b >>> 8 & 0xff) * share + 0x80 & 0xff00
    | 0xff000000;
}

/**
 * The color between the four nearest pixels.
 * @param {Source} source
 * @param {number} u  Place in the picture, pixels.
 * @param {number} v
 */
function colorAt({words, first, width, height}, u, v) {
  const x = inside((u - 0.5) * STEPS + 0.5 | 0, (width - 1) * STEPS);  // Rounded.
  const y = inside((v - 0.5) * STEPS + 0.5 | 0, (height - 1) * STEPS);
  const at = first + (y >> 8) * width + (x >> 8), right = x & STEPS - 1, down = y & STEPS - 1;
  const above = right ? mixed(words[at], words[at + 1], right) : words[at];
  if (!down) {
    return above;
  }
  const below = at + width;
  return mixed(above, right ? mixed(words[below], words[below + 1], right) : words[below], down);
}

/** @param {number} value @param {number} most */
function inside(value, most) {
  return value < 0 ? 0 : value > most ? most : value;
}

/** Colors and depths of a canvas. */
export class Raster {
  /**
   * @param {number} width   Pixels.
   * @param {number} height
   */
  constructor(width, height) {
    this.width = width;
    this.height = height;
    /** As ImageData has them. 0: transparent. */
    this.colors = new Uint32Array(width * height);
    this.depths = new Float32Array(width * height);
    /** Only pixels from left and top to before right and bottom are drawn. */
    this.clip = {left: 0, top: 0, right: width, bottom: height};
    /** Only rows with this lowest bit are drawn; null: all rows. @type {number | null} */
    this.parity = null;
    /** A triangle that becomes longer than so many times is torn. */
    this.stretch = Infinity;
    /** Surfaces come nearer by their slope over so many pixels. */
    this.offset_px = 0;
    /** Colors are 1 + the number of the picture's pixel. */
    this.locates = false;
    /** Colors of hatched pixels: between the lines, and on them. */
    this.hatch = new Uint32Array(2);
    // The present triangle: its rows, its edges to the left and to the right, and how depth and
    // place in the picture change to the right and down.
    /** @private */ this.top_ = 0;
    /** @private */ this.bottom_ = 0;
    /** @private x, y, change of x per row; twice to the left, twice to the right. */
    this.edges_ = new Float64Array(2 * RIGHT);
    /** @private Where the next edge of each side goes. */
    this.left_ = 0;
    /** @private */ this.right_ = RIGHT;
    /** @private */ this.x_ = 0;
    /** @private */ this.y_ = 0;
    /** @private */ this.z_ = 0;
    /** @private How much nearer the triangle is drawn than it is. */
    this.nearer_ = 0;
    /** @private */ this.zx_ = 0;
    /** @private */ this.zy_ = 0;
    /** @private */ this.u_ = 0;
    /** @private */ this.ux_ = 0;
    /** @private */ this.uy_ = 0;
    /** @private */ this.v_ = 0;
    /** @private */ this.vx_ = 0;
    /** @private */ this.vy_ = 0;
  }

  /** @param {number} color */
  clear(color) {
    this.colors.fill(color);
    this.depths.fill(FAR);
  }

  /**
   * Draws triangles that show one surface in all pixels and do not tear.
   * @param {Source} source
   * @param {Vertices} vertices
   * @param {Uint32Array} triangles  Three vertices each, counterclockwise as seen.
   * @param {Uint32Array} [colors]   Where colors go.
   */
  plain(source, vertices, triangles, colors = this.colors) {
    const {depths, edges_: edges} = this;
    for (let at = 0; at < triangles.length; at += 3) {
      if (!this.begin_(vertices, triangles[at], triangles[at + 1], triangles[at + 2])) {
        continue;
      }
      const {zx_: zx, ux_: ux, vx_: vx} = this;
      const near = NEAR - this.nearer_, far = FAR - this.nearer_;
      for (let row = this.top_; row <= this.bottom_; ++row) {
        if (this.parity !== null && (row & 1) !== this.parity) {
          continue;
        }
        const y = row + 0.5, first = this.firstOf_(edges, y), last = this.lastOf_(edges, y);
        const right = first + 0.5 - this.x_, down = y - this.y_;
        let z = this.z_ + zx * right + this.zy_ * down;
        let u = this.u_ + ux * right + this.uy_ * down;
        let v = this.v_ + vx * right + this.vy_ * down;
        for (let i = row * this.width + first, end = i + last - first; i <= end; ++i) {
          if (z < depths[i] && z >= near && z < far) {
            depths[i] = z;
            colors[i] = colorAt(source, u, v);
          }
          z += zx;
          u += ux;
          v += vx;
        }
      }
    }
  }

  /**
   * Draws what triangles show of their surfaces: pixels that the mask has, unless they are torn; or
   * hatches the torn ones where nothing is drawn.
   * @param {Source} source
   * @param {Vertices} vertices
   * @param {Uint32Array} triangles
   * @param {Uint32Array | null} colors  Where colors go; null: hatches.
   */
  masked(source, vertices, triangles, colors) {
    const {edges_: edges} = this;
    for (let at = 0; at < triangles.length; at += 3) {
      const corner = triangles[at];
      if (!this.begin_(vertices, corner, triangles[at + 1], triangles[at + 2])
          || this.isTorn_() === (colors !== null)) {
        continue;
      }
      const pixels = vertices.seams[2 * corner], cell = vertices.seams[2 * corner + 1];
      for (let row = this.top_; row <= this.bottom_; ++row) {
        if (this.parity === null || (row & 1) === this.parity) {
          const y = row + 0.5;
          this.maskedRow_(source, row, this.firstOf_(edges, y), this.lastOf_(edges, y), pixels,
            cell, colors);
        }
      }
    }
  }

  /**
   * Hatches triangles where nothing is drawn.
   * @param {Float64Array} places  Three numbers per corner, as in Vertices.
   */
  hatched(places) {
    const {edges_: edges, depths, colors} = this;
    for (let corner = 0; corner < places.length / 3; corner += 3) {
      if (!this.edgesOf_(places, corner, corner + 1, corner + 2)) {
        continue;
      }
      for (let row = this.top_; row <= this.bottom_; ++row) {
        if (this.parity !== null && (row & 1) !== this.parity) {
          continue;
        }
        const first = this.firstOf_(edges, row + 0.5), last = this.lastOf_(edges, row + 0.5);
        for (let x = first, i = row * this.width + first; x <= last; ++x, ++i) {
          if (depths[i] === FAR) {
            colors[i] = this.hatchAt_(x, row);
          }
        }
      }
    }
  }

  /** @private @param {number} x @param {number} row */
  hatchAt_(x, row) {
    return this.hatch[(x + this.height - row) % 6 < 2 ? 1 : 0];
  }

  /**
   * @private
   * @param {Source} source
   * @param {number} row
   * @param {number} first
   * @param {number} last
   * @param {number} pixels
   * @param {number} cell
   * @param {Uint32Array | null} colors
   */
  maskedRow_(source, row, first, last, pixels, cell, colors) {
    const {depths} = this, {width, height, mask} = source, rowBytes = maskRowBytes(width);
    const down = row + 0.5 - this.y_, near = NEAR - this.nearer_, far = FAR - this.nearer_;
    const left = CELL_PX * (cell & 0xffff), top = CELL_PX * (cell >>> 16);
    for (let x = first; x <= last; ++x) {
      const right = x + 0.5 - this.x_, i = row * this.width + x;
      const z = this.z_ + this.zx_ * right + this.zy_ * down;
      if (colors ? !(z < depths[i] && z >= near && z < far) : depths[i] !== FAR) {
        continue;
      }
      const u = this.u_ + this.ux_ * right + this.uy_ * down;
      const v = this.v_ + this.vx_ * right + this.vy_ * down;
      let px = inside(Math.floor(u), width - 1), py = inside(Math.floor(v), height - 1);
      if (pixels !== ONE_SURFACE) {
        px = left + inside(px - left, CELL_PX - 1);
        py = top + inside(py - top, CELL_PX - 1);
        if ((pixels >> (py - top) * CELL_PX + px - left & 1) === 0) {
          continue;
        }
      }
      if ((mask[py * rowBytes + (px >> 3)] >> (px & 7) & 1) === 0) {
        continue;
      }
      if (!colors) {
        this.colors[i] = this.hatchAt_(x, row);
        continue;
      }
      depths[i] = z;
      const at = py * width + px;  // In a seam, another surface may be beside the pixel.
      colors[i] = this.locates ? at + 1
        : pixels === ONE_SURFACE ? colorAt(source, u, v) : source.words[source.first + at];
    }
  }

  /**
   * Whether the triangle became too long: the least singular value of the change of place in the
   * picture per pixel of the canvas is the inverse of the longest stretch.
   * @private
   */
  isTorn_() {
    const {ux_: a, vx_: b, uy_: c, vy_: d} = this;
    const sum = a * a + b * b + c * c + d * d, area = a * d - b * c;
    const least = (sum - Math.sqrt(Math.max(0, sum * sum - 4 * area * area))) / 2;
    return least * this.stretch ** 2 < 1;
  }

  /**
   * Begins a triangle. Returns whether it has pixels.
   * @private
   * @param {Vertices} vertices
   * @param {number} a
   * @param {number} b
   * @param {number} c
   */
  begin_({places, sources}, a, b, c) {
    if (!this.edgesOf_(places, a, b, c)) {
      return false;
    }
    const x = this.x_ = places[3 * a], y = this.y_ = places[3 * a + 1];
    const bx = places[3 * b] - x, by = places[3 * b + 1] - y;
    const cx = places[3 * c] - x, cy = places[3 * c + 1] - y, area = bx * cy - cx * by;
    const z = places[3 * a + 2], bz = places[3 * b + 2] - z, cz = places[3 * c + 2] - z;
    const u = this.u_ = sources[2 * a], bu = sources[2 * b] - u, cu = sources[2 * c] - u;
    const v = this.v_ = sources[2 * a + 1], bv = sources[2 * b + 1] - v;
    const cv = sources[2 * c + 1] - v;
    this.zx_ = (bz * cy - cz * by) / area;
    this.zy_ = (cz * bx - bz * cx) / area;
    this.ux_ = (bu * cy - cu * by) / area;
    this.uy_ = (cu * bx - bu * cx) / area;
    this.vx_ = (bv * cy - cv * by) / area;
    this.vy_ = (cv * bx - bv * cx) / area;
    this.nearer_ = this.offset_px * Math.max(Math.abs(this.zx_), Math.abs(this.zy_));
    this.z_ = z - this.nearer_;
    return true;
  }

  /**
   * Finds rows and edges of a triangle. Returns whether it may have pixels, and is seen from its
   * front.
   * @private
   * @param {Float64Array} places
   * @param {number} a
   * @param {number} b
   * @param {number} c
   */
  edgesOf_(places, a, b, c) {
    const ax = places[3 * a], ay = places[3 * a + 1], bx = places[3 * b], by = places[3 * b + 1];
    const cx = places[3 * c], cy = places[3 * c + 1], {clip} = this;
    if (!((bx - ax) * (cy - ay) - (cx - ax) * (by - ay) < 0)) {
      return false;  // From behind, without area, or behind the eye.
    }
    this.top_ = Math.max(clip.top, Math.ceil(Math.min(ay, by, cy) - 0.5));
    this.bottom_ = Math.min(clip.bottom - 1, Math.floor(Math.max(ay, by, cy) - 0.5));
    if (this.top_ > this.bottom_ || Math.max(ax, bx, cx) < clip.left + 0.5
        || Math.min(ax, bx, cx) > clip.right - 0.5) {
      return false;
    }
    this.left_ = 0;
    this.right_ = RIGHT;
    this.addEdge_(ax, ay, cx, cy);
    this.addEdge_(cx, cy, bx, by);
    this.addEdge_(bx, by, ax, ay);
    return true;
  }

  /**
   * Adds an edge of the present triangle, clockwise as seen: those at the left lead upwards.
   * @private
   * @param {number} px
   * @param {number} py
   * @param {number} qx
   * @param {number} qy
   */
  addEdge_(px, py, qx, qy) {
    if (py === qy) {
      return;  // The rows end there anyway.
    }
    const {edges_: edges} = this, slope = (qx - px) / (qy - py);
    const side = qy < py ? 0 : RIGHT, at = qy < py ? this.left_ : this.right_;
    edges[at] = px;
    edges[at + 1] = py;
    edges[at + 2] = slope;
    if (at === side) {  // Perhaps the only one of its side.
      edges[at + 3] = px;
      edges[at + 4] = py;
      edges[at + 5] = slope;
    }
    if (qy < py) {
      this.left_ = at + 3;
    } else {
      this.right_ = at + 3;
    }
  }

  /** The first pixel of a row. @private @param {Float64Array} edges @param {number} y */
  firstOf_(edges, y) {
    const x = Math.max(edges[0] + edges[2] * (y - edges[1]), edges[3] + edges[5] * (y - edges[4]));
    return Math.max(this.clip.left, Math.ceil(x - 0.5 - ON_EDGE));
  }

  /** @private @param {Float64Array} edges @param {number} y */
  lastOf_(edges, y) {
    const x = Math.min(edges[6] + edges[8] * (y - edges[7]),
      edges[9] + edges[11] * (y - edges[10]));
    return Math.min(this.clip.right - 1, Math.floor(x - 0.5 + ON_EDGE));
  }
}
