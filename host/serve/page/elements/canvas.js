// Canvases that are sharp on every screen, and colours of the stylesheet to draw in them with.

const MAX_SCALE = 3;
const BASE_FONT_PX = 13;    // style.css, on small screens.

/**
 * A canvas's context, cleared, its picture as large as the element stands on the screen.
 * @param {HTMLCanvasElement} canvas
 * @returns {{context: CanvasRenderingContext2D, width: number, height: number, unit: number}}
 *     width and height in CSS pixels, to which the context is scaled; unit: how much larger than on
 *     small screens text and lines are to be, as the page's text is
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
  const unit = parseFloat(getComputedStyle(canvas).fontSize) / BASE_FONT_PX;
  return {context, width, height, unit};
}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
export function contextOf(canvas) {
  const context = canvas.getContext('2d');
  if (!context) {
    throw new Error('this browser has no 2D canvas');
  }
  return context;
}

/**
 * A custom property of the stylesheet as it holds at an element.
 * @param {Element} element
 * @param {string} name  '--...'
 */
export function styleColour(element, name) {
  return getComputedStyle(element).getPropertyValue(name).trim() || '#888';
}

/** Whether the person asked for less motion. */
export function wantsCalm() {
  return matchMedia('(prefers-reduced-motion: reduce)').matches;
}

/**
 * Calls `draw` once before the next picture of the screen, however often it is asked for.
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
 * Draws anew whenever the element's size changes, and when it comes into view.
 * @param {Element} element
 * @param {() => void} draw
 */
export function watchSize(element, draw) {
  new ResizeObserver(draw).observe(element);
}
