// Draws a picture from another viewpoint with WebGL 2, by the depths at the corners of cells.
import {say} from '../texts/say.js';
import {Anaglyph} from './anaglyph.js';
import {sizeOf} from './compose.js';
import {CELL_PX, coveredCells, maskRowBytes} from './lean_depths.js';
import {calmBuckets, canShowBlocks, meshOf, SEAM_COLUMNS, seamTexels} from './warp_mesh.js';
import {FRAGMENT, MOST_STRETCH, PLAIN_FRAGMENT, programOf, VERTEX} from './warp_program.js';
import {openedBy, WALL_COLUMNS, WALL_FRAGMENT, WALL_VERTEX, wallsOf, wallTriangles} from
  './warp_walls.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */
/** @typedef {import('./warp_mesh.js').Mesh} Mesh */

const CORNERS = 0, MASK = 1, COLORS = 2, SEAMS = 3, WALLS = 4;  // Texture units.
/**
 * Buffers and textures of a picture.
 * @typedef {object} PictureMesh
 * @property {WebGLTexture | null} corners
 * @property {WebGLTexture | null} mask
 * @property {WebGLTexture | null} seams
 * @property {WebGLTexture | null} walls
 * @property {Triangles[]} triangles       Without blocks, and with blocks.
 * @property {(hasBlocks: boolean) => Mesh} meshOf
 * @property {number} wallCount
 */

/**
 * @typedef {object} Triangles
 * @property {WebGLBuffer | null} buffer
 * @property {Mesh | null} mesh            What the buffer has; null: nothing of this picture.
 */

/**
 * Where a picture is drawn on the canvas, pixels.
 * @typedef {object} Viewport
 * @property {number} left
 * @property {number} [bottom]  0 without it.
 * @property {number} width
 * @property {number} height
 * @property {number} [rows]  0 or 1: draws only the rows 0, 2 ... or 1, 3 ... from the top.
 */

