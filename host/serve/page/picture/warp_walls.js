// The edges of the surfaces in a picture. Behind an edge may be something that the picture does
// not show, and that becomes visible from another viewpoint.
import {CELL_PX, cornerOf, FULL, maskRowBytes, MAX_LEAN} from './lean_depths.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */
/** @typedef {import('./lean_depths.js').Seam} Seam */

export const WALL_COLUMNS = 1024;   // Texels per row of the texture of walls.
const LEAST_STEP = 12;              // Depths of one surface differ less between two pixels.
/**
 * Walls before the background reach so far behind a surface, of the 2 units of depth in clip space:
 * at least, and more if planes of equal depth have moved against each other. With longer walls most
 * of the hatch would hide the background; shorter ones miss the back of a bone that turns.
 */
const OPENED = 0.13, OPENED_BY_MOVE = 0.05;
const LEAST_W = 1e-3;               // Behind the eye, and close before it, nothing is drawn.
const ACROSS = 1, OPEN = 2, BEYOND = 4, LONG = 8, TURNED = 16;  // Bits of a wall.

/**
 * A wall stands on the edge between two pixels, along the line of sight.
 *
 * | between | the wall reaches |
 * |---|---|
 * | two surfaces | from the near one to the far one |
 * | a surface and the background | from the surface to a little behind it |
 * | a surface and what is outside of the picture | outwards, far beyond the picture |
 *
 * If a surface leaves the picture, there are also long walls around the picture, which reach
 * outwards in the middle of the depths.
 *
 * A wall is seen from one side only: there, what was hidden has opened. Seen from the other side,
 * the near surface has moved over it.
 *
 * @param {LeanDepths} lean
 * @param {Uint8Array} covered  Of cells.
 * @param {number} width        Of the picture, pixels.
 * @param {number} height
 * @returns {{texels: Uint32Array, rows: number, count: number}} two numbers per wall: the place of
 *   its upper or left end (13 bits each) with its bits above; depths, the front one low
 */
export function wallsOf(lean, covered, width, height) {
  const {columns, rows} = lean, cellsAcross = columns - 1;
  const surfaces = new Surfaces(lean, width, height);
  const isEdge = edgeCells(lean, covered, surfaces);
  /** @type {number[]} */
  const walls = [];
  let leavesPicture = false;
  // isAfter: the near surface, or the picture, is to the right of the edge, or below it.
  const add = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ bits,
    /** @type {number} */ front, /** @type {number} */ back, /** @type {boolean} */ isAfter) => {
    const isTurned = isAfter !== ((bits & ACROSS) !== 0);
    walls.push((x | y << 13 | (isTurned ? bits | TURNED : bits) << 26) >>> 0,
      (front | back << 16) >>> 0);
  };
  // The edge that begins at (x, y), between a pixel that is inside of the picture and another.
  const meet = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ bits,
    /** @type {number} */ otherX, /** @type {number} */ otherY, /** @type {number} */ pixelX,
    /** @type {number} */ pixelY) => {
    const isOutside = otherX < 0 || otherY < 0 || otherX >= width || otherY >= height;
    if (!isOutside && surfaces.isPlain(pixelX, pixelY) && surfaces.isPlain(otherX, otherY)) {
      return;  // Both cells have the same corners there.
    }
    const atX = bits === ACROSS ? x + 0.5 : x, atY = bits === ACROSS ? y : y + 0.5;
    const depth = surfaces.depthOf(pixelX, pixelY, atX, atY);
    const isPixelAfter = pixelX > otherX || pixelY > otherY;
    if (isOutside) {
      if (depth > 0) {
        add(x, y, bits | BEYOND, depth, depth, isPixelAfter);
        leavesPicture = true;
      }
      return;
    }
    const other = surfaces.depthOf(otherX, otherY, atX, atY);
    if (depth > 0 && other > 0) {
      if (Math.abs(depth - other) >= LEAST_STEP) {
        add(x, y, bits, Math.min(depth, other), Math.max(depth, other),
          isPixelAfter === depth < other);
      }
    } else if (depth > 0 || other > 0) {
      add(x, y, bits | OPEN, Math.max(depth, other), 0, isPixelAfter === depth > 0);
    }
  };
  for (let row = 0, cell = 0; row + 1 < rows; ++row) {
    for (let column = 0; column < cellsAcross; ++column, ++cell) {
      if (!isEdge[cell]) {
        continue;
      }
      // Cells to the right and below see to the common edge themselves.
      const left = column > 0 && isEdge[cell - 1], up = row > 0 && isEdge[cell - cellsAcross];
      const right = Math.min(width, CELL_PX * (column + 1));
      const bottom = Math.min(height, CELL_PX * (row + 1));
      for (let y = CELL_PX * row; y < bottom; ++y) {
        for (let x = CELL_PX * column; x < right; ++x) {
          if (x > CELL_PX * column || !left) {
            meet(x, y, 0, x - 1, y, x, y);
          }
          if (y > CELL_PX * row || !up) {
            meet(x, y, ACROSS, x, y - 1, x, y);
          }
          if (x + 1 === right) {
            meet(x + 1, y, 0, x + 1, y, x, y);
          }
          if (y + 1 === bottom) {
            meet(x, y + 1, ACROSS, x, y + 1, x, y);
          }
        }
      }
    }
  }
  if (leavesPicture) {
    const middle = MAX_LEAN + 1 >> 1;
    for (const [x, y, bits] of [[0, 0, 0], [width, 0, 0], [0, 0, ACROSS], [0, height, ACROSS]]) {
      add(x, y, bits | BEYOND | LONG, middle, middle, x === 0 && y === 0);
    }
  }
  const count = walls.length / 2, textureRows = Math.max(1, Math.ceil(count / WALL_COLUMNS));
  const texels = new Uint32Array(2 * WALL_COLUMNS * textureRows);
  texels.set(walls);
  return {texels, rows: textureRows, count};
}

