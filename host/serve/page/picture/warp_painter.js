// Draws a picture from another viewpoint with WebGL 2, by the depths at the corners of cells.
import {Anaglyph} from './anaglyph.js';
import {CELL_PX, cornerOf, coveredCells, maskRowBytes, MAX_LEAN} from './lean_depths.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */

/**
 * Nothing is drawn in a cell that became more than this many times longer: the picture has seen its
 * surface at a glancing angle only.
 */
export const MOST_STRETCH = 3;
const SEAM_COLUMNS = 1024;   // Texels per row of the texture of seams.
const CORNERS = 0, MASK = 1, COLORS = 2, SEAMS = 3;  // Texture units.

/**
 * What is drawn of a picture.
 * @typedef {object} PictureMesh
 * @property {WebGLTexture | null} corners
 * @property {WebGLTexture | null} mask
 * @property {WebGLTexture | null} seams
 * @property {WebGLBuffer | null} triangles
 * @property {number} count                  Of the triangles' corners.
 */

/**
 * Where a picture is drawn on the canvas, pixels.
 * @typedef {object} Viewport
 * @property {number} left
 * @property {number} width
 * @property {number} height
 * @property {number} [rows]  0 or 1: draws only the rows 0, 2 ... or 1, 3 ... from the top.
 */

// A vertex is a corner of a cell, and lies where its depth puts it. The first vertices are the
// corners of the picture. The others belong to seams, whose surfaces have corners of their own: a
// texel has the depth and the pixels of the surface, and the place of the corner in its cell.
const VERTEX = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D corners;
uniform usampler2D seams;
uniform ivec2 size;
uniform mat4 warp;
out vec2 at_px;
flat out uint pixels;
flat out ivec2 cell_px;
void main() {
  ivec2 count = textureSize(corners, 0);
  int other = gl_VertexID - count.x * count.y;
  ivec2 corner = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
  uint lean;
  pixels = 0xffffu;
  cell_px = ivec2(0);
  if (other < 0) {
    lean = texelFetch(corners, corner, 0).r;
  } else {
    uvec2 seam = texelFetch(seams, ivec2(other % ${SEAM_COLUMNS}, other / ${SEAM_COLUMNS}), 0).rg;
    lean = seam.r & 0xffffu;
    pixels = seam.r >> 16;
    ivec2 cell = ivec2(seam.g & 0xffffu, seam.g >> 16);
    cell_px = cell * ${CELL_PX};
    corner = cell + ivec2(other & 1, other >> 1 & 1);
  }
  at_px = vec2(min(corner * ${CELL_PX}, size));
  vec2 across = at_px / vec2(size);
  float depth = (float(lean) - 0.5) / ${MAX_LEAN}.0;
  gl_Position = warp * vec4(across.x * 2.0 - 1.0, 1.0 - across.y * 2.0, depth * 2.0 - 1.0, 1.0);
}`;

// The least singular value of the change of place in the picture per pixel of the canvas is the
// inverse of the longest stretch.
const FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
uniform sampler2D colors;
uniform usampler2D mask;
uniform ivec2 size;
uniform int top;
uniform float magnification;
uniform bool locates;
uniform ivec2 rows;
in vec2 at_px;
flat in uint pixels;
flat in ivec2 cell_px;
out vec4 color;
void main() {
  vec2 across = dFdx(at_px) * magnification, down = dFdy(at_px) * magnification;
  float sum = dot(across, across) + dot(down, down);
  float area = across.x * down.y - across.y * down.x;
  float least = (sum - sqrt(max(0.0, sum * sum - 4.0 * area * area))) / 2.0;
  if (rows.y > 0 && (rows.y - 1 - int(gl_FragCoord.y) & 1) != rows.x) {
    discard;  // The row belongs to the other eye.
  }
  bool is_torn = least * ${MOST_STRETCH ** 2}.0 < 1.0;
  ivec2 pixel = clamp(ivec2(floor(at_px)), ivec2(0), size - 1);
  vec2 place = at_px;
  if (pixels != 0xffffu) {
    pixel = clamp(pixel, cell_px, cell_px + ${CELL_PX - 1});
    ivec2 within = pixel - cell_px;
    if ((pixels >> uint(within.y * ${CELL_PX} + within.x) & 1u) == 0u) {
      discard;
    }
    place = vec2(pixel) + 0.5;  // Beside the pixel may be another surface.
  }
  uint bits = texelFetch(mask, ivec2(pixel.x >> 3, pixel.y), 0).r;
  if (is_torn || (bits >> uint(pixel.x & 7) & 1u) == 0u) {
    discard;
  }
  place = clamp(place, vec2(0.5), vec2(size) - 0.5);  // Below may be another picture.
  place.y += float(top);
  color = locates ? vec4(ivec4(pixel, pixel >> 8).xzyw & 255) / 255.0
    : vec4(texture(colors, place / vec2(textureSize(colors, 0))).rgb, 1.0);
}`;