/** Draws pictures of one size, which lie in one bitmap from top to bottom. */
export class WarpPainter {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{xrCompatible?: boolean}} [options]  xrCompatible: a headset may show what is drawn.
   * @throws {Error} if the browser has no WebGL 2
   */
  constructor(canvas, {xrCompatible = false} = {}) {
    const gl = /** @type {WebGL2RenderingContext | null} */ (canvas.getContext('webgl2',
      {alpha: false, antialias: false, stencil: false, xrCompatible}));
    if (!gl) {
      throw new Error(say`the browser has no WebGL 2`);
    }
    /** @private */ this.canvas_ = canvas;
    /** The context that everything is drawn with. */
    this.gl = gl;
    /** Most width and height of a bitmap for take(). */
    this.most_px = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    /** @private */
    this.surfaces_ = programOf(gl, VERTEX, FRAGMENT);
    /** @private */
    this.plain_ = programOf(gl, VERTEX, PLAIN_FRAGMENT);
    /** @private */
    this.walls_ = programOf(gl, WALL_VERTEX, WALL_FRAGMENT);
    /** @private */
    this.colors_ = this.texture_(gl.LINEAR);
    /** @private @type {PictureMesh[]} From top to bottom. */
    this.meshes_ = [];
    /** @private Size of one picture, pixels. */
    this.size_ = {width: 0, height: 0};
    /** @private Red, green, blue: 0 to 1. */
    this.background_ = [0, 0, 0];
    /** @private Of walls. */
    this.wallTriangles_ = {buffer: gl.createBuffer(), count: 0};
    /** @private Made when it is first used. @type {Anaglyph | null} */
    this.anaglyph_ = null;
    /** @private Whether what is drawn becomes an anaglyph. */
    this.combines_ = false;
    /** @private A pixel with depth, made when it is first used. @type {WebGLFramebuffer | null} */
    this.pixel_ = null;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
  }

  /**
   * Takes pictures with their depths.
   * @param {import('./compose.js').Bitmap} bitmap
   * @param {LeanDepths[]} leans  Of each picture, from top to bottom.
   */
  take(bitmap, leans) {
    const {gl} = this;
    const {width, height: all} = sizeOf(bitmap), height = all / leans.length;
    this.size_ = {width, height};
    while (this.meshes_.length < leans.length) {
      const [corners, mask, seams, walls] = [0, 1, 2, 3].map(() => this.texture_(gl.NEAREST));
      const triangles = [0, 1].map(() => ({buffer: gl.createBuffer(), mesh: null}));
      const meshOf = () => { throw new ReferenceError('no picture has been taken'); };
      this.meshes_.push({corners, mask, seams, walls, triangles, meshOf, wallCount: 0});
    }
    leans.forEach((lean, at) => this.fill_(this.meshes_[at], lean));
    this.bind_(COLORS, this.colors_);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
  }

  /**
   * Clears the canvas, which gets this size. Drawing ends with end().
   * @param {number} width       Pixels.
   * @param {number} height
   * @param {string} background  #rrggbb, where no surface is.
   */
  begin(width, height, background) {
    const {gl, canvas_: canvas} = this;
    this.combines_ = false;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    gl.viewport(0, 0, width, height);
    this.clear(background);
  }

  /**
   * Clears the bound framebuffer.
   * @param {string} background  #rrggbb
   */
  clear(background) {
    const {gl} = this;
    this.background_ = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16) / 255);
    const [red, green, blue] = this.background_;
    gl.clearColor(red, green, blue, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /**
   * The same as begin() for two eyes, whose pictures are combined to an anaglyph: draw() the left
   * one into the viewport that begins at 0, the right one at `width`.
   * @param {number} width
   * @param {number} height
   * @param {string} background
   */
  beginAnaglyph(width, height, background) {
    const {gl} = this;
    this.begin(width, height, background);
    this.anaglyph_ ??= new Anaglyph(gl, (vertex, fragment) =>
      programOf(gl, vertex, fragment).program);
    this.anaglyph_.begin(width, height);
    this.combines_ = true;
    this.clear(background);
  }

  /** Ends what begin() or beginAnaglyph() began. */
  end() {
    if (this.combines_) {
      this.anaglyph_?.end();
    }
  }

  /**
   * Draws a picture into a viewport of the bound framebuffer, by depth.
   * @param {number} picture         From the top, from 0.
   * @param {number[]} warp          From the clip space of the picture to the new clip space.
   * @param {number} magnification   New zoom over the zoom of the picture, if the viewport is as
   *                                 large as the picture.
   * @param {number} opacity         0 to 1. Below 1, what is drawn already shows through.
   * @param {Viewport} viewport      From the lower left corner.
   */
  draw(picture, warp, magnification, opacity, viewport) {
    const {gl} = this, {left, bottom = 0, width, height} = viewport;
    gl.viewport(left, bottom, width, height);
    const rows = viewport.rows === undefined ? [0, 0] : [viewport.rows, height];
    const matrix = new Float32Array(warp), scale = magnification * width / this.size_.width;
    const {triangles, fullEnds, partialEnds} = this.meshFor_(picture, matrix, viewport);
    const calm = rows[1] > 0 ? 0 : calmBuckets(matrix, this.size_, viewport, scale * MOST_STRETCH);
    const plain = calm > 0 ? fullEnds[calm - 1] : 0;
    const plainPlaces = this.prepare_(this.plain_, picture, matrix);
    gl.uniform1f(plainPlaces.opacity, opacity);
    const {program, places} = this.surfaces_;
    this.prepare_(this.surfaces_, picture, matrix);
    gl.uniform1f(places.magnification, scale);
    gl.uniform1i(places.locates, 0);
    gl.uniform2iv(places.rows, rows);
    gl.uniform1f(places.opacity, opacity);
    const draw = () => {
      gl.useProgram(this.plain_.program);
      gl.drawElements(gl.TRIANGLES, plain, gl.UNSIGNED_INT, 0);
      gl.useProgram(program);
      gl.drawElements(gl.TRIANGLES, triangles.length - plain, gl.UNSIGNED_INT, 4 * plain);
    };
    if (opacity === 1) {
      draw();
    } else {
      this.blend_(draw);
    }
    this.hatch_(picture, {begin: plain, end: partialEnds[calm]}, matrix, rows);
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
    const {gl} = this, found = new Uint8Array(4);
    this.pixel_ ??= this.makePixel_();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pixel_);
    gl.viewport(-x, y + 1 - height, width, height);
    gl.clearColor(1, 1, 1, 1);  // Further right and below than any picture reaches.
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const {places} = this.surfaces_, matrix = new Float32Array(warp);
    const {triangles} = this.meshFor_(picture, matrix, {width, height});
    this.prepare_(this.surfaces_, picture, matrix);
    gl.uniform1f(places.magnification, magnification * width / this.size_.width);
    gl.uniform1i(places.locates, 1);
    gl.uniform2i(places.rows, 0, 0);
    gl.drawElements(gl.TRIANGLES, triangles.length, gl.UNSIGNED_INT, 0);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return found[1] === 255 ? null : {x: found[0] + 256 * found[1], y: found[2] + 256 * found[3]};
  }

  /** @private */
  makePixel_() {
    const {gl} = this, framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    for (const [place, format] of /** @type {const} */ ([[gl.COLOR_ATTACHMENT0, gl.RGBA8],
      [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]])) {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    return framebuffer;
  }

  /**
   * Binds the triangles of a picture: those of blocks if the warp allows them.
   * @private
   * @param {number} picture
   * @param {Float32Array} matrix
   * @param {{width: number, height: number}} viewport
   */
  meshFor_(picture, matrix, viewport) {
    const {gl} = this, {triangles, meshOf} = this.meshes_[picture];
    const hasBlocks = canShowBlocks(matrix, viewport), chosen = triangles[Number(hasBlocks)];
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, chosen.buffer);
    if (!chosen.mesh) {
      chosen.mesh = meshOf(hasBlocks);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, chosen.mesh.triangles, gl.STREAM_DRAW);
    }
    return chosen.mesh;
  }

  /**
   * Sets a program of surfaces, and what it draws of a picture.
   * @private
   * @param {{program: WebGLProgram, places: Record<string, WebGLUniformLocation | null>}} chosen
   * @param {number} picture
   * @param {Float32Array} matrix
   */
  prepare_({program, places}, picture, matrix) {
    const {gl} = this, {width, height} = this.size_;
    const {corners, mask, seams} = this.meshes_[picture];
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.useProgram(program);
    this.bind_(CORNERS, corners);
    this.bind_(MASK, mask);
    this.bind_(SEAMS, seams);
    this.bind_(COLORS, this.colors_);
    gl.uniform1i(places.corners, CORNERS);
    gl.uniform1i(places.mask, MASK);
    gl.uniform1i(places.colors, COLORS);
    gl.uniform1i(places.seams, SEAMS);
    gl.uniform2i(places.size, width, height);
    gl.uniform1i(places.top, picture * height);
    gl.uniform3fv(places.background, this.background_);
    gl.uniform1i(places.hatches, 0);
    gl.uniformMatrix4fv(places.warp, false, matrix);
    return places;
  }

  /**
   * Draws a surface over what is drawn already. From the new viewpoint, parts of the surface may be
   * behind other parts: only the nearest is seen.
   * @private
   * @param {() => void} draw
   */
  blend_(draw) {
    const {gl} = this;
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-CELL_PX, 0);
    gl.colorMask(false, false, false, false);
    draw();
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.EQUAL);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    draw();
    gl.disable(gl.BLEND);
    gl.depthFunc(gl.LESS);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }

  /**
   * Hatches what the picture has not seen: cells that became too long, and what its edges hid.
   * @private
   * @param {number} picture
   * @param {{begin: number, end: number}} torn  Corners of the triangles that may have torn.
   * @param {Float32Array} matrix
   * @param {number[]} rows  The uniform of ROWS.
   */
  hatch_(picture, {begin, end}, matrix, rows) {
    const {gl} = this, {walls, wallCount} = this.meshes_[picture];
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(false);
    gl.uniform1i(this.surfaces_.places.hatches, 1);
    gl.drawElements(gl.TRIANGLES, end - begin, gl.UNSIGNED_INT, 4 * begin);
    const {program, places} = this.walls_;
    gl.useProgram(program);
    this.bindWallTriangles_(wallCount);
    this.bind_(WALLS, walls);
    gl.uniform1i(places.walls, WALLS);
    gl.uniform2i(places.size, this.size_.width, this.size_.height);
    gl.uniform1f(places.opened, openedBy(matrix));
    gl.uniform3fv(places.background, this.background_);
    gl.uniform2iv(places.rows, rows);
    gl.uniformMatrix4fv(places.warp, false, matrix);
    gl.drawElements(gl.TRIANGLES, 6 * wallCount, gl.UNSIGNED_INT, 0);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
  }

  /** The same for all pictures, so it only grows. @private @param {number} count */
  bindWallTriangles_(count) {
    const {gl, wallTriangles_: triangles} = this;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, triangles.buffer);
    if (triangles.count < count) {
      triangles.count = 2 ** Math.ceil(Math.log2(count));
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, wallTriangles(triangles.count), gl.STATIC_DRAW);
    }
  }

  /**
   * @private
   * @param {PictureMesh} mesh
   * @param {LeanDepths} lean
   */
  fill_(mesh, lean) {
    const {gl} = this, {width, height} = this.size_;
    this.bind_(CORNERS, mesh.corners);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16UI, lean.columns, lean.rows, 0, gl.RED_INTEGER,
      gl.UNSIGNED_SHORT, lean.corners);
    this.bind_(MASK, mesh.mask);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8UI, maskRowBytes(width), height, 0, gl.RED_INTEGER,
      gl.UNSIGNED_BYTE, lean.mask);
    const covered = coveredCells(lean, width, height);
    const {texels, texelRows} = seamTexels(lean);
    this.bind_(SEAMS, mesh.seams);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32UI, SEAM_COLUMNS, texelRows, 0, gl.RG_INTEGER,
      gl.UNSIGNED_INT, texels);
    mesh.meshOf = hasBlocks => meshOf(lean, covered, width, height, hasBlocks);
    mesh.triangles.forEach(each => { each.mesh = null; });
    const walls = wallsOf(lean, covered, width, height);
    this.bind_(WALLS, mesh.walls);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32UI, WALL_COLUMNS, walls.rows, 0, gl.RG_INTEGER,
      gl.UNSIGNED_INT, walls.texels);
    mesh.wallCount = walls.count;
  }

  /**
   * @private
   * @param {number} filter
   */
  texture_(filter) {
    const {gl} = this, texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /**
   * @private
   * @param {number} unit
   * @param {WebGLTexture | null} texture
   */
  bind_(unit, texture) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, texture);
  }
}
