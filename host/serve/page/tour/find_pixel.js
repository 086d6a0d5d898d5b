// A pixel that shows a surface, near the middle of the picture.
import {byId} from '../elements/dom.js';

const STEPS_ACROSS = 24;        // Of the grid of candidates, along the shorter side.
const UNLIKE = 24;              // A color that differs by less may be that of the background.
const MOST_ASKED = 12;

/** @typedef {{x: number, y: number}} Pixel */

/**
 * Places on the displayed picture that do not have the background's color, the middle first.
 * @param {ImageData} image
 * @param {number[]} background  Red, green, blue.
 */
export function candidates({width, height, data}, background) {
  const step = Math.max(1, Math.floor(Math.min(width, height) / STEPS_ACROSS));
  const [middleX, middleY] = [Math.floor(width / 2), Math.floor(height / 2)];
  /** @type {(Pixel & {away: number})[]} */
  const found = [];
  for (let y = middleY % step; y < height; y += step) {
    for (let x = middleX % step; x < width; x += step) {
      const at = 4 * (y * width + x);
      if (background.some((part, k) => Math.abs(part - data[at + k]) >= UNLIKE)) {
        found.push({x, y, away: Math.hypot(x - middleX, y - middleY)});
      }
    }
  }
  return found.sort((a, b) => a.away - b.away || a.y - b.y || a.x - b.x);
}

/**
 * A pixel of the picture where the machine finds a surface; the same one for the same picture.
 * @param {import('../panel/app.js').App} app
 * @returns {Promise<Pixel | null>} null if no candidate has a surface
 */
export async function findPixel({picture, store, connection}) {
  const canvas = /** @type {HTMLCanvasElement} */ (byId('frame'));
  const image = canvas.getContext('2d')?.getImageData(0, 0, canvas.width, canvas.height);
  if (!image || !store.state) {
    return null;
  }
  const {background} = store.state;
  const ground = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16));
  for (const {x, y} of candidates(image, ground).slice(0, MOST_ASKED)) {
    const pixel = picture.pixelOf({x: (x + 0.5) / image.width, y: (y + 0.5) / image.height});
    const reply = await connection.do(`pick ${pixel.x} ${pixel.y}`, {quiet: true});
    if (reply.ok && reply.result?.hit && !reply.result.slice) {
      return pixel;
    }
  }
  return null;
}
