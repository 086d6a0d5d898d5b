// Draws pictures from other viewpoints as WarpPainter does, but without WebGL.
import {say} from '../texts/say.js';
import {sizeOf, toAnaglyph} from './compose.js';
import {CELL_PX, coveredCells, MAX_LEAN} from './lean_depths.js';
import {ONE_SURFACE, Raster, snapped} from './raster.js';
import {calmBuckets, canShowBlocks, meshOf, seamTexels} from './warp_mesh.js';
import {MOST_STRETCH} from './warp_program.js';
import {clippedWalls, wallsOf} from './warp_walls.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */
/** @typedef {import('./warp_mesh.js').Mesh} Mesh */
/** @typedef {import('./warp_painter.js').Viewport} Viewport */

const MOST_PX = 8192;  // Width and height of a bitmap: memory for its pixels.
const PROBE = 0x6496c8, PROBE_OFF = 2;  // A color, and by how much its parts may be read wrongly.

/**
 * What is known of a picture.
 * @typedef {object} PictureMesh
 * @property {import('./raster.js').Source} source
 * @property {Float64Array} corners  x, y, z of each vertex in the clip space of the picture.
 * @property {import('./raster.js').Vertices} vertices
 * @property {(Mesh | null)[]} meshes  Without blocks, and with blocks, when they are needed.
 * @property {(hasBlocks: boolean) => Mesh} meshOf
 * @property {ReturnType<typeof wallsOf>} walls
 */

