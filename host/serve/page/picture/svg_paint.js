// Paints the marks over the picture onto a canvas, as the screen shows them.

/**
 * Paints the visible paths, lines, circles, polygons and texts of a drawing.
 * @param {CanvasRenderingContext2D} context
 * @param {SVGSVGElement} svg
 * @param {{left: number, top: number}} origin  The canvas's upper left corner, CSS pixels.
 * @param {number} scale                        Canvas pixels per CSS pixel.
 */
export function paintSvg(context, svg, origin, scale) {
  for (const element of svg.querySelectorAll('path, line, circle, polygon, text')) {
    const shape = /** @type {SVGGraphicsElement} */ (element);
    const style = getComputedStyle(shape), at = shape.getScreenCTM();
    if (style.visibility === 'hidden' || style.display === 'none' || !at) {
      continue;
    }
    context.setTransform(scale * at.a, scale * at.b, scale * at.c, scale * at.d,
      scale * (at.e - origin.left), scale * (at.f - origin.top));
    paintShape(context, shape, style);
  }
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalAlpha = 1;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {SVGGraphicsElement} shape
 * @param {CSSStyleDeclaration} style
 */
function paintShape(context, shape, style) {
  const text = shape instanceof SVGTextElement ? shape : null;
  if (text?.getNumberOfChars() === 0) {
    return;
  }
  const place = text?.getStartPositionOfChar(0) ?? {x: 0, y: 0};
  const words = text?.textContent ?? '';
  const path = text ? null : outlineOf(shape);
  const fill = () => {
    context.globalAlpha = Number(style.fillOpacity);
    context.fillStyle = style.fill;
    if (path) {
      context.fill(path);
    } else {
      context.fillText(words, place.x, place.y);
    }
  };
  const stroke = () => {
    context.globalAlpha = Number(style.strokeOpacity);
    context.strokeStyle = style.stroke;
    context.lineWidth = parseFloat(style.strokeWidth);
    context.lineCap = /** @type {CanvasLineCap} */ (style.strokeLinecap);
    context.lineJoin = /** @type {CanvasLineJoin} */ (style.strokeLinejoin);
    context.miterLimit = Number(style.strokeMiterlimit);
    if (path) {
      context.stroke(path);
    } else {
      context.strokeText(words, place.x, place.y);
    }
  };
  context.font = `${style.fontStyle} ${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
  const steps = [style.fill !== 'none' && fill, style.stroke !== 'none' && stroke];
  for (const step of style.paintOrder.startsWith('stroke') ? steps.reverse() : steps) {
    if (step) {
      step();
    }
  }
}

/** @param {SVGGraphicsElement} shape */
function outlineOf(shape) {
  const number = (/** @type {string} */ name) => Number(shape.getAttribute(name));
  if (shape instanceof SVGCircleElement) {
    const path = new Path2D();
    path.arc(number('cx'), number('cy'), number('r'), 0, 2 * Math.PI);
    return path;
  }
  if (shape instanceof SVGLineElement) {
    return new Path2D(`M${number('x1')} ${number('y1')}L${number('x2')} ${number('y2')}`);
  }
  return new Path2D(shape instanceof SVGPolygonElement ? `M${shape.getAttribute('points')}Z`
    : shape.getAttribute('d') ?? '');
}