/**
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 * @returns {WebGLProgram}
 */
function programOf(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, source] of /** @type {const} */ ([[gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(type));
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = (gl.getAttachedShaders(program) ?? []).map(each => gl.getShaderInfoLog(each));
    throw new Error(`the browser refuses the shaders: ${logs.join(' ')} `
      + `${gl.getProgramInfoLog(program)}`);
  }
  return program;
}

/**
 * The triangles of all cells that show something, counterclockwise as seen by the camera of the
 * picture, and the texels of the corners of seams.
 * @param {LeanDepths} lean
 * @param {Uint8Array} covered  Of cells.
 */
function meshOf({columns, rows, seams}, covered) {
  const inner = covered.slice();
  for (const {cell} of seams) {
    inner[cell] = 0;
  }
  const surfaces = seams.flatMap(({cell, near_pixels, near, far}) => [
    {cell, pixels: ~near_pixels & 0xffff, depths: far},
    ...(near_pixels === 0 ? [] : [{cell, pixels: near_pixels, depths: near}])]);
  const cells = inner.reduce((sum, each) => sum + each, 0);
  const triangles = new Uint32Array(6 * (cells + surfaces.length));
  let at = 0;
  const add = (/** @type {number[]} */ ...corners) => {
    for (const each of corners) {
      triangles[at++] = each;
    }
  };
  for (let cell = 0; cell < inner.length; ++cell) {
    if (inner[cell]) {
      const corner = cornerOf(cell, columns), below = corner + columns;
      add(corner, below, corner + 1, corner + 1, below, below + 1);
    }
  }
  const texelRows = Math.max(1, Math.ceil(4 * surfaces.length / SEAM_COLUMNS));
  const texels = new Uint32Array(2 * SEAM_COLUMNS * texelRows);
  surfaces.forEach(({cell, pixels, depths}, index) => {
    const first = columns * rows + 4 * index;
    add(first, first + 2, first + 1, first + 1, first + 2, first + 3);
    const place = cell % (columns - 1) | Math.floor(cell / (columns - 1)) << 16;
    depths.forEach((depth, corner) => {
      texels[2 * (4 * index + corner)] = depth | pixels << 16;
      texels[2 * (4 * index + corner) + 1] = place;
    });
  });
  return {triangles, texels, texelRows};
}

/** Draws pictures of one size, which lie in one bitmap from top to bottom. */
export class WarpPainter {
  /**
   * @param {HTMLCanvasElement} canvas
   * @throws {Error} if the browser has no WebGL 2
   */
  constructor(canvas) {
    const gl = canvas.getContext('webgl2', {alpha: false, antialias: false, stencil: false});
    if (!gl) {
      throw new Error('the browser has no WebGL 2');
    }
    /** @private */
    this.canvas_ = canvas;
    /** @private */
    this.gl_ = gl;
    /** @private */
    this.program_ = programOf(gl, VERTEX, FRAGMENT);
    /** @private */
    this.places_ = Object.fromEntries(['corners', 'seams', 'colors', 'mask', 'size', 'warp',
      'magnification', 'top', 'locates', 'rows'].map(name =>
      [name, gl.getUniformLocation(this.program_, name)]));
    /** @private */
    this.colors_ = gl.createTexture();
    /** @private @type {PictureMesh[]} From top to bottom. */
    this.meshes_ = [];
    /** @private Of one picture, pixels. */
    this.size_ = {width: 0, height: 0};
    /** @private Made when it is first used. @type {Anaglyph | null} */
    this.anaglyph_ = null;
    /** @private A pixel with depth, made when it is first used. @type {WebGLFramebuffer | null} */
    this.pixel_ = null;
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
  }

  /**
   * Takes pictures with their depths.
   * @param {ImageBitmap} bitmap
   * @param {LeanDepths[]} leans  Of each picture, from top to bottom.
   */
  take(bitmap, leans) {
    const gl = this.gl_;
    const width = bitmap.width, height = bitmap.height / leans.length;
    this.size_ = {width, height};
    while (this.meshes_.length < leans.length) {
      this.meshes_.push({corners: gl.createTexture(), mask: gl.createTexture(),
        seams: gl.createTexture(), triangles: gl.createBuffer(), count: 0});
    }
    leans.forEach((lean, at) => this.fill_(this.meshes_[at], lean));
    this.bind_(COLORS, this.colors_, gl.LINEAR);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
  }

