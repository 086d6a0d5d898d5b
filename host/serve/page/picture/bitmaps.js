// Frames as bitmaps, and on the canvas.
import {LIMITS} from '../link/vocabulary.js';
import {drawPair} from './compose.js';

/** @param {import('../link/connection.js').Frame} frame  A JPEG or PNG. */
export function bitmapOfFile({header, picture}) {
  const type = header.kind === 'png' ? 'image/png' : 'image/jpeg';
  return createImageBitmap(new Blob([/** @type {any} */ (picture)], {type}));
}

/** @param {VideoFrame | null} picture  Is closed. */
export async function bitmapOf(picture) {
  try {
    return picture && await createImageBitmap(picture);
  } finally {
    picture?.close();
  }
}

/**
 * The opacities of the layers of a picture, the layer behind first.
 * @param {{layers: number, opacity: number}} header  Opacity in sixteenths.
 */
export function opacitiesOf({layers, opacity}) {
  return layers > 1 ? [1, opacity / LIMITS.full_opacity] : [1];
}

/**
 * Draws a frame as it is. The canvas gets the size of the picture.
 * @param {CanvasRenderingContext2D} context
 * @param {import('../link/types.js').FrameHeader} header
 * @param {string} mode  Of stereo.
 * @param {ImageBitmap} bitmap
 */
export function paintFrame(context, header, mode, bitmap) {
  const {width, height, views} = header, {canvas} = context;
  if (views === 2) {
    drawPair(context, bitmap, mode);
    return;
  }
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  opacitiesOf(header).forEach((opacity, layer) => {
    context.globalAlpha = opacity;
    context.drawImage(bitmap, 0, -layer * height);
  });
  context.globalAlpha = 1;
}