/** Draws pictures of one size, which lie in one bitmap from top to bottom. */
export class SoftwarePainter {
  /**
   * @param {HTMLCanvasElement} canvas  One without a context of WebGL.
   * @throws {Error} if the browser hides the colors of canvases
   */
  constructor(canvas) {
    /** @private */
    this.canvas_ = canvas;
    /** @private */
    this.context_ = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d',
      {alpha: false, willReadFrequently: true}));
    /** Most width and height of a bitmap for take(). */
    this.most_px = MOST_PX;
    /** @private Reads the pixels of bitmaps. */
    this.reader_ = /** @type {OffscreenCanvasRenderingContext2D} */ (new OffscreenCanvas(1, 1)
      .getContext('2d', {willReadFrequently: true}));
    if (!readsColors(this.reader_)) {
      throw new Error(say`the browser does not let the page read pictures, as it protects against
        fingerprinting`);
    }
    /** @private @type {PictureMesh[]} From top to bottom. */
    this.meshes_ = [];
    /** @private Size of one picture, pixels. */
    this.size_ = {width: 0, height: 0};
    /** @private */
    this.raster_ = new Raster(1, 1);
    /** @private What a layer shows, until it is blended. */
    this.layer_ = new Uint32Array(0);
    /** @private Corners of walls on the canvas. @type {Float64Array} */
    this.walls_ = new Float64Array(0);
    /** @private Whether the raster has two pictures for one anaglyph. */
    this.isPair_ = false;
    /** @private */
    this.background_ = 0;
  }

  /**
   * Takes pictures with their depths.
   * @param {import('./compose.js').Bitmap} bitmap
   * @param {LeanDepths[]} leans  Of each picture, from top to bottom.
   */
  take(bitmap, leans) {
    const {width, height: all} = sizeOf(bitmap), height = all / leans.length;
    const {canvas} = this.reader_;
    if (canvas.width !== width || canvas.height !== all) {
      canvas.width = width;
      canvas.height = all;
    }
    this.reader_.drawImage(bitmap, 0, 0);
    const words = new Uint32Array(this.reader_.getImageData(0, 0, width, all).data.buffer);
    this.size_ = {width, height};
    this.meshes_ = leans.map((lean, picture) => pictureOf(lean,
      {words, first: picture * width * height, width, height, mask: lean.mask}));
  }

  /**
   * Clears the canvas, which gets this size. end() shows what is drawn.
   * @param {number} width       Pixels.
   * @param {number} height
   * @param {string} background  #rrggbb, where no surface is.
   */
  begin(width, height, background) {
    if (this.raster_.width !== width || this.raster_.height !== height) {
      this.raster_ = new Raster(width, height);
    }
    this.isPair_ = false;
    const [red, green, blue] = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16));
    this.background_ = wordOf(red, green, blue);
    this.raster_.clear(this.background_);
    const ink = 0.3 * red + 0.6 * green + 0.1 * blue < 127.5 ? 204 : 51;
    this.raster_.hatch.set([0.12, 0.4].map(share => wordOf(...[red, green, blue].map(part =>
      Math.round(part + share * (ink - part))))));
  }

  /**
   * The same for two eyes, whose pictures are combined to an anaglyph: draw() the left one into the
   * viewport that begins at 0, the right one at `width`.
   * @param {number} width
   * @param {number} height
   * @param {string} background
   */
  beginAnaglyph(width, height, background) {
    this.begin(2 * width, height, background);
    this.isPair_ = true;
  }

  /** Shows what is drawn. */
  end() {
    const {canvas_: canvas, raster_: {width: all, height, colors}} = this;
    const width = this.isPair_ ? all / 2 : all;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    let shown = new ImageData(new Uint8ClampedArray(colors.buffer), all);
    if (this.isPair_) {
      const [left, right] = [0, width].map(from => new ImageData(width, height));
      for (const [eye, {data}] of [left, right].entries()) {
        const words = new Uint32Array(data.buffer);
        for (let row = 0; row < height; ++row) {
          const first = row * all + eye * width;
          words.set(colors.subarray(first, first + width), row * width);
        }
      }
      toAnaglyph(left.data, right.data);
      shown = left;
    }
    this.context_.putImageData(shown, 0, 0);
  }

  /**
   * Draws a picture into a viewport, by depth.
   * @param {number} picture         From the top, from 0.
   * @param {number[]} warp          From the clip space of the picture to the new clip space.
   * @param {number} magnification   New zoom over the zoom of the picture, if the viewport is as
   *                                 large as the picture.
   * @param {number} opacity         0 to 1. Below 1, what is drawn already shows through.
   * @param {Viewport} viewport      From the lower left corner.
   */
  draw(picture, warp, magnification, opacity, viewport) {
    const {raster_: raster} = this;
    if (opacity < 1 && this.layer_.length !== raster.colors.length) {
      this.layer_ = new Uint32Array(raster.colors.length);
    }
    const colors = opacity < 1 ? this.layer_ : raster.colors;
    const target = {raster, left: viewport.left, top: raster.height - viewport.height
      - (viewport.bottom ?? 0), width: viewport.width, height: viewport.height};
    raster.parity = viewport.rows ?? null;
    raster.offset_px = opacity < 1 ? CELL_PX : 0;
    const {mesh, plain, calm, matrix} = this.prepare_(picture, warp, magnification, target);
    const {source, vertices} = this.meshes_[picture], {triangles, partialEnds} = mesh;
    raster.plain(source, vertices, triangles.subarray(0, plain), colors);
    raster.masked(source, vertices, triangles.subarray(plain), colors);
    if (opacity < 1) {
      blend(this.layer_, opacity, raster.colors);
    }
    this.hatch_(picture, triangles.subarray(plain, partialEnds[calm]), matrix, target);
  }

  /**
   * Hatches what the picture has not seen: cells that became too long, and what its edges hid.
   * @private
   * @param {number} picture
   * @param {Uint32Array} torn  Corners of the triangles that may have torn.
   * @param {Float32Array} matrix
   * @param {Target} target
   */
  hatch_(picture, torn, matrix, target) {
    const {source, vertices, walls} = this.meshes_[picture];
    target.raster.masked(source, vertices, torn, null);
    const places = clippedWalls(walls, this.size_, matrix, this.walls_);
    this.walls_ = new Float64Array(places.buffer);
    for (let at = 0; at < places.length; at += 3) {
      place(places[at], places[at + 1], 0, places[at + 2], target, places, at);
    }
    target.raster.hatched(places);
  }

  /**
   * The pixel of a picture that draw() with these arguments shows at a pixel of the canvas.
   * @param {{x: number, y: number}} at  From the upper left corner of the viewport.
   * @param {{width: number, height: number}} viewport  Its size in pixels.
   * @param {number} picture
   * @param {number[]} warp
   * @param {number} magnification
   * @returns {{x: number, y: number} | null} null if it shows the background
   */
  pixelAt({x, y}, {width, height}, picture, warp, magnification) {
    const raster = new Raster(1, 1);
    raster.clear(0);
    raster.locates = true;
    const {mesh} = this.prepare_(picture, warp, magnification,
      {raster, left: -x, top: -y, width, height});
    const {source, vertices} = this.meshes_[picture];
    raster.masked(source, vertices, mesh.triangles, raster.colors);
    const found = raster.colors[0] - 1;
    return found < 0 ? null : {x: found % source.width, y: Math.floor(found / source.width)};
  }

  /**
   * Places the vertices of a picture on a raster.
   * @private
   * @param {number} picture
   * @param {number[]} warp
   * @param {number} magnification
   * @param {Target} target
   */
  prepare_(picture, warp, magnification, target) {
    const {raster, left, top, width, height} = target, matrix = new Float32Array(warp);
    const chosen = this.meshes_[picture], hasBlocks = canShowBlocks(matrix, target);
    const mesh = chosen.meshes[Number(hasBlocks)] ??= chosen.meshOf(hasBlocks);
    raster.clip = {left: Math.max(0, left), top: Math.max(0, top),
      right: Math.min(raster.width, left + width), bottom: Math.min(raster.height, top + height)};
    const scale = magnification * width / this.size_.width;
    raster.stretch = scale * MOST_STRETCH;
    placeAll(chosen.corners, matrix, target, chosen.vertices.places);
    const calm = calmBuckets(matrix, this.size_, target, raster.stretch);
    return {mesh, matrix, calm, plain: calm > 0 ? mesh.fullEnds[calm - 1] : 0};
  }
}

