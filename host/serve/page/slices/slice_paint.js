// Paints a slice on a canvas: image, contours, crosshair, letters.
import {letterFont, styleColor} from '../elements/canvas.js';
import {significant} from '../elements/numbers.js';
import {paintMarks} from './mark_paint.js';
import {insideOf} from './slice_fill.js';
import {boxAt, pixelAt, placedIn} from './slice_pixels.js';
import {SLAB_KINDS} from './slice_slab.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_pixels.js').Placed} Placed */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/** @typedef {'thick' | 'thin' | 'filled' | 'off'} Lines  Contours. */
/** @typedef {import('./slice_cuts.js').Cut} Cut */

/**
 * Where and how to paint.
 * @typedef {object} Paper
 * @property {HTMLCanvasElement} canvas
 * @property {CanvasRenderingContext2D} context
 * @property {Slice} slice
 * @property {Placed} place
 * @property {number} width     CSS pixels.
 * @property {number} height
 * @property {number} unit      Scale of text and lines.
 */

const CROSSHAIR_GAP = 6;    // Free space around the point, CSS pixels.
const LETTER_MARGIN = 4;
const LINE_WIDTH = {thick: 1.5, thin: 1, filled: 1};  // Contours, CSS pixels.
const EDGE_WIDTH = 1.25;    // Dark edge on either side of a thick contour.
const TINT = 0.35;           // Opacity of filled contours.
const CUT_DASH = [6, 4];    // Line where a clip plane cuts, CSS pixels.
const CUT_TICK = 5;         // Short lines on its kept side, and the distance between them.
const CUT_TICK_EVERY = 20;

/**
 * Paints evenly spaced pixels at once, uneven rows or columns one by one with their widths. At most
 * one side is uneven: only the slices of a scan are.
 * @param {Paper} paper
 * @param {HTMLCanvasElement} image
 * @param {boolean} smooth      Interpolates between pixels.
 */
function paintImage({context, slice, place}, image, smooth) {
  context.imageSmoothingEnabled = smooth;
  context.imageSmoothingQuality = 'high';
  if (!slice.places_mm?.[0] && !slice.places_mm?.[1]) {
    context.drawImage(image, place.left, place.top, place.width, place.height);
    return;
  }
  if (slice.places_mm[0]) {
    for (let x = 0; x < slice.width; ++x) {
      const left = boxAt(slice, place, x - 0.5, 0)[0], end = boxAt(slice, place, x + 0.5, 0)[0];
      context.drawImage(image, x, 0, 1, slice.height, left, place.top, end - left, place.height);
    }
    return;
  }
  for (let y = 0; y < slice.height; ++y) {
    const top = boxAt(slice, place, 0, y - 0.5)[1], end = boxAt(slice, place, 0, y + 0.5)[1];
    context.drawImage(image, 0, y, slice.width, 1, place.left, top, place.width, end - top);
  }
}

/**
 * Paints contours; thick ones with a dark edge, so that light contours stay visible on bone.
 * @param {Paper} paper
 * @param {'thick' | 'thin' | 'filled'} lines
 */
function paintContours({canvas, context, slice, place, unit}, lines) {
  context.lineCap = 'round';
  if (lines === 'filled' && !slice.oblique) {  // Its contours end at the border of the volume.
    slice.contours.forEach(contour => paintInside({context, slice, place}, contour));
  }
  const paths = slice.contours.map(({color, first, count}) => {
    const path = new Path2D();
    for (let i = 4 * first; i < 4 * (first + count); i += 4) {
      const [x0, y0, x1, y1] = slice.segments.subarray(i, i + 4);
      path.moveTo(...boxAt(slice, place, x0, y0));
      path.lineTo(...boxAt(slice, place, x1, y1));
    }
    return {color, path};
  });
  if (lines === 'thick') {  // All edges first, so that no edge covers a line.
    context.strokeStyle = styleColor(canvas, '--over-edge');
    context.lineWidth = (LINE_WIDTH.thick + 2 * EDGE_WIDTH) * unit;
    paths.forEach(({path}) => context.stroke(path));
  }
  context.lineWidth = LINE_WIDTH[lines] * unit;
  for (const {color, path} of paths) {
    context.strokeStyle = color;
    context.stroke(path);
  }
}

/** Closed lines of the contours of shown slices. @type {WeakMap<object, number[][]>} */
const insides = new WeakMap();

/**
 * Tints the inside of a contour. An incomplete contour has no inside.
 * @param {Pick<Paper, 'context' | 'slice' | 'place'>} paper
 * @param {import('./slice_pixels.js').Contour} contour
 */
function paintInside({context, slice, place}, contour) {
  const {first, count, isovalue, color, left_out} = contour;
  if (left_out) {
    return;
  }
  const lines = insides.get(contour) ?? insideOf({width: slice.width, height: slice.height,
    segments: slice.segments.subarray(4 * first, 4 * (first + count)),
    isInside: slice.own[0] >= isovalue});
  insides.set(contour, lines);
  const path = new Path2D();
  for (const line of lines) {
    for (let i = 0; i < line.length; i += 2) {
      const at = boxAt(slice, place, line[i], line[i + 1]);
      i === 0 ? path.moveTo(...at) : path.lineTo(...at);
    }
    path.closePath();
  }
  context.globalAlpha = TINT;
  context.fillStyle = color;
  context.fill(path, 'evenodd');
  context.globalAlpha = 1;
}

/**
 * Paints where planes cut the slice: dashed, with short lines on the kept side.
 * @param {Paper} paper
 * @param {Cut[]} cuts
 */