  /**
   * Clears the canvas, which gets this size.
   * @param {number} width       Pixels.
   * @param {number} height
   * @param {string} background  #rrggbb, where nothing is known.
   */
  begin(width, height, background) {
    const gl = this.gl_, canvas = this.canvas_;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    const [red, green, blue] = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16)
      / 255);
    gl.viewport(0, 0, width, height);
    gl.clearColor(red, green, blue, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /**
   * The same for two eyes, whose pictures are combined to an anaglyph: draw() the left one into the
   * viewport that begins at 0, the right one at `width`. Ends with endAnaglyph().
   * @param {number} width
   * @param {number} height
   * @param {string} background
   */
  beginAnaglyph(width, height, background) {
    const gl = this.gl_;
    this.begin(width, height, background);
    this.anaglyph_ ??= new Anaglyph(gl, (vertex, fragment) => programOf(gl, vertex, fragment));
    this.anaglyph_.begin(width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  endAnaglyph() {
    this.anaglyph_?.end();
  }

  /**
   * Draws a picture into the viewport.
   * @param {number} picture         From the top, from 0.
   * @param {number[]} warp          From the clip space of the picture to the new clip space.
   * @param {number} magnification   New zoom over the zoom of the picture.
   * @param {Viewport} [viewport]    From the lower left corner; without it, the present one.
   */
  draw(picture, warp, magnification, viewport) {
    const gl = this.gl_;
    gl.useProgram(this.program_);
    gl.uniform1i(this.places_.locates, 0);
    gl.uniform2i(this.places_.rows, viewport?.rows ?? 0,
      viewport?.rows === undefined ? 0 : viewport.height);
    if (viewport) {
      gl.viewport(viewport.left, 0, viewport.width, viewport.height);
    }
    this.submit_(picture, warp, magnification * (viewport ? viewport.width / this.size_.width : 1));
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
    const gl = this.gl_, found = new Uint8Array(4);
    this.pixel_ ??= this.makePixel_();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pixel_);
    gl.viewport(-x, y + 1 - height, width, height);
    gl.clearColor(1, 1, 1, 1);  // Further right and below than any picture reaches.
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program_);
    gl.uniform1i(this.places_.locates, 1);
    gl.uniform2i(this.places_.rows, 0, 0);
    this.submit_(picture, warp, magnification * width / this.size_.width);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return found[1] === 255 ? null : {x: found[0] + 256 * found[1], y: found[2] + 256 * found[3]};
  }

  /** @private */
  makePixel_() {
    const gl = this.gl_, framebuffer = gl.createFramebuffer();
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
   * @private
   * @param {number} picture
   * @param {number[]} warp
   * @param {number} magnification
   */
  submit_(picture, warp, magnification) {
    const gl = this.gl_, places = this.places_, {width, height} = this.size_;
    const {corners, mask, seams, triangles, count} = this.meshes_[picture];
    this.bind_(CORNERS, corners, gl.NEAREST);
    this.bind_(MASK, mask, gl.NEAREST);
    this.bind_(SEAMS, seams, gl.NEAREST);
    this.bind_(COLORS, this.colors_, gl.LINEAR);
    gl.uniform1i(places.corners, CORNERS);
    gl.uniform1i(places.mask, MASK);
    gl.uniform1i(places.colors, COLORS);
    gl.uniform1i(places.seams, SEAMS);
    gl.uniform2i(places.size, width, height);
    gl.uniform1i(places.top, picture * height);
    gl.uniform1f(places.magnification, magnification);
    gl.uniformMatrix4fv(places.warp, false, new Float32Array(warp));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  /**
   * @private
   * @param {PictureMesh} mesh
   * @param {LeanDepths} lean
   */
  fill_(mesh, lean) {
    const gl = this.gl_, {width, height} = this.size_;
    this.bind_(CORNERS, mesh.corners, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16UI, lean.columns, lean.rows, 0, gl.RED_INTEGER,
      gl.UNSIGNED_SHORT, lean.corners);
    this.bind_(MASK, mesh.mask, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8UI, maskRowBytes(width), height, 0, gl.RED_INTEGER,
      gl.UNSIGNED_BYTE, lean.mask);
    const {triangles, texels, texelRows} = meshOf(lean, coveredCells(lean, width, height));
    this.bind_(SEAMS, mesh.seams, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32UI, SEAM_COLUMNS, texelRows, 0, gl.RG_INTEGER,
      gl.UNSIGNED_INT, texels);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STREAM_DRAW);
    mesh.count = triangles.length;
  }

  /**
   * @private
   * @param {number} unit
   * @param {WebGLTexture | null} texture
   * @param {number} filter
   */
  bind_(unit, texture, filter) {
    const gl = this.gl_;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }
}