/** The depths of the surfaces in a picture. */
class Surfaces {
  /**
   * @param {LeanDepths} lean
   * @param {number} width
   * @param {number} height
   */
  constructor(lean, width, height) {
    this.lean_ = lean;
    this.width_ = width;
    this.height_ = height;
    this.rowBytes_ = maskRowBytes(width);
    /** By cell. @type {(Seam | undefined)[]} */
    this.seams = new Array((lean.columns - 1) * (lean.rows - 1));
    for (const seam of lean.seams) {
      this.seams[seam.cell] = seam;
    }
  }

  /**
   * Whether a pixel shows a surface that the corners of its cell describe.
   * @param {number} x
   * @param {number} y
   */
  isPlain(x, y) {
    const {mask, columns} = this.lean_;
    return (mask[y * this.rowBytes_ + (x >> 3)] >> (x & 7) & 1) === 1
      && !this.seams[(y >> 2) * (columns - 1) + (x >> 2)];
  }

  /**
   * The depth at a place of the surface that a pixel shows; 0 if it shows none.
   * @param {number} x
   * @param {number} y
   * @param {number} atX  On the border of the pixel.
   * @param {number} atY
   */
  depthOf(x, y, atX, atY) {
    const {mask, corners, columns} = this.lean_;
    if ((mask[y * this.rowBytes_ + (x >> 3)] >> (x & 7) & 1) === 0) {
      return 0;
    }
    const cell = (y >> 2) * (columns - 1) + (x >> 2), seam = this.seams[cell];
    const left = x & ~3, top = y & ~3;
    const u = (atX - left) / Math.min(CELL_PX, this.width_ - left);
    const v = (atY - top) / Math.min(CELL_PX, this.height_ - top);
    if (seam) {
      const isNear = seam.near_pixels >> ((y & 3) * CELL_PX + (x & 3)) & 1;
      const [a, b, c, d] = isNear ? seam.near : seam.far;
      return between(a, b, c, d, u, v);
    }
    const corner = cornerOf(cell, columns);
    return between(corners[corner], corners[corner + 1], corners[corner + columns],
      corners[corner + columns + 1], u, v);
  }
}

/** @param {number} a @param {number} b @param {number} c @param {number} d
 *  @param {number} u @param {number} v */
function between(a, b, c, d, u, v) {
  const depth = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v;
  return Math.max(1, Math.min(MAX_LEAN, Math.round(depth)));
}

/**
 * Which cells may have walls: 1 or 0 for each.
 * @param {LeanDepths} lean
 * @param {Uint8Array} covered
 * @param {Surfaces} surfaces
 */
