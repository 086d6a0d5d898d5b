// A saved picture with the marks that are on the screen.
import {withTexts} from './png_text.js';
import {paintLegend, paintSvg} from './svg_paint.js';

/** @typedef {import('../link/types.js').LegendLine} LegendLine */

/**
 * A picture of the same proportions with the marks that are on the screen.
 * @param {Blob} file  A PNG. Its texts stay.
 * @param {{marks: boolean, legend: LegendLine[]}} wish
 * @param {{stage: HTMLElement, overlay: SVGSVGElement, width: number}} view
 * @param {HTMLCanvasElement} shown  With the picture on the screen.
 * @returns {Promise<Blob>}
 * @throws {Error} if the browser cannot write so large a picture
 */
export async function marked(file, {marks, legend}, {stage, overlay, width}, shown) {
  const picture = await createImageBitmap(file);
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [picture.width, picture.height];
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
  context.drawImage(picture, 0, 0);
  picture.close();
  const scale = canvas.width / (width || 1);
  if (marks) {
    // Browsers show a canvas at whole pixels.
    const {left, top} = shown.getBoundingClientRect();
    const origin = {left: Math.round(left), top: Math.round(top)};
    for (const svg of stage.querySelectorAll('svg')) {
      paintSvg(context, svg, origin, scale);
    }
  }
  paintLegend(context, overlay, legend, scale);
  const written = await new Promise(take => canvas.toBlob(take));
  if (!written) {
    throw new Error(`The browser cannot write a picture of ${canvas.width} x ${canvas.height} `
      + 'pixels. Choose a smaller size.');
  }
  return withTexts(written, file);
}
