// Frames as bitmaps, and on the canvas.
import {LIMITS} from '../link/vocabulary.js';
import {drawPair} from './compose.js';

/** @typedef {import('./compose.js').Bitmap} Bitmap */

/** Whether WebCodecs decodes JPEG: only in secure contexts, and not after a failure. */
let hasDecoder = 'ImageDecoder' in globalThis;

/**
 * Decodes a frame. A browser reads a blob through another process, which takes longer than decoding
 * a moving picture. So WebCodecs decodes JPEG, if the browser can.
 * @param {import('../link/connection.js').Frame} frame  A JPEG or PNG.
 * @returns {Promise<Bitmap>}
 */
export async function bitmapOfFile({header, picture}) {
  const type = header.kind === 'png' ? 'image/png' : 'image/jpeg';
  const data = /** @type {any} */ (picture);
  if (header.kind !== 'png' && hasDecoder) {
    try {
      return await decoded(type, data);
    } catch {
      const bitmap = await bitmapOfBlob(type, data);
      hasDecoder = false;  // The picture is intact.
      return bitmap;
    }
  }
  return bitmapOfBlob(type, data);
}

/** @param {string} type @param {any} data */
function bitmapOfBlob(type, data) {
  return createImageBitmap(new Blob([data], {type}));
}

/** @param {string} type @param {any} data */
async function decoded(type, data) {
  const decoder = new ImageDecoder({type, data});
  try {
    return (await decoder.decode()).image;
  } finally {
    decoder.close();
  }
}

/**
 * A frame as a bitmap, which the caller closes. A picture that is drawn in parts is no VideoFrame:
 * each drawing would convert all of it.
 * @param {import('../link/connection.js').Frame} frame
 * @param {Promise<VideoFrame | null> | null} video  The picture of a video frame.
 * @returns {Promise<Bitmap | null>}
 */
export async function bitmapOf(frame, video) {
  const {kind, layers, views} = frame.header;
  const bitmap = kind === 'vp8' ? await video : await bitmapOfFile(frame);
  return bitmap && 'displayWidth' in bitmap && (layers > 1 || views > 1)
    ? createImageBitmap(bitmap).finally(() => bitmap.close()) : bitmap;
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
 * @param {Bitmap} bitmap
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