function edgeCells({columns, rows}, covered, surfaces) {
  const across = columns - 1, down = rows - 1;
  const isEdge = new Uint8Array(covered.length);
  for (let row = 0, cell = 0; row < down; ++row) {
    for (let column = 0; column < across; ++column, ++cell) {
      const isBorder = row === 0 || column === 0 || row + 1 === down || column + 1 === across;
      isEdge[cell] = covered[cell] && (covered[cell] !== FULL || surfaces.seams[cell] || isBorder
        || !(covered[cell - 1] && covered[cell + 1] && covered[cell - across]
          && covered[cell + across])) ? 1 : 0;
    }
  }
  return isEdge;
}

/** The four corners of a wall, the first two in front: counterclockwise where it is seen. */
const WALL_CORNERS = [0, 1, 2, 3, 2, 1];

/**
 * The corners of the triangles of walls.
 * @param {number} count  Of walls.
 */
export function wallTriangles(count) {
  const corners = new Uint32Array(6 * count);
  for (let wall = 0; wall < count; ++wall) {
    WALL_CORNERS.forEach((corner, k) => { corners[6 * wall + k] = 4 * wall + corner; });
  }
  return corners;
}

/**
 * How far walls before the background reach, in clip space.
 * @param {Float32Array} warp  From the clip space of the picture to the new clip space.
 */
export function openedBy(warp) {
  return OPENED + OPENED_BY_MOVE * Math.hypot(warp[8], warp[9]) / warp[15];
}

/**
 * The triangles of walls in the new clip space, as WALL_VERTEX places them: x, y and w of each
 * corner. What is behind the eye is cut off.
 * @param {ReturnType<typeof wallsOf>} walls
 * @param {{width: number, height: number}} size  Of the picture, pixels.
 * @param {Float32Array} warp                     As for openedBy().
 * @param {Float64Array} [scratch]                Is used if it is large enough.
 * @returns {Float64Array}
 */
export function clippedWalls({texels, count}, size, warp, scratch = new Float64Array(0)) {
  const opened = openedBy(warp), around = new Float64Array(12);
  const most = 27 * count;  // A corner cut off leaves five.
  const triangles = scratch.length < most ? new Float64Array(most) : scratch;
  let end = 0;
  const add = (/** @type {Float64Array} */ from, /** @type {number[]} */ corners) => {
    for (const corner of corners) {
      for (let part = 3 * corner; part < 3 * corner + 3; ++part) {
        triangles[end++] = from[part];
      }
    }
  };
  for (let wall = 0; wall < count; ++wall) {
    for (let corner = 0; corner < 4; ++corner) {
      placeCorner(texels, wall, corner, size, opened, warp, around);
    }
    if (Math.min(around[2], around[5], around[8], around[11]) >= LEAST_W) {
      add(around, WALL_CORNERS);
      continue;
    }
    const seen = inFront([0, 1, 3, 2].map(corner =>
      [...around.subarray(3 * corner, 3 * corner + 3)]));
    for (let at = 2; at < seen.length; ++at) {
      add(Float64Array.from([seen[0], seen[at - 1], seen[at]].flat()), [0, 1, 2]);
    }
  }
  return triangles.subarray(0, end);
}

/**
 * @param {Uint32Array} texels
 * @param {number} wall
 * @param {number} corner
 * @param {{width: number, height: number}} size
 * @param {number} opened
 * @param {Float32Array} m
 * @param {Float64Array} places  Gets x, y, w.
 */
function placeCorner(texels, wall, corner, {width, height}, opened, m, places) {
  const texel = texels[2 * wall], depths = texels[2 * wall + 1], bits = texel >>> 26;
  const isAcross = (bits & ACROSS) !== 0, isBack = corner >= 2;
  const isEnd = ((corner & 1) === 1) !== ((bits & TURNED) !== 0);
  let x = texel & 0x1fff, y = texel >>> 13 & 0x1fff, depth = clipDepth(depths & 0xffff);
  const right = x > 0 ? width : -width, down = y > 0 ? height : -height;
  if (bits & LONG) {
    x += isAcross ? (isEnd ? 2 : -1) * width : 0;
    y += isAcross ? 0 : (isEnd ? 2 : -1) * height;
  } else if (isEnd) {
    x += isAcross ? 1 : 0;
    y += isAcross ? 0 : 1;
  }
  if (isBack && bits & BEYOND) {
    x += isAcross ? 0 : right;
    y += isAcross ? down : 0;
  } else if (isBack) {
    depth = bits & OPEN ? depth + opened : clipDepth(depths >>> 16);
  }
  const across = 2 * x / width - 1, up = 1 - 2 * y / height;
  places[3 * corner] = m[0] * across + m[4] * up + m[8] * depth + m[12];
  places[3 * corner + 1] = m[1] * across + m[5] * up + m[9] * depth + m[13];
  places[3 * corner + 2] = m[3] * across + m[7] * up + m[11] * depth + m[15];
}