/**
 * Where a picture is drawn: from the upper left corner, pixels.
 * @typedef {object} Target
 * @property {Raster} raster
 * @property {number} left
 * @property {number} top
 * @property {number} width
 * @property {number} height
 */

/**
 * Whether colors can be read back: some browsers change them, so that pages recognize no computer.
 * @param {OffscreenCanvasRenderingContext2D} context
 */
function readsColors(context) {
  context.fillStyle = `#${PROBE.toString(16)}`;
  context.fillRect(0, 0, 1, 1);
  const {data} = context.getImageData(0, 0, 1, 1);
  return [16, 8, 0].every((bits, part) =>
    Math.abs(data[part] - (PROBE >> bits & 0xff)) <= PROBE_OFF);
}

/** A pixel as ImageData has it. */
function wordOf(/** @type {number[]} */ ...[red, green, blue]) {
  return (red | green << 8 | blue << 16 | 0xff000000) >>> 0;
}

/**
 * @param {LeanDepths} lean
 * @param {import('./raster.js').Source} source
 * @returns {PictureMesh}
 */
function pictureOf(lean, source) {
  const {columns, rows, corners: depths} = lean, {width, height} = source;
  const {texels} = seamTexels(lean), own = columns * rows, others = lean.seams.reduce(
    (sum, {near_pixels}) => sum + (near_pixels === 0 ? 4 : 8), 0);
  const corners = new Float64Array(3 * (own + others)), count = own + others;
  const vertices = {places: new Float64Array(3 * count), sources: new Float32Array(2 * count),
    seams: new Uint32Array(2 * count)};
  const add = (/** @type {number} */ at, /** @type {number} */ column, /** @type {number} */ row,
    /** @type {number} */ depth) => {
    const x = Math.min(CELL_PX * column, width), y = Math.min(CELL_PX * row, height);
    vertices.sources[2 * at] = x;
    vertices.sources[2 * at + 1] = y;
    corners[3 * at] = 2 * x / width - 1;
    corners[3 * at + 1] = 1 - 2 * y / height;
    corners[3 * at + 2] = 2 * (depth - 0.5) / MAX_LEAN - 1;
  };
  for (let at = 0; at < own; ++at) {
    add(at, at % columns, Math.floor(at / columns), depths[at]);
    vertices.seams[2 * at] = ONE_SURFACE;
  }
  for (let other = 0; other < others; ++other) {
    const at = own + other, depth = texels[2 * other] & 0xffff, cell = texels[2 * other + 1];
    add(at, (cell & 0xffff) + (other & 1), (cell >>> 16) + (other >> 1 & 1), depth);
    vertices.seams[2 * at] = texels[2 * other] >>> 16;
    vertices.seams[2 * at + 1] = cell;
  }
  const covered = coveredCells(lean, width, height);
  return {source, corners, vertices, meshes: [null, null],
    meshOf: hasBlocks => meshOf(lean, covered, width, height, hasBlocks),
    walls: wallsOf(lean, covered, width, height)};
}

/**
 * Places a point of the new clip space on the canvas: x, y in pixels, depth. NaN behind the eye.
 * @param {number} x
 * @param {number} y
 * @param {number} z
 * @param {number} w
 * @param {Target} target
 * @param {Float64Array} places
 * @param {number} at  Where in places.
 */
function place(x, y, z, w, {left, top, width, height}, places, at) {
  const per = w > 0 ? 1 / w : NaN;
  places[at] = snapped(left + (1 + x * per) / 2 * width);
  places[at + 1] = snapped(top + (1 - y * per) / 2 * height);
  places[at + 2] = z * per;
}

/**
 * Places points of the picture's clip space.
 * @param {Float64Array} corners
 * @param {Float32Array} m  To the new clip space.
 * @param {Target} target
 * @param {Float64Array} places
 */
function placeAll(corners, m, target, places) {
  for (let at = 0; at < corners.length; at += 3) {
    const x = corners[at], y = corners[at + 1], z = corners[at + 2];
    place(m[0] * x + m[4] * y + m[8] * z + m[12], m[1] * x + m[5] * y + m[9] * z + m[13],
      m[2] * x + m[6] * y + m[10] * z + m[14], m[3] * x + m[7] * y + m[11] * z + m[15], target,
      places, at);
  }
}

/**
 * Blends a layer over what is drawn, and clears it.
 * @param {Uint32Array} layer
 * @param {number} opacity
 * @param {Uint32Array} colors
 */
function blend(layer, opacity, colors) {
  const over = new Uint8Array(layer.buffer), under = new Uint8Array(colors.buffer);
  for (let at = 0; at < layer.length; ++at) {
    if (layer[at] === 0) {
      continue;
    }
    for (let byte = 4 * at; byte < 4 * at + 3; ++byte) {
      under[byte] = Math.round(under[byte] + opacity * (over[byte] - under[byte]));
    }
    layer[at] = 0;
  }
}
