// Separators between the picture and the sides: pointer, arrow keys, and a double click.
import {remPx} from '../elements/canvas.js';
import {byId, h, update} from '../elements/dom.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */

const STEP_REM = 1;
const FAST = 4;                 // With Shift.
const MOST_SHARE = {left: 0.4, right: 0.45, sheet: 0.75};  // Of the window.

/**
 * @typedef {object} What
 * @property {'left' | 'right' | 'sheet'} edge
 * @property {string} title
 * @property {string} controls  ID of the element that changes its size.
 * @property {number} least     Size, rem.
 * @property {number} way       1: the element grows towards the right.
 */

/** @type {What[]} */
const ROWS = [
  {edge: 'left', title: say`Width of the left side`, controls: 'left', least: 17, way: 1},
  {edge: 'right', title: say`Width of the right side`, controls: 'right', least: 17, way: -1},
  {edge: 'sheet', title: say`Height of the sides`, controls: 'sides', least: 8, way: -1},
];

/** @param {App} app */
export function createEdges(app) {
  for (const row of ROWS) {
    makeEdge(app, row);
  }
  const main = byId('middle').parentElement;
  app.layout.watch(({name, left, right}) => {
    main?.classList.toggle('no-left', !left);
    main?.classList.toggle('no-right', !right);
    byId('panes').dataset.layout = name;
    const {stage} = app.picture, assumed = byId('assumed');
    stage.hidden = name === 'slices';
    // The warning belongs to the slices, too.
    if (stage.hidden) {
      byId('panes').before(assumed);
    } else if (assumed.parentElement !== stage) {
      byId('overlay').after(assumed);
    }
  });
}

/**
 * @param {App} app
 * @param {What} what
 */
function makeEdge(app, {edge, title, controls, least, way}) {
  const isSheet = edge === 'sheet';
  const main = /** @type {HTMLElement} */ (byId('middle').parentElement);
  const line = h('div', {id: `edge-${edge}`, class: 'edge', role: 'separator', tabindex: 0,
    'aria-label': title, 'aria-controls': controls, 'data-testid': `edge-${edge}`,
    'aria-orientation': isSheet ? 'horizontal' : 'vertical',
    title: say`${title}: drag, or use the arrow keys. A double click resets it.`});
  byId('middle').after(line);
  const most = () => MOST_SHARE[edge] * (isSheet ? innerHeight : innerWidth) / remPx();
  const size = () => {
    const box = byId(isSheet || !byId(controls).checkVisibility() ? 'sides' : controls)
      .getBoundingClientRect();
    return (isSheet ? box.height : box.width) / remPx();
  };
  const limited = (/** @type {number} */ wish) => Math.max(least, Math.min(most(), wish));
  const set = (/** @type {number} */ wish) => app.layout.resize(edge, limited(wish));
  const tell = () => {
    const wish = app.layout.now.sizes[edge];
    main.style.setProperty(`--${edge}`, wish === null ? '' : `${limited(wish)}rem`);
    if (line.checkVisibility()) {
      update(line, {'aria-valuemin': Math.round(least * remPx()),
        'aria-valuemax': Math.round(most() * remPx()),
        'aria-valuenow': Math.round(size() * remPx()),
        'aria-valuetext': say`${Math.round(size() * remPx())} pixels`});
    }
  };
  app.layout.watch(tell);
  new ResizeObserver(tell).observe(byId('middle'));
  line.addEventListener('dblclick', () => app.layout.resize(edge, null));
  line.addEventListener('keydown', event => {
    const step = (event.shiftKey ? FAST : 1) * STEP_REM;
    const forth = isSheet ? 'ArrowDown' : 'ArrowRight', back = isSheet ? 'ArrowUp' : 'ArrowLeft';
    const wish = new Map([[forth, size() + way * step], [back, size() - way * step],
      ['Home', least], ['End', most()]]).get(event.key);
    if (wish !== undefined) {
      event.preventDefault();
      event.stopPropagation();
      set(wish);
    }
  });
  drag(line, event => {
    const from = isSheet ? event.clientY : event.clientX, was = size();
    return moved => set(was + way * ((isSheet ? moved.clientY : moved.clientX) - from) / remPx());
  });
}

/**
 * @param {HTMLElement} line
 * @param {(event: PointerEvent) => (moved: PointerEvent) => void} begin
 */
function drag(line, begin) {
  line.addEventListener('pointerdown', event => {
    if (event.button !== 0) {
      return;
    }
    event.preventDefault();
    line.focus();
    line.setPointerCapture(event.pointerId);
    const move = begin(event);
    const end = () => {
      line.removeEventListener('pointermove', move);
      line.removeEventListener('lostpointercapture', end);
    };
    line.addEventListener('pointermove', move);
    line.addEventListener('lostpointercapture', end);
  });
}
