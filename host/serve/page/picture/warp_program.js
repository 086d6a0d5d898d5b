// The programs that draw a picture from another viewpoint.
import {say} from '../texts/say.js';
import {CELL_PX, MAX_LEAN} from './lean_depths.js';
import {SEAM_COLUMNS} from './warp_mesh.js';
import {HATCH, ROWS} from './warp_walls.js';

/**
 * A cell that became more than this many times longer is hatched: the picture has seen its surface
 * at a glancing angle only.
 */
export const MOST_STRETCH = 3;

// A vertex is a corner of a cell, and lies where its depth puts it. The first vertices are the
// corners of the picture. The others belong to seams, whose surfaces have corners of their own: a
// texel has the depth and the pixels of the surface, and the place of the corner in its cell.
export const VERTEX = `#version 300 es
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
invariant gl_Position;  // Layers draw only what is at the depth of an earlier drawing.
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
export const FRAGMENT = `#version 300 es
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
uniform bool locates;
in vec2 at_px;
flat in uint pixels;
flat in ivec2 cell_px;
out vec4 color;
${ROWS}
${HATCH}
void main() {
  vec2 across = dFdx(at_px) * magnification, down = dFdy(at_px) * magnification;
  float sum = dot(across, across) + dot(down, down);
  float area = across.x * down.y - across.y * down.x;
  float least = (sum - sqrt(max(0.0, sum * sum - 4.0 * area * area))) / 2.0;
  if (is_other_row()) {
    discard;
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
  if (is_torn != hatches || (bits >> uint(pixel.x & 7) & 1u) == 0u) {
    discard;
  }
  if (hatches) {
    color = hatch();
    return;
  }
  place = clamp(place, vec2(0.5), vec2(size) - 0.5);  // Below may be another picture.
  place.y += float(top);
  color = locates ? vec4(ivec4(pixel, pixel >> 8).xzyw & 255) / 255.0
    : vec4(texture(colors, place / vec2(textureSize(colors, 0))).rgb, opacity);
}`;

/** FRAGMENT for cells that show one surface in all pixels and do not tear. */
export const PLAIN_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform sampler2D colors;
uniform ivec2 size;
uniform int top;
uniform float opacity;
in vec2 at_px;
out vec4 color;
void main() {
  vec2 place = clamp(at_px, vec2(0.5), vec2(size) - 0.5);  // Below may be another picture.
  place.y += float(top);
  color = vec4(texture(colors, place / vec2(textureSize(colors, 0))).rgb, opacity);
}`;

/**
 * A program, and the places of its uniforms by name.
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 */
export function programOf(gl, vertex, fragment) {
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
    throw new Error(say`the browser refuses the shaders: ${logs.join(' ')}
      ${gl.getProgramInfoLog(program) ?? ''}`);
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
