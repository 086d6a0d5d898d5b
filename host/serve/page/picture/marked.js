// A saved picture with the marks that are on the screen.
import {areAlike, pngOf} from '../elements/canvas.js';
import {paintLegend} from '../elements/legend.js';
import {withTexts} from './png_text.js';
import {paintSvg} from './svg_paint.js';

/** @typedef {import('../link/types.js').LegendLine} LegendLine */
/**
 * What is painted over a picture.
 * @typedef {object} Wish
 * @property {number[]} eye            Size of one eye's picture, pixels.
 * @property {boolean | null} isLight  Whether the ground is light; null: as on the screen.
 * @property {boolean} marks
 * @property {LegendLine[]} legend
 */

/**
 * The picture of a file with the marks that are on the screen.
 * @param {Blob} file  A PNG. Its texts stay.
 * @param {Wish} wish
 * @param {import('./picture.js').PictureView} view
 * @param {HTMLCanvasElement} shown  With the picture on the screen.
 * @param {number[]} pixels          Size of the picture at rest, both eyes.
 * @returns {Promise<Blob>}
 * @throws {Error} if the browser cannot write so large a picture
 */
export async function marked(file, wish, view, shown, pixels) {
  const picture = await createImageBitmap(file);
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [picture.width, picture.height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  context.drawImage(picture, 0, 0);
  picture.close();
  const paint = () => paintMarks(context, wish, view, shown);
  const wasLight = view.overlay.classList.contains('on-light');
  view.overlay.classList.toggle('on-light', wish.isLight ?? wasLight);
  try {
    // Marks of another shape have other places, and those of a hidden picture have none.
    if (!view.stage.hidden && areAlike(pixels, [canvas.width, canvas.height])) {
      paint();
    } else {
      view.layOutAs(wish.eye, paint);
    }
  } finally {
    view.overlay.classList.toggle('on-light', wasLight);
  }
  return withTexts(await pngOf(canvas), file);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Wish} wish
 * @param {import('./picture.js').PictureView} view
 * @param {HTMLCanvasElement} shown
 */
function paintMarks(context, {marks, legend}, {stage, overlay, width}, shown) {
  const scale = context.canvas.width / (width || 1);
  if (marks) {
    // Browsers show a canvas at whole pixels.
    const {left, top} = shown.getBoundingClientRect();
    const origin = {left: Math.round(left), top: Math.round(top)};
    for (const svg of stage.querySelectorAll('svg')) {
      paintSvg(context, svg, origin, scale);
    }
  }
  paintLegend(context, overlay, legend, scale);
}