/** @param {number} lean */
function clipDepth(lean) {
  return 2 * (lean - 0.5) / MAX_LEAN - 1;
}

/** The part of a polygon before the eye. @param {number[][]} around  x, y, w of each corner. */
function inFront(around) {
  return around.flatMap((corner, at) => {
    const next = around[(at + 1) % around.length];
    const found = corner[2] >= LEAST_W ? [corner] : [];
    if (corner[2] >= LEAST_W !== next[2] >= LEAST_W) {
      const share = (LEAST_W - corner[2]) / (next[2] - corner[2]);
      found.push(corner.map((value, part) => value + share * (next[part] - value)));
    }
    return found;
  });
}

// A wall is drawn at the far plane: only where no surface is. The opened depth is in clip space.
export const WALL_VERTEX = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D walls;
uniform ivec2 size;
uniform mat4 warp;
uniform float opened;
float clip_depth(uint lean) {
  return (float(lean) - 0.5) / ${MAX_LEAN}.0 * 2.0 - 1.0;
}
void main() {
  int wall = gl_VertexID / 4, corner = gl_VertexID % 4;
  uvec2 texel = texelFetch(walls, ivec2(wall % ${WALL_COLUMNS}, wall / ${WALL_COLUMNS}), 0).rg;
  uint bits = texel.r >> 26;
  vec2 at = vec2(texel.r & 0x1fffu, texel.r >> 13 & 0x1fffu), full = vec2(size);
  bool is_across = (bits & ${ACROSS}u) != 0u, is_back = corner >= 2;
  bool is_end = ((corner & 1) == 1) != ((bits & ${TURNED}u) != 0u);
  vec2 outwards = is_across ? vec2(0.0, at.y > 0.0 ? full.y : -full.y)
                            : vec2(at.x > 0.0 ? full.x : -full.x, 0.0);
  if ((bits & ${LONG}u) != 0u) {
    vec2 along = vec2(is_across ? full.x : 0.0, is_across ? 0.0 : full.y);
    at += is_end ? 2.0 * along : -along;
  } else if (is_end) {
    at += is_across ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
  }
  float depth = clip_depth(texel.g & 0xffffu);
  if (is_back && (bits & ${BEYOND}u) != 0u) {
    at += outwards;
  } else if (is_back) {
    depth = (bits & ${OPEN}u) != 0u ? depth + opened : clip_depth(texel.g >> 16);
  }
  vec2 across = at / full;
  vec4 place = warp * vec4(across.x * 2.0 - 1.0, 1.0 - across.y * 2.0, depth, 1.0);
  gl_Position = vec4(place.xy, place.w * 0.999999, place.w);
}`;

/** The color of a hatched pixel, for fragment shaders. */
export const HATCH = `
uniform vec3 background;
vec4 hatch() {
  vec3 ink = dot(background, vec3(0.3, 0.6, 0.1)) < 0.5 ? vec3(0.8) : vec3(0.2);
  bool is_line = mod(gl_FragCoord.x + gl_FragCoord.y, 6.0) < 2.0;
  return vec4(mix(background, ink, is_line ? 0.4 : 0.12), 1.0);
}`;

/** Draws only each second row if `rows` is (0 or 1 from the top, height of the viewport). */
export const ROWS = `
uniform ivec2 rows;
bool is_other_row() {
  return rows.y > 0 && (rows.y - 1 - int(gl_FragCoord.y) & 1) != rows.x;
}`;

export const WALL_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
${ROWS}
${HATCH}
out vec4 color;
void main() {
  if (is_other_row()) {
    discard;
  }
  color = hatch();
}`;
