// Where the texts of measurements stand: beside their lines, and not over each other or over ends.
import {wrapped} from '../elements/legend.js';
import {isRegion} from './measures.js';

/** @typedef {import('./measures.js').Kind} Kind */
/** @typedef {[number, number]} Place */
/** @typedef {{left: number, top: number, width: number, height: number}} Box */
/**
 * A measurement on a slice or in the picture.
 * @typedef {object} Drawn
 * @property {Kind} kind
 * @property {Place[]} places   Of its points, CSS pixels.
 * @property {string} text      Empty as long as the user makes it.
 */

/**
 * A text, and the arrow of a note.
 * @typedef {object} Label
 * @property {Box} box
 * @property {{text: string, x: number, y: number}[]} lines  The middle of each baseline.
 * @property {Place[][]} arrow  Lines from the text to the point; none without an arrow.
 */

const LINE_EM = 1.25;       // Height of a line.
const BASE_EM = 0.95;       // Top of a line to its baseline.
const GAP = 5;              // Between a text and its line, CSS pixels.
const NOTE_GAP = 22;        // Length of an arrow.
const END = 6;              // Half a side of the square that a text leaves free around an end.
const MOST_IN_LINE = 26;    // Letters of a note.
const HEAD = 7;             // Length of an arrow's head.
const HEAD_RAD = 0.45;      // Between the head and the shaft.
/** Sides of the anchor, the usual one first. @type {Place[]} */
const SIDES = [[0, -1], [0, 1], [1, 0], [-1, 0], [1, -1], [-1, -1], [1, 1], [-1, 1]];
/** A note stands aside, so that its arrow is seen. @type {Place[]} */
const NOTE_SIDES = [[1, -1], [-1, -1], [1, 1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]];
const FAR = [1, 4.5, 8];    // Gaps that are tried.
const NOTE_FAR = [1, 2, 3];

/**
 * The labels of measurements, in order: each avoids the ends of all and the labels before it. The
 * place with the least overlap is taken if none is free.
 * @param {Drawn[]} drawn
 * @param {Box} bounds
 * @param {number} size     Of the letters, CSS pixels.
 * @param {(text: string) => number} widthOf
 * @returns {(Label | null)[]}  Null without a text.
 */
export function labelsOf(drawn, bounds, size, widthOf) {
  const taken = drawn.flatMap(({kind, places}) => isRegion(kind) ? [] : places).map(([x, y]) =>
    ({left: x - END, top: y - END, width: 2 * END, height: 2 * END}));
  return drawn.map(({kind, places, text}) => {
    if (text === '' || places.length === 0) {
      return null;
    }
    const words = kind === 'note' ? wrapped(text, part => part.length, MOST_IN_LINE) : [text];
    const width = Math.max(...words.map(widthOf)), height = words.length * size * LINE_EM;
    const anchor = anchorOf(kind, places);
    const box = freest(candidates(kind, anchor, width, height), taken, bounds);
    taken.push(box);
    const lines = words.map((each, k) => ({text: each, x: box.left + width / 2,
      y: box.top + (k * LINE_EM + BASE_EM) * size}));
    return {box, lines, arrow: kind === 'note' ? arrowTo(box, anchor) : []};
  });
}

/**
 * What a label belongs to: the upper edge of a region, the vertex of an angle, else the middle.
 * @param {Kind} kind
 * @param {Place[]} places
 * @returns {Place}
 */
function anchorOf(kind, places) {
  const half = kind === 'angle' ? 1 : (places.length - 1) / 2;
  const a = places[Math.floor(half)] ?? places[0], b = places[Math.ceil(half)] ?? places[0];
  return [(a[0] + b[0]) / 2, isRegion(kind) ? Math.min(a[1], b[1]) : (a[1] + b[1]) / 2];
}

/**
 * @param {Kind} kind
 * @param {Place} anchor
 * @param {number} width
 * @param {number} height
 * @returns {Box[]}
 */
function candidates(kind, [x, y], width, height) {
  const [gap, fars, sides] = kind === 'note' ? [NOTE_GAP, NOTE_FAR, NOTE_SIDES]
    : [GAP, FAR, SIDES];
  return fars.flatMap(far => sides.map(([across, down]) => ({
    left: x - width / 2 + across * (width / 2 + far * gap),
    top: y - height / 2 + down * (height / 2 + far * gap), width, height})));
}

/**
 * The first of the boxes that overlap least.
 * @param {Box[]} boxes
 * @param {Box[]} taken
 * @param {Box} bounds
 */
function freest(boxes, taken, bounds) {
  const inside = boxes.map(box => ({...box,
    left: within(box.left, bounds.left, bounds.left + bounds.width - box.width),
    top: within(box.top, bounds.top, bounds.top + bounds.height - box.height)}));
  const overlaps = inside.map(box => taken.reduce((sum, each) => sum + overlap(box, each), 0));
  return inside[overlaps.indexOf(Math.min(...overlaps))];
}

/**
 * @param {number} value
 * @param {number} least
 * @param {number} most  May be below `least`.
 */
function within(value, least, most) {
  return Math.max(Math.min(value, most), least);
}

/**
 * The area of the overlap.
 * @param {Box} a
 * @param {Box} b
 */
export function overlap(a, b) {
  const across = Math.min(a.left + a.width, b.left + b.width) - Math.max(a.left, b.left);
  const down = Math.min(a.top + a.height, b.top + b.height) - Math.max(a.top, b.top);
  return Math.max(across, 0) * Math.max(down, 0);
}

/**
 * The lines of an arrow from the nearest place of a box to a point.
 * @param {Box} box
 * @param {Place} tip
 * @returns {Place[][]}
 */
function arrowTo({left, top, width, height}, tip) {
  const from = /** @type {Place} */ ([within(tip[0], left, left + width),
    within(tip[1], top, top + height)]);
  const angle = Math.atan2(from[1] - tip[1], from[0] - tip[0]);
  const head = (/** @type {number} */ turn) => /** @type {Place} */ (
    [tip[0] + HEAD * Math.cos(angle + turn), tip[1] + HEAD * Math.sin(angle + turn)]);
  return [[from, tip], [head(HEAD_RAD), tip, head(-HEAD_RAD)]];
}
