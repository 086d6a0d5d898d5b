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
 * Draws a frame as it is. The canvas gets the size of the picture.
 * @param {CanvasRenderingContext2D} context
 * @param {import('../link/types.js').FrameHeader} header
 * @param {string} mode  Of stereo.
 * @param {ImageBitmap} bitmap
 */
export function paintFrame(context, {width, height, views, layers, opacity}, mode, bitmap) {
  const {canvas} = context;
  if (views === 2) {
    drawPair(context, bitmap, mode);
    return;
  }
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  context.drawImage(bitmap, 0, 0);
  if (layers > 1) {
    context.globalAlpha = opacity / LIMITS.full_opacity;
    context.drawImage(bitmap, 0, -height);
    context.globalAlpha = 1;
  }
}
