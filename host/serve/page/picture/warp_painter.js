// Draws a picture from another viewpoint with WebGL 2, by the depths at the corners of cells.
import {CELL_PX, coveredCells, maskRowBytes, MAX_LEAN} from './lean_depths.js';
import {meshOf, SEAM_COLUMNS} from './warp_mesh.js';
import {HATCH, WALL_COLUMNS, WALL_FRAGMENT, WALL_VERTEX, wallsOf} from './warp_walls.js';

/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */

/**
 * A cell that became more than this many times longer is hatched: the picture has seen its surface
 * at a glancing angle only.
 */
export const MOST_STRETCH = 3;
const CORNERS = 0, MASK = 1, COLORS = 2, SEAMS = 3, WALLS = 4;  // Texture units.
/**
 * Walls before the background reach so far behind a surface, of the 2 units of depth in clip space:
 * at least, and more if planes of equal depth have moved against each other. With longer walls most
 * of the hatch would hide the background; shorter ones miss the back of a bone that turns.
 */
const OPENED = 0.13, OPENED_BY_MOVE = 0.05;

/**
 * What is drawn of a picture.
 * @typedef {object} PictureMesh
 * @property {WebGLTexture | null} corners
 * @property {WebGLTexture | null} mask
 * @property {WebGLTexture | null} seams
 * @property {WebGLTexture | null} walls
 * @property {WebGLBuffer | null} triangles
 * @property {number} count                  Of the triangles' corners.
 * @property {number} steepAt                Before it are the corners of cells that never tear.
 * @property {number} wallCount
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
uniform bool hatches;
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
  if (hatches) {
    gl_Position.z = gl_Position.w * 0.999999;  // Only where no surface is.
  }
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
uniform float opacity;
uniform bool hatches;
in vec2 at_px;
flat in uint pixels;
flat in ivec2 cell_px;
out vec4 color;
${HATCH}
void main() {
  vec2 across = dFdx(at_px) * magnification, down = dFdy(at_px) * magnification;
  float sum = dot(across, across) + dot(down, down);
  float area = across.x * down.y - across.y * down.x;
  float least = (sum - sqrt(max(0.0, sum * sum - 4.0 * area * area))) / 2.0;
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
  if (is_torn != hatches || (bits >> uint(pixel.x & 7) & 1u) == 0u) {
    discard;
  }
  if (hatches) {
    color = hatch();
    return;
  }
  place = clamp(place, vec2(0.5), vec2(size) - 0.5);  // Below may be another picture.
  place.y += float(top);
  color = vec4(texture(colors, place / vec2(textureSize(colors, 0))).rgb, opacity);
}`;

/**
 * A program, and the places of its uniforms by name.
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
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
  /** @type {Record<string, WebGLUniformLocation | null>} */
  const places = {};
  const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) ?? 0;
  for (let at = 0; at < count; ++at) {
    const name = gl.getActiveUniform(program, at)?.name ?? '';
    places[name] = gl.getUniformLocation(program, name);
  }
  return {program, places};
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
    this.surfaces_ = programOf(gl, VERTEX, FRAGMENT);
    /** @private */
    this.walls_ = programOf(gl, WALL_VERTEX, WALL_FRAGMENT);
    /** @private */
    this.colors_ = gl.createTexture();
    /** @private @type {PictureMesh[]} From top to bottom. */
    this.meshes_ = [];
    /** @private Of one picture, pixels. */
    this.size_ = {width: 0, height: 0};
    /** @private Red, green, blue: 0 to 1. */
    this.background_ = [0, 0, 0];
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
        seams: gl.createTexture(), walls: gl.createTexture(), triangles: gl.createBuffer(),
        count: 0, steepAt: 0, wallCount: 0});
    }
    leans.forEach((lean, at) => this.fill_(this.meshes_[at], lean));
    this.bind_(COLORS, this.colors_, gl.LINEAR);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
  }

  /**
   * Clears the canvas, which gets this size.
   * @param {number} width       Pixels.
   * @param {number} height
   * @param {string} background  #rrggbb, where no surface is.
   */
  begin(width, height, background) {
    const gl = this.gl_, canvas = this.canvas_;
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    this.background_ = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16) / 255);
    const [red, green, blue] = this.background_;
    gl.viewport(0, 0, width, height);
    gl.clearColor(red, green, blue, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /**
   * Draws a picture into the viewport.
   * @param {number} picture         From the top, from 0.
   * @param {number[]} warp          From the clip space of the picture to the new clip space.
   * @param {number} magnification   New zoom over the zoom of the picture.
   * @param {number} [opacity]       0 to 1. Below 1, what is drawn already shows through.
   */
  draw(picture, warp, magnification, opacity = 1) {
    const gl = this.gl_, {width, height} = this.size_;
    const {corners, mask, seams, triangles, count} = this.meshes_[picture];
    const {program, places} = this.surfaces_;
    const matrix = new Float32Array(warp);
    gl.useProgram(program);
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
    gl.uniform1f(places.opacity, opacity);
    gl.uniform3fv(places.background, this.background_);
    gl.uniform1i(places.hatches, 0);
    gl.uniformMatrix4fv(places.warp, false, matrix);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, triangles);
    const draw = () => gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    if (opacity === 1) {
      draw();
    } else {
      this.blend_(draw);
    }
    this.hatch_(this.meshes_[picture], matrix);
  }

  /**
   * Draws a surface over what is drawn already. From the new viewpoint, parts of the surface may be
   * behind other parts: only the nearest is seen.
   * @private
   * @param {() => void} draw
   */
  blend_(draw) {
    const gl = this.gl_;
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
   * @param {PictureMesh} mesh
   * @param {Float32Array} matrix
   */
  hatch_({count, steepAt, walls, wallCount}, matrix) {
    const gl = this.gl_;
    gl.depthFunc(gl.LEQUAL);
    gl.depthMask(false);
    gl.uniform1i(this.surfaces_.places.hatches, 1);
    gl.drawElements(gl.TRIANGLES, count - steepAt, gl.UNSIGNED_INT, 4 * steepAt);
    const {program, places} = this.walls_;
    gl.disable(gl.CULL_FACE);
    gl.useProgram(program);
    this.bind_(WALLS, walls, gl.NEAREST);
    gl.uniform1i(places.walls, WALLS);
    gl.uniform2i(places.size, this.size_.width, this.size_.height);
    gl.uniform1f(places.opened,
      OPENED + OPENED_BY_MOVE * Math.hypot(matrix[8], matrix[9]) / matrix[15]);
    gl.uniform3fv(places.background, this.background_);
    gl.uniformMatrix4fv(places.warp, false, matrix);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * wallCount);
    gl.enable(gl.CULL_FACE);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
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
    const covered = coveredCells(lean, width, height);
    const {triangles, steepAt, texels, texelRows} = meshOf(lean, covered);
    this.bind_(SEAMS, mesh.seams, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32UI, SEAM_COLUMNS, texelRows, 0, gl.RG_INTEGER,
      gl.UNSIGNED_INT, texels);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STREAM_DRAW);
    mesh.count = triangles.length;
    mesh.steepAt = steepAt;
    const walls = wallsOf(lean, covered, width, height);
    this.bind_(WALLS, mesh.walls, gl.NEAREST);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32UI, WALL_COLUMNS, walls.rows, 0, gl.RG_INTEGER,
      gl.UNSIGNED_INT, walls.texels);
    mesh.wallCount = walls.count;
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
