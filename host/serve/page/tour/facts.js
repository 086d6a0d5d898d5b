// The facts of the tour's steps: answers of the machine about one pixel of the scene.
import {LIMITS} from '../link/vocabulary.js';
import {depthOf} from './tree.js';

/** @typedef {import('../link/vocabulary.js').State} State */
/** @typedef {import('../inspect/why_cards.js').Why} Why */
/** @typedef {import('../inspect/stream_view.js').Scrub} Scrub */
/** @typedef {import('../machine/ring_flow.js').MachineReport} MachineReport */
/** @typedef {import('../machine/model_view.js').Modelled} Modelled */

const EDGE = LIMITS.region_px;

/**
 * @typedef {object} Facts              A field is null until the machine has answered.
 * @property {State} state
 * @property {Why | null} why
 * @property {Scrub | null} stream
 * @property {MachineReport | null} report  The newest; for a driver, one with pixels of the
 *                                      Renderer that drew the pixel's region.
 * @property {MachineReport['frame'] | null} frame  The last one.
 * @property {Modelled | null} modelled
 * @property {boolean} watches
 */

/** @param {Facts} facts */
export function shownOf({why}) {
  return why?.shown === undefined ? null : why.visits[why.shown];
}

/** @param {Facts} facts */
export function cellOf(facts) {
  const cell = shownOf(facts)?.cell;
  return cell?.values && !cell.unknown ? cell : null;
}

/**
 * The pixel's place in its region.
 * @param {Why} why
 */
function placeOf({x, y}) {
  return {x: x % EDGE, y: y % EDGE};
}

/**
 * How the triangle's depth at the pixel came about, and the place of the pixel in its region.
 * @param {Facts} facts
 */
export function evaluationOf(facts) {
  const shown = shownOf(facts);
  if (!facts.why || !shown) {
    return null;
  }
  const place = placeOf(facts.why), depth = depthOf(shown, place);
  return depth && {...depth, ...place};
}

/**
 * Triangles of the visible surfaces.
 * @param {State} state
 */
export function triangleCount({surfaces}) {
  return surfaces.reduce((sum, {visible, triangles}) => sum + (visible ? triangles : 0), 0);
}

/**
 * Columns and rows of regions of one view.
 * @param {State} state
 */
export function regionsOf({size}) {
  return size.map(pixels => Math.ceil(pixels / EDGE));
}

/**
 * The finished regions that a Renderer, or all of them, sent to the frame buffer.
 * @param {MachineReport} report
 * @param {number | null} renderer  null: all.
 */
export function sentPixels({nodes}, renderer) {
  const sent = nodes.filter(({name, role}) => renderer === null ? role === 'renderer'
    : name === `renderer-${renderer}`).flatMap(node => node.sent)
    .filter(({kind}) => kind === 'RegionPixels');
  return {
    messages: sent.reduce((sum, each) => sum + each.messages, 0),
    bytes: sent.reduce((sum, each) => sum + each.bytes, 0),
    to: [...new Set(sent.map(each => each.to))],
  };
}
