// Shortcuts that work unless a field or a handle uses the key.
import {SIDES} from '../picture/projection.js';
import {LAYOUT_KEYS, SIDE_KEYS} from './view_tools.js';

/** @typedef {import('../panel/app.js').App} App */

const TURN_RAD = 5 * Math.PI / 180;
const PAN_PX = 20;
const ZOOM = 1.1;

/**
 * @typedef {object} Actions
 * @property {() => void} undo
 * @property {() => void} redo
 * @property {() => void} open
 * @property {() => void} save
 * @property {() => void} help
 * @property {() => void} fullScreen
 * @property {() => void} tour
 * @property {() => void} leave        Closes the tour.
 */

/**
 * @param {App} app
 * @param {import('../picture/viewpoint.js').Viewpoint} viewpoint
 * @param {Actions} actions
 */
export function watchKeys(app, viewpoint, actions) {
  document.addEventListener('keydown', event => {
    const target = event.target instanceof Element ? event.target : document.body;
    const isTaken = target.closest('input:not([type=range], [type=checkbox], [type=color]), '
      + 'select, textarea, dialog[open], [role=slider]') !== null;
    const hasCommand = event.ctrlKey || event.metaKey;
    if (isTaken && !(hasCommand && target.closest('[role=slider]')) || event.altKey) {
      return;
    }
    const act = hasCommand ? withCommand(event, actions) : plainKey(event, target, app, viewpoint,
      actions);
    if (act) {
      event.preventDefault();
      act();
    }
  });
}

/**
 * @param {KeyboardEvent} event
 * @param {Actions} actions
 * @returns {(() => void) | undefined}
 */
function withCommand(event, actions) {
  const key = event.key.toLowerCase();
  if (key === 'z') {
    return event.shiftKey ? actions.redo : actions.undo;
  }
  return key === 'y' ? actions.redo : undefined;
}

/**
 * @param {KeyboardEvent} event
 * @param {Element} target
 * @param {App} app
 * @param {import('../picture/viewpoint.js').Viewpoint} viewpoint
 * @param {Actions} actions
 * @returns {(() => void) | undefined}
 */
function plainKey(event, target, app, viewpoint, actions) {
  const arrow = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]], ['ArrowUp', [0, -1]],
    ['ArrowDown', [0, 1]]]).get(event.key);
  if (arrow) {
    // Arrows elsewhere scroll a panel or move a control.
    const isFree = target === document.body || target === app.picture.stage;
    return isFree ? () => step(viewpoint, arrow[0], arrow[1], event.shiftKey) : undefined;
  }
  const side = SIDES[Number(event.key) - 1];
  if (side && event.key.length === 1) {
    return () => viewpoint.named(side.view);
  }
  const name = LAYOUT_KEYS.get(event.key), shut = SIDE_KEYS.get(event.key);
  if (name || shut) {
    return () => name ? app.layout.change({name}) : shut && app.layout.toggle(shut);
  }
  const zoom = (/** @type {number} */ factor) => {
    viewpoint.begin();
    viewpoint.zoom(factor);
  };
  return new Map(/** @type {[string, () => void][]} */ ([
    ['+', () => zoom(ZOOM)], ['=', () => zoom(ZOOM)], ['-', () => zoom(1 / ZOOM)],
    ['r', () => viewpoint.reset()], ['u', actions.undo], ['U', actions.redo], ['o', actions.open],
    ['s', actions.save], ['t', actions.tour], ['?', actions.help], ['f', actions.fullScreen],
    ['Escape', () => app.modes.current ? app.modes.leave() : actions.leave()],
  ])).get(event.key);
}

/**
 * @param {import('../picture/viewpoint.js').Viewpoint} viewpoint
 * @param {number} right
 * @param {number} down
 * @param {boolean} isPan
 */
function step(viewpoint, right, down, isPan) {
  viewpoint.begin();
  if (isPan) {
    viewpoint.pan(right * PAN_PX, down * PAN_PX);
  } else {
    viewpoint.turn([down !== 0 ? 1 : 0, right !== 0 ? 1 : 0, 0], (right + down) * TURN_RAD);
  }
}
