// Paints measurements on a slice.
import {letterFont, letterSize, styleColor} from '../elements/canvas.js';
import {labelsOf} from '../panel/labels.js';
import {isOn} from './slice_ends.js';
import {boxAt, pixelAt} from './slice_pixels.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_measure.js').Mark} Mark */
/** @typedef {import('./slice_paint.js').Paper} Paper */
/** @typedef {import('../panel/labels.js').Label} Label */
/** @typedef {import('../panel/labels.js').Place} Place */

const END_RADIUS = 2.5;     // CSS pixels.

/**
 * Paints the measurements that lie in the slice. Returns the boxes of their labels by name.
 * @param {Paper} paper
 * @param {Vector} size     Size of the volume, voxels.
 * @param {Mark[]} all
 * @returns {Map<string, import('../panel/labels.js').Box>}
 */
export function paintMarks({canvas, context, slice, place, width, height, unit}, size, all) {
  const marks = all.filter(mark => isOn(slice, mark));
  const drawn = marks.map(({kind, voxels, text}) => ({kind, text,
    places: voxels.map(voxel => boxAt(slice, place, ...pixelAt(slice, size, voxel)))}));
  const color = styleColor(canvas, '--over-warn'), edge = styleColor(canvas, '--over-edge');
  context.textAlign = 'center';
  context.textBaseline = 'alphabetic';
  context.font = letterFont(unit);
  context.lineCap = 'round';
  context.lineJoin = 'round';
  const labels = labelsOf(drawn, {left: 0, top: 0, width, height}, letterSize(unit),
    text => context.measureText(text).width);
  drawn.forEach(({kind, places}, index) => {
    const path = pathOf(kind, places, labels[index]);
    for (const [style, line] of /** @type {const} */ ([[edge, 4], [color, 1.5]])) {
      context.strokeStyle = style;
      context.lineWidth = line * unit;
      context.stroke(path);
    }
  });
  context.strokeStyle = edge;
  context.lineWidth = 3 * unit;
  context.fillStyle = styleColor(canvas, '--over-ink');
  for (const {text, x, y} of labels.flatMap(label => label?.lines ?? [])) {
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }
  return new Map(marks.flatMap(({name = ''}, k) => {
    const box = labels[k]?.box;
    return box ? [[name, box]] : [];
  }));
}

/**
 * @param {import('../panel/measures.js').Kind} kind
 * @param {Place[]} places
 * @param {Label | null} label
 */
function pathOf(kind, places, label) {
  const path = new Path2D();
  const [[x0, y0], [x1, y1] = [x0, y0]] = places;
  if (kind === 'ellipse') {
    path.ellipse((x0 + x1) / 2, (y0 + y1) / 2, Math.abs(x1 - x0) / 2, Math.abs(y1 - y0) / 2, 0, 0,
      2 * Math.PI);
  } else if (kind === 'rectangle') {
    path.rect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
  } else {
    // The point of a note is the tip of its arrow.
    for (const line of [places, ...label?.arrow ?? []]) {
      line.forEach(([x, y], k) => k === 0 ? path.moveTo(x, y) : path.lineTo(x, y));
    }
    for (const [x, y] of label?.arrow.length ? [] : places) {
      path.moveTo(x + END_RADIUS, y);
      path.arc(x, y, END_RADIUS, 0, 2 * Math.PI);
    }
  }
  return path;
}
