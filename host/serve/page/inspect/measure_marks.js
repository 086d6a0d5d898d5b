// Draws measurements over the picture.
import {contextOf, remPx, TYPE_REM} from '../elements/canvas.js';
import {h, s} from '../elements/dom.js';
import {labelsOf} from '../panel/labels.js';

/** @typedef {import('../panel/app.js').Eye} Eye */
/** @typedef {import('../panel/labels.js').Box} Box */
/** @typedef {import('../panel/labels.js').Drawn} Drawn */
/**
 * A measurement that an eye sees whole.
 * @typedef {Drawn & {name: string, isChosen: boolean}} Seen  The name is empty as long as the user
 *     makes it.
 */

/** @type {CanvasRenderingContext2D | null} */
let ruler = null;

/**
 * Measures texts of a size.
 * @param {number} size     CSS pixels.
 */
function rulerOf(size) {
  const context = ruler ??= contextOf(h('canvas'));
  context.font = `600 ${size}px ${getComputedStyle(document.body).fontFamily}`;
  return (/** @type {string} */ text) => context.measureText(text).width;
}

/**
 * Draws what an eye sees. Returns the boxes of the labels by name, too.
 * @param {Seen[]} seen
 * @param {Eye} eye
 * @param {number} height   Of the picture, places.
 */
export function drawMarks(seen, eye, height) {
  const size = TYPE_REM.small * remPx();  // panels.css
  const labels = labelsOf(seen, {left: eye.left, top: 0, width: eye.width, height}, size,
    rulerOf(size));
  /** @type {Map<string, Box>} */
  const boxes = new Map();
  const groups = seen.map(({places, text, name, isChosen}, k) => {
    const label = labels[k];
    if (label) {
      boxes.set(name, label.box);
    }
    const lines = [places, ...label?.arrow ?? []].flatMap(line => line.slice(1).map(([x, y], to) =>
      ({x1: line[to][0], y1: line[to][1], x2: x, y2: y})));
    const radius = isChosen ? 5 : text ? 3 : 4;
    // The point of a note is the tip of its arrow.
    const ends = label?.arrow.length && !isChosen ? [] : places;
    return s('g', {}, ...lines.map(each => s('line', {class: 'back', ...each})),
      ...lines.map(each => s('line', {class: 'front', ...each})),
      ...ends.map(([x, y]) => s('circle', {cx: x, cy: y, r: radius})),
      ...(label?.lines ?? []).map(({text: words, x, y}) => s('text', {x, y}, words)));
  });
  return {group: s('g', {class: `eye-${eye.name}`}, ...groups), boxes};
}
