// The legend of a saved picture.

const LINE_EM = 1.45, SQUARE_EM = 0.7;

/**
 * A text in lines that are at most `most` wide. A longer word has a line of its own.
 * @param {string} text
 * @param {(text: string) => number} widthOf
 * @param {number} most
 */
export function wrapped(text, widthOf, most) {
  /** @type {string[]} */
  const lines = [];
  for (const word of text.split(' ')) {
    const longer = lines.length > 0 ? `${lines.at(-1)} ${word}` : word;
    if (lines.length > 0 && widthOf(longer) <= most) {
      lines[lines.length - 1] = longer;
    } else {
      lines.push(word);
    }
  }
  return lines;
}

/**
 * Writes lines into the upper left corner, in the style of the scale bar's text. Long lines wrap.
 * @param {CanvasRenderingContext2D} context
 * @param {SVGSVGElement} overlay  Over the picture, with the scale bar.
 * @param {{color: string, text: string}[]} legend  color: of the square, '' for none.
 * @param {number} scale
 */
export function paintLegend(context, overlay, legend, scale) {
  const text = overlay.querySelector('.scale-text');
  if (!text) {
    return;
  }
  const style = getComputedStyle(text), size = parseFloat(style.fontSize);
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.font = `${style.fontSize} ${style.fontFamily}`;
  [context.lineWidth, context.lineJoin] = [3, 'round'];
  [context.strokeStyle, context.fillStyle] = [style.stroke, style.fill];
  const width = context.canvas.width / scale;
  let bottom = size * 1.4;
  for (const {color, text: words} of legend) {
    const left = size * (color ? 1.9 : 0.9);
    if (color) {
      const square = /** @type {const} */ ([size * 0.9, bottom - size * SQUARE_EM,
        size * SQUARE_EM, size * SQUARE_EM]);
      context.strokeRect(...square);
      context.fillStyle = color;
      context.fillRect(...square);
      context.fillStyle = style.fill;
    }
    const widthOf = (/** @type {string} */ part) => context.measureText(part).width;
    for (const line of wrapped(words, widthOf, width - left - size)) {
      context.strokeText(line, left, bottom);
      context.fillText(line, left, bottom);
      bottom += size * LINE_EM;
    }
  }
  context.setTransform(1, 0, 0, 1, 0, 0);
}
