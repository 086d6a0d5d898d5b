// Combines the pictures of both eyes to an anaglyph with WebGL 2, in linear light.
import {FILTER} from './compose.js';

const UNIT = 5;  // Texture unit, after those of WarpPainter.

const VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D eyes;
uniform mat3 left_filter;
uniform mat3 right_filter;
out vec4 color;
vec3 light_of(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 left = texelFetch(eyes, at, 0).rgb;
  vec3 right = texelFetch(eyes, at + ivec2(textureSize(eyes, 0).x / 2, 0), 0).rgb;
  vec3 c = clamp(left_filter * light_of(left) + right_filter * light_of(right), 0.0, 1.0);
  color = vec4(mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055,
                   greaterThan(c, vec3(0.0031308))), 1.0);
}`;

/** @param {number} first  Column of FILTER. */
function columnsOf(first) {
  return [0, 1, 2].flatMap(column => FILTER.map(row => row[first + column]));
}

export class Anaglyph {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {(vertex: string, fragment: string) => WebGLProgram} programOf
   */
  constructor(gl, programOf) {
    /** @private */
    this.gl_ = gl;
    /** @private */
    this.program_ = programOf(VERTEX, FRAGMENT);
    /** @private */
    this.texture_ = gl.createTexture();
    /** @private */
    this.depth_ = gl.createRenderbuffer();
    /** @private */
    this.framebuffer_ = gl.createFramebuffer();
    /** @private */
    this.size_ = {width: 0, height: 0};
  }

  /**
   * Directs what is drawn to the pictures of both eyes, side by side.
   * @param {number} width   Of one picture, pixels.
   * @param {number} height
   */
  begin(width, height) {
    const gl = this.gl_;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer_);
    if (this.size_.width !== width || this.size_.height !== height) {
      this.size_ = {width, height};
      gl.activeTexture(gl.TEXTURE0 + UNIT);
      gl.bindTexture(gl.TEXTURE_2D, this.texture_);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 2 * width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE,
        null);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture_,
        0);
      gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth_);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, 2 * width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER,
        this.depth_);
    }
  }

  /** Draws the anaglyph of both pictures on the canvas. */
  end() {
    const gl = this.gl_, {width, height} = this.size_, program = this.program_;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.useProgram(program);
    gl.activeTexture(gl.TEXTURE0 + UNIT);
    gl.bindTexture(gl.TEXTURE_2D, this.texture_);
    gl.uniform1i(gl.getUniformLocation(program, 'eyes'), UNIT);
    for (const [name, first] of /** @type {const} */ ([['left_filter', 0], ['right_filter', 3]])) {
      gl.uniformMatrix3fv(gl.getUniformLocation(program, name), false, columnsOf(first));
    }
    gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
  }
}
