// Lines and labels of the room, drawn with depth among the pictures of the patient.
import {programOf} from '../picture/warp_program.js';

/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {{from: Vector, to: Vector, color: number[]}} Line  Meters; red to alpha, 0 to 1. */

/**
 * A text that faces the viewer.
 * @typedef {object} Label
 * @property {string} text     May have several lines.
 * @property {Vector} at       Of its middle, meters.
 * @property {number} height   Of a line, meters.
 * @property {string} color    As CSS has it.
 * @property {boolean} [boxed] On a dark ground, and not hidden by what is nearer.
 */

const TEXT_PX = 48;         // Height of a line in the texture.
const PAD_PX = 18;
const MOST_TEXTS = 64;
const FLOATS_PER_POINT = 7;
const FADES_M = 3.5;        // Lines disappear at this distance from the middle of the room.

const LINE_VERTEX = `#version 300 es
uniform mat4 clip;
uniform vec3 middle;
layout(location = 0) in vec3 place;
layout(location = 1) in vec4 tint;
out vec4 shade;
void main() {
  gl_Position = clip * vec4(place, 1.0);
  float fade = place.y == 0.0 ? clamp(1.0 - distance(place, middle) / ${FADES_M}, 0.0, 1.0) : 1.0;
  shade = vec4(tint.rgb * tint.a, tint.a) * fade;
}`;
const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec4 shade;
out vec4 color;
void main() { color = shade; }`;

const LABEL_VERTEX = `#version 300 es
uniform mat4 clip;
uniform vec3 middle;
uniform vec3 right;
uniform vec3 up;
out vec2 place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  place = vec2(corner.x, 1.0 - corner.y);
  gl_Position = clip * vec4(middle + right * (corner.x - 0.5) + up * (corner.y - 0.5), 1.0);
}`;
const LABEL_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D text;
in vec2 place;
out vec4 color;
void main() {
  color = texture(text, place);
  if (color.a < 0.02) { discard; }
}`;

/** Draws into the viewport of the bound framebuffer. */
export class RoomPainter {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    /** @private */
    this.gl_ = gl;
    /** @private */
    this.lines_ = programOf(gl, LINE_VERTEX, LINE_FRAGMENT);
    /** @private */
    this.labels_ = programOf(gl, LABEL_VERTEX, LABEL_FRAGMENT);
    /** @private */
    this.points_ = gl.createBuffer();
    /** @private */
    this.array_ = gl.createVertexArray();
    /** @private */
    this.count_ = 0;
    /** @private @type {Map<string, {texture: WebGLTexture | null, aspect: number,
     *  rows: number}>} */
    this.texts_ = new Map();
    gl.bindVertexArray(this.array_);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.points_);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 4 * FLOATS_PER_POINT, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 4, gl.FLOAT, false, 4 * FLOATS_PER_POINT, 12);
    gl.bindVertexArray(null);
  }

  /**
   * Takes the lines of the next drawings.
   * @param {Line[]} lines
   */
  take(lines) {
    const gl = this.gl_;
    this.count_ = 2 * lines.length;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.points_);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(lines.flatMap(({from, to, color}) =>
      [...from, ...color, ...to, ...color])), gl.STREAM_DRAW);
  }

  /**
   * Draws the lines, then the labels from back to front.
   * @param {number[]} clip     From meters of the room.
   * @param {Vector} middle     Lines on the floor fade around this point.
   * @param {Label[]} labels
   * @param {{right: Vector, up: Vector, position: Vector}} viewer  Unit vectors; meters.
   */
  draw(clip, middle, labels, {right, up, position}) {
    const gl = this.gl_, matrix = new Float32Array(clip);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.useProgram(this.lines_.program);
    gl.uniformMatrix4fv(this.lines_.places.clip, false, matrix);
    gl.uniform3fv(this.lines_.places.middle, middle);
    gl.bindVertexArray(this.array_);
    gl.drawArrays(gl.LINES, 0, this.count_);
    gl.bindVertexArray(null);
    gl.useProgram(this.labels_.program);
    gl.uniformMatrix4fv(this.labels_.places.clip, false, matrix);
    gl.uniform1i(this.labels_.places.text, 0);
    const distance = (/** @type {Label} */ {at}) => Math.hypot(at[0] - position[0],
      at[1] - position[1], at[2] - position[2]);
    const inOrder = [...labels].sort((a, b) =>
      Number(a.boxed ?? false) - Number(b.boxed ?? false) || distance(b) - distance(a));
    for (const label of inOrder) {
      if (label.boxed) {
        gl.disable(gl.DEPTH_TEST);
      }
      const {texture, aspect, rows} = this.text_(label);
      const height = label.height * rows, width = height * aspect;
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform3fv(this.labels_.places.middle, label.at);
      gl.uniform3fv(this.labels_.places.right, right.map(each => each * width));
      gl.uniform3fv(this.labels_.places.up, up.map(each => each * height));
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  /** @private @param {Label} label */
  text_({text, color, boxed = false}) {
    const key = `${color} ${boxed} ${text}`;
    const known = this.texts_.get(key);
    if (known) {
      return known;
    }
    const gl = this.gl_;
    if (this.texts_.size >= MOST_TEXTS) {
      const [oldest] = this.texts_.keys();
      gl.deleteTexture(this.texts_.get(oldest)?.texture ?? null);
      this.texts_.delete(oldest);
    }
    const canvas = document.createElement('canvas');
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
    const font = `600 ${TEXT_PX}px system-ui, sans-serif`, lines = text.split('\n');
    context.font = font;
    const pad = boxed ? PAD_PX : PAD_PX / 2;
    const rowPx = 1.25 * TEXT_PX;
    canvas.width = Math.ceil(Math.max(...lines.map(each => context.measureText(each).width)))
      + 2 * pad;
    canvas.height = Math.ceil(rowPx * lines.length) + 2 * pad;
    if (boxed) {
      context.fillStyle = '#16191df2';
      context.beginPath();
      context.roundRect(0, 0, canvas.width, canvas.height, PAD_PX);
      context.fill();
    }
    context.font = font;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.lineWidth = 8;
    context.lineJoin = 'round';
    context.strokeStyle = '#000a';
    context.fillStyle = color;
    lines.forEach((line, row) => {
      const [x, y] = [canvas.width / 2, pad + (row + 0.5) * rowPx];
      if (!boxed) {
        context.strokeText(line, x, y);
      }
      context.fillText(line, x, y);
    });
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const made = {texture, aspect: canvas.width / canvas.height, rows: canvas.height / rowPx};
    this.texts_.set(key, made);
    return made;
  }
}
