// The painter of warped pictures that suits this browser.
import {SoftwarePainter} from './software_painter.js';
import {WarpPainter} from './warp_painter.js';

/** @typedef {WarpPainter | SoftwarePainter} Painter */

// A canvas keeps its kind of context. WebGL may come back without a card, after a driver failed.
/** @type {WeakSet<HTMLCanvasElement>} */
const ofWebGl = new WeakSet();
// Names of programs that compute what a graphics card would.
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** The name of what draws for WebGL 2, which browsers may hide; null without WebGL 2. */
export function webGlOf() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) {
    return null;
  }
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return name;
}

/** Whether a graphics card draws for WebGL 2. A browser that hides the name of its card has one. */
function hasGraphicsCard() {
  const name = webGlOf();
  return name !== null && !SOFTWARE.test(name);
}

/**
 * The painter of a canvas. The address can name one: `warp=webgl` or `warp=software`.
 * @param {HTMLCanvasElement} canvas
 * @returns {Painter}
 * @throws {Error} if the browser cannot draw so
 */
export function painterOf(canvas) {
  const wanted = new URL(location.href).searchParams.get('warp');
  if (ofWebGl.has(canvas) || wanted === 'webgl' || wanted !== 'software' && hasGraphicsCard()) {
    ofWebGl.add(canvas);
    return new WarpPainter(canvas);
  }
  return new SoftwarePainter(canvas);
}
