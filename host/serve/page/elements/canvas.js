// Canvases that are sharp on every screen, and colors of the style sheet.
import {say} from '../texts/say.js';

const MAX_SCALE = 3;
const BASE_FONT_PX = 13;    // tokens.css, on laptops.
/** Sizes of letters as in tokens.css, rem. */
export const TYPE_REM = {small: 0.925, body: 1, title: 1.15};

/**
 * The cleared context of a canvas whose pixels match the screen.
 * @param {HTMLCanvasElement} canvas
 * @returns {{context: CanvasRenderingContext2D, width: number, height: number, unit: number}}
 *     width and height in CSS pixels, to which the context is scaled; unit: scale of text and
 *     lines, relative to a small screen
 */
export function fitted(canvas) {
  const scale = Math.min(devicePixelRatio || 1, MAX_SCALE);
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const across = Math.max(1, Math.round(width * scale));
  const down = Math.max(1, Math.round(height * scale));
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
  }
  const context = contextOf(canvas);
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return {context, width, height, unit: unitOf(canvas)};
}

/**
 * The scale of text and lines, relative to a small screen.
 * @param {Element} element
 */
export function unitOf(element) {
  return parseFloat(getComputedStyle(element).fontSize) / BASE_FONT_PX;
}

/** CSS pixels of a rem. */
export function remPx() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize);
}

/**
 * The size of letters on a canvas.
 * @param {number} unit  As `fitted` returns it.
 * @param {keyof typeof TYPE_REM} [size]
 */
export function letterSize(unit, size = 'small') {
  return TYPE_REM[size] * BASE_FONT_PX * unit;
}

/**
 * A font for a canvas, with a size of the style sheet.
 * @param {number} unit  As `fitted` returns it.
 * @param {number} [weight]
 * @param {keyof typeof TYPE_REM} [size]
 */
export function letterFont(unit, weight = 600, size = 'small') {
  return `${weight} ${letterSize(unit, size)}px system-ui, sans-serif`;
}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
export function contextOf(canvas) {
  const context = canvas.getContext('2d');
  if (!context) {
    throw new Error(say`this browser has no 2D canvas`);
  }
  return context;
}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {Promise<Blob>}
 * @throws {Error} if the browser cannot write so large a picture
 */
export async function pngOf(canvas) {
  const written = await new Promise(take => canvas.toBlob(take));
  if (!written) {
    throw new Error(say`The browser cannot write a picture of ${canvas.width} x
      ${canvas.height} pixels. Choose a smaller size.`);
  }
  return written;
}

/**
 * Whether two sizes have the same proportions, but for a pixel of the larger one.
 * @param {number[]} a
 * @param {number[]} b
 */
export function areAlike([width, height], [across, down]) {
  return Math.abs(width * down - height * across) <= Math.max(width, height, across, down);
}

/**
 * The value of a custom property of the style sheet at an element.
 * @param {Element} element
 * @param {string} name  '--...'
 */
export function styleColor(element, name) {
  return getComputedStyle(element).getPropertyValue(name).trim() || '#888';
}

/** Whether the user prefers reduced motion. */
export function prefersReducedMotion() {
  return matchMedia('(prefers-reduced-motion: reduce)').matches;
}

/**
 * Calls `draw` at most once per screen refresh.
 * @param {() => void} draw
 * @returns {() => void}
 */
export function onceAFrame(draw) {
  let asked = false;
  return () => {
    if (!asked) {
      asked = true;
      requestAnimationFrame(() => {
        asked = false;
        draw();
      });
    }
  };
}

/**
 * Draws again whenever the size of the element changes, and when it becomes visible.
 * @param {Element} element
 * @param {() => void} draw
 */
export function watchSize(element, draw) {
  new ResizeObserver(draw).observe(element);
}
