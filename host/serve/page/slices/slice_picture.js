// A slice as a picture for a file.
import {areAlike, contextOf, unitOf} from '../elements/canvas.js';
import {h} from '../elements/dom.js';
import {significant} from '../elements/numbers.js';
import {say} from '../texts/say.js';
import {paintSlice} from './slice_paint.js';
import {SLAB_KINDS} from './slice_slab.js';
import {placeText} from './slice_words.js';

/** A picture of another shape is painted as in a view whose shorter side is as long, CSS pixels. */
const LEAST_SIDE = 500;

/**
 * Pixels of the screen; null if no slice is shown.
 * @param {import('./slice_paint.js').Shown | null} shown
 */
export function shownSize(shown) {
  return shown && shown.canvas.clientWidth > 0 ? [shown.canvas.width, shown.canvas.height] : null;
}

/** @param {import('./slice_paint.js').Shown} shown */
function captionOf({plane, slice: {index, axes, slab}, size}) {
  const place = placeText(plane, index + 1, size[axes[2]]);
  return slab ? say`${place}, ${SLAB_KINDS[slab.kind]} of ${significant(slab.thickness_mm, 4)} mm`
    : place;
}

/**
 * The slice as it is shown, in another size. Text and lines grow with the size.
 * @param {import('./slice_paint.js').Shown | null} shown
 * @param {import('../panel/views.js').Painting} painting
 * @returns {import('../panel/views.js').Painted}
 * @throws {Error} if no slice is shown any more
 */
export function pictureOf(shown, {size: [width, height], ground, marks}) {
  if (!shown) {
    throw new Error(say`The slice is not shown any more. Open a volume, and show the slices.`);
  }
  if (shown.isOld) {
    throw new Error(say`The slice is still that of another volume. Try again when it has
      changed.`);
  }
  const canvas = h('canvas', {width, height}), context = contextOf(canvas);
  const {clientWidth: across, clientHeight: down} = shown.canvas;
  const scale = areAlike([width, height], [across, down]) ? width / across
    : Math.min(width, height) / Math.max(Math.min(across, down), LEAST_SIDE);
  if (ground !== 'transparent') {
    context.fillStyle = ground || getComputedStyle(shown.canvas).backgroundColor;
    context.fillRect(0, 0, width, height);
  }
  context.setTransform(scale, 0, 0, scale, 0, 0);
  paintSlice(shown, {context, width: width / scale, height: height / scale,
    unit: unitOf(shown.canvas)}, marks);
  return {canvas, scale, caption: captionOf(shown), hasSurfaces: shown.look.lines !== 'off'};
}