function paintCuts({canvas, context, place, unit}, cuts) {
  const box = (/** @type {[number, number]} */ [u, v]) => [
    place.left + (u - place.first[0]) * place.scale,
    place.top + (v - place.first[1]) * place.scale];
  const lines = new Path2D(), ticks = new Path2D();
  for (const {from, to, kept} of cuts) {
    const [[x0, y0], [x1, y1]] = [box(from), box(to)];
    lines.moveTo(x0, y0);
    lines.lineTo(x1, y1);
    const length = Math.hypot(x1 - x0, y1 - y0), step = CUT_TICK_EVERY * unit;
    for (let at = step / 2; kept && at < length; at += step) {
      const x = x0 + (x1 - x0) * at / length, y = y0 + (y1 - y0) * at / length;
      ticks.moveTo(x, y);
      ticks.lineTo(x + kept[0] * CUT_TICK * unit, y + kept[1] * CUT_TICK * unit);
    }
  }
  for (const [style, width] of /** @type {const} */ ([
    [styleColor(canvas, '--over-edge'), 3], [styleColor(canvas, '--over-ink'), 1]])) {
    context.strokeStyle = style;
    context.lineWidth = width * unit;
    context.setLineDash(CUT_DASH.map(each => each * unit));
    context.stroke(lines);
    context.setLineDash([]);
    context.stroke(ticks);
  }
}

/**
 * @param {Paper} paper
 * @param {Vector} size     Size of the volume, voxels.
 * @param {Vector} voxel
 */
function paintCrosshair({canvas, context, slice, place, unit}, size, voxel) {
  const [x, y] = boxAt(slice, place, ...pixelAt(slice, size, voxel));
  const right = place.left + place.width, bottom = place.top + place.height;
  context.lineWidth = unit;
  context.strokeStyle = styleColor(canvas, '--over-accent');
  context.beginPath();
  context.moveTo(place.left, y);
  context.lineTo(x - CROSSHAIR_GAP, y);
  context.moveTo(x + CROSSHAIR_GAP, y);
  context.lineTo(right, y);
  context.moveTo(x, place.top);
  context.lineTo(x, y - CROSSHAIR_GAP);
  context.moveTo(x, y + CROSSHAIR_GAP);
  context.lineTo(x, bottom);
  context.stroke();
}

/**
 * Paints the letters of the patient's sides, at the top left the zoom, and at the bottom left the
 * slab, if any.
 * @param {Paper} paper
 * @param {number} times    1: not zoomed.
 */
function paintLetters({canvas, context, slice: {letters, slab}, width, height, unit}, times) {
  context.font = letterFont(unit);
  context.textBaseline = 'middle';
  context.lineWidth = 3 * unit;
  context.strokeStyle = styleColor(canvas, '--over-edge');
  context.fillStyle = styleColor(canvas, '--over-ink');
  const upper = LETTER_MARGIN + 6 * unit;
  /** @type {[string, number, number, CanvasTextAlign][]} */
  const places = [[letters.left, LETTER_MARGIN, height / 2, 'left'],
    [letters.right, width - LETTER_MARGIN, height / 2, 'right'],
    [letters.top, width / 2, upper, 'center'],
    [letters.bottom, width / 2, height - upper, 'center']];
  if (times > 1) {
    places.push([`${significant(times, 2)} ×`, LETTER_MARGIN, upper, 'left']);
  }
  if (slab) {
    places.push([`${SLAB_KINDS[slab.kind]} ${significant(slab.thickness_mm, 4)} mm`,
      LETTER_MARGIN, height - upper, 'left']);
  }
  for (const [letter, x, y, align] of places) {
    context.textAlign = align;
    context.strokeText(letter, x, y);
    context.fillText(letter, x, y);
  }
}

/**
 * What a view shows.
 * @typedef {object} Shown
 * @property {boolean} isOld                The slice is of another volume than the open one.
 * @property {HTMLCanvasElement} canvas     On the screen, for colors of the style sheet.
 * @property {string} plane
 * @property {Slice} slice
 * @property {Vector} size                  Of the volume, voxels.
 * @property {HTMLCanvasElement} image      The values as colors, a pixel each.
 * @property {import('./slice_view.js').Look} look
 * @property {import('./slice_zoom.js').Zoom} zoom
 * @property {Vector | null} crosshair
 * @property {import('./slice_measure.js').Mark[]} marks
 * @property {Cut[]} cuts                   Where planes cut it.
 */

/**
 * Paints a slice as a view shows it.
 * @param {Shown} shown
 * @param {Pick<Paper, 'context' | 'width' | 'height' | 'unit'>} where  In units of the context.
 * @param {boolean} hasMarks  With crosshair, measurements and letters.
 * @returns {ReturnType<typeof paintMarks>}  Where the labels of the measurements are.
 */
export function paintSlice(shown, where, hasMarks) {
  const {canvas, slice, size, image, look, zoom, crosshair, marks, cuts} = shown;
  const paper = {canvas, slice, place: placedIn(slice, where.width, where.height, zoom), ...where};
  paintImage(paper, image, look.smooth);
  if (look.lines !== 'off') {
    paintContours(paper, look.lines);
  }
  if (!hasMarks) {
    return new Map();
  }
  paintCuts(paper, cuts);
  if (crosshair) {
    paintCrosshair(paper, size, crosshair);
  }
  const labels = paintMarks(paper, size, marks);
  paintLetters(paper, zoom.times);
  return labels;
}
