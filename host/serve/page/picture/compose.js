// The exact pair as one picture on a 2D canvas, as composed() in host/scene/stereo.cpp makes it.
import {partsOf} from './stereo.js';

/**
 * A decoded frame. A VideoFrame is drawn as it is: a bitmap of 512 x 512 pixels takes 12 ms.
 * @typedef {ImageBitmap | VideoFrame} Bitmap
 */

/**
 * E. Dubois, "A projection method to generate anaglyph stereo images", ICASSP 2001, for red and
 * cyan filters: red, green and blue of the left picture, then of the right one. Linear light in,
 * linear light out; each line is one output.
 */
export const FILTER = [
  [0.4561, 0.500484, 0.176381, -0.0434706, -0.0879388, -0.00155529],
  [-0.0400822, -0.0378246, -0.0157589, 0.378476, 0.73364, -0.0184503],
  [-0.0152161, -0.0205971, -0.00546856, -0.0721527, -0.112961, 1.2264],
];
const SRGB_STEPS = 1 << 14;

/** Linear light of an sRGB byte. IEC 61966-2-1. */
const LIGHT = Float64Array.from({length: 256}, (_, byte) => {
  const value = byte / 255;
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
});
/** sRGB bytes of linear light in steps that are finer than those of dark bytes. */
const BYTE = Uint8Array.from({length: SRGB_STEPS + 1}, (_, step) => {
  const light = step / SRGB_STEPS;
  return Math.round(255 * (light <= 0.0031308 ? light * 12.92 : 1.055 * light ** (1 / 2.4)
    - 0.055));
});

/**
 * @param {Uint8ClampedArray} left   Red, green, blue, alpha; becomes the anaglyph.
 * @param {Uint8ClampedArray} right
 */
export function toAnaglyph(left, right) {
  for (let at = 0; at < left.length; at += 4) {
    const a = LIGHT[left[at]], b = LIGHT[left[at + 1]], c = LIGHT[left[at + 2]];
    const d = LIGHT[right[at]], e = LIGHT[right[at + 1]], f = LIGHT[right[at + 2]];
    for (let channel = 0; channel < 3; ++channel) {
      const m = FILTER[channel];
      // The host adds the light of the left eye and that of the right eye.
      const light = m[0] * a + m[1] * b + m[2] * c + (m[3] * d + m[4] * e + m[5] * f);
      left[at + channel] = BYTE[Math.round(Math.max(0, Math.min(1, light)) * SRGB_STEPS)];
    }
  }
}

/** @param {Bitmap} bitmap @returns {{width: number, height: number}} Pixels. */
export function sizeOf(bitmap) {
  return 'displayWidth' in bitmap ? {width: bitmap.displayWidth, height: bitmap.displayHeight}
    : bitmap;
}

/**
 * Draws a pair as one picture. The canvas gets the size of the picture.
 * @param {CanvasRenderingContext2D} context
 * @param {Bitmap} pair  The left eye's picture over the right eye's.
 * @param {string} mode       Of stereo.
 */
export function drawPair(context, pair, mode) {
  const {canvas} = context, {width, height: both} = sizeOf(pair), height = both / 2;
  const parts = partsOf(mode), across = width * parts.length;
  if (canvas.width !== across || canvas.height !== height) {
    canvas.width = across;
    canvas.height = height;
  }
  for (const {eyes, left} of parts) {
    context.drawImage(pair, 0, eyes[0] * height, width, height, left * across, 0, width, height);
  }
  if (mode === 'rows') {
    for (let y = 1; y < height; y += 2) {
      context.drawImage(pair, 0, height + y, width, 1, 0, y, width, 1);
    }
  } else if (mode === 'anaglyph') {
    const picture = context.getImageData(0, 0, width, height);
    context.drawImage(pair, 0, height, width, height, 0, 0, width, height);
    toAnaglyph(picture.data, context.getImageData(0, 0, width, height).data);
    context.putImageData(picture, 0, 0);
  }
}
