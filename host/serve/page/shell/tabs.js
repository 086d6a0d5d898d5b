// The rail: a column of icons, each with a panel, at the right; a row at the bottom of upright
// windows.
import {byId, h, update} from '../elements/dom.js';
import {icon} from '../elements/icons.js';
import {create as createInspector} from '../inspect/inspector.js';
import {create as createMachine} from '../machine/machine_panel.js';
import {create as createMeasure} from '../inspect/measure.js';
import {create as createSlices} from '../slices/slices.js';
import {say} from '../texts/say.js';
import {create as createVolume} from '../volume/volume_report.js';
import {Tips} from './tips.js';

/** @typedef {import('../panel/app.js').App} App */

const UPRIGHT = '(max-width: 900px) and (orientation: portrait)';  // layouts.css: a row.
/** Layouts.css: one of the sides at a time, and the surfaces have an icon, too. */
const SINGLE = '(max-width: 699px) and (orientation: portrait)';

/**
 * @typedef {object} Tab
 * @property {string} id       ID of the section, and in `data-testid="tab-ID"`.
 * @property {string} title
 * @property {string} [narrow] The title with soft hyphens, if it is longer than the rail is wide.
 * @property {import('../elements/icons.js').IconName} glyph
 * @property {string} help     Tooltip, one line.
 * @property {(root: HTMLElement, app: App) => void} [create]  Without: the left side.
 */

/**
 * The tabs in order. A section receives `panelshow` and `panelhide` when its visibility changes.
 * @type {Tab[]}
 */
const TABS = [
  {id: 'surfaces', title: say`Surfaces`, narrow: say`Surfaces|with soft hyphens`,
    glyph: 'surfaces', help: say`Isovalues, clip planes, light and material`},
  {id: 'slices', title: say`Slices`, glyph: 'planes', help: say`Three slices of the scan`,
    create: createSlices},
  {id: 'measure', title: say`Measure`, glyph: 'ruler', help: say`Distances, angles, paths, regions`,
    create: createMeasure},
  {id: 'inspector', title: say`Inspector`, glyph: 'lens', help: say`Explains the color of a pixel`,
    create: createInspector},
  {id: 'machine', title: say`Machine`, glyph: 'ring', help: say`Activity of the nodes`,
    create: createMachine},
  {id: 'volume', title: say`Volume`, glyph: 'report', help: say`Geometry, values and warnings`,
    create: createVolume},
];
const LEFT = 0, FIRST = 1;

/** @param {App} app */
export function createTabs(app) {
  const bar = byId('tabs'), tips = new Tips();
  const made = TABS.map(tab => makeTab(tab, app, tips));
  bar.append(...made.map(({button}) => button));
  const single = matchMedia(SINGLE), upright = matchMedia(UPRIGHT);
  let shown = -1, right = FIRST;

  const choose = (/** @type {number} */ chosen) => {
    shown = chosen;
    right = chosen === LEFT ? right : chosen;
    byId('middle').parentElement?.classList.toggle('at-surfaces', chosen === LEFT);
    made.forEach(({button, section}, index) => {
      const now = index === chosen;
      button.setAttribute('aria-selected', String(now));
      button.tabIndex = now ? 0 : -1;
      if (section && section.hidden === now) {
        section.hidden = !now;
        section.dispatchEvent(new Event(now ? 'panelshow' : 'panelhide'));
      }
    });
  };
  const follow = () => {
    const left = byId('left');
    made[LEFT].button.hidden = !single.matches;
    update(left, {role: single.matches ? 'tabpanel' : null,
      'aria-labelledby': single.matches ? `tab-${TABS[LEFT].id}` : null});
    update(bar, {'aria-orientation': upright.matches ? 'horizontal' : 'vertical'});
    // The histogram is where a phone's user begins.
    if (shown === -1 || !single.matches && shown === LEFT) {
      choose(single.matches ? LEFT : right);
    }
  };
  made.forEach(({button}, index) => {
    button.addEventListener('click', () => {
      choose(index);
      const side = index === LEFT ? 'left' : 'right';
      if (!app.layout.now[side]) {
        app.layout.toggle(side);
      }
    });
    button.addEventListener('keydown', event => {
      const step = new Map([['ArrowRight', 1], ['ArrowDown', 1], ['ArrowLeft', -1],
        ['ArrowUp', -1]]).get(event.key);
      if (step) {
        event.stopPropagation();
        event.preventDefault();
        const open = made.map(each => each.button).filter(each => !each.hidden);
        const next = open[(open.indexOf(button) + step + open.length) % open.length];
        choose(made.findIndex(each => each.button === next));
        next.focus();
      }
    });
  });
  single.addEventListener('change', follow);
  upright.addEventListener('change', follow);
  follow();
}

/**
 * @param {Tab} tab
 * @param {App} app
 * @param {Tips} tips
 */
function makeTab({id, title, narrow = title, glyph, help, create}, app, tips) {
  const section = create && h('section', {id: `panel-${id}`, role: 'tabpanel', hidden: true,
    'aria-labelledby': `tab-${id}`, tabindex: 0});  // The keyboard scrolls it.
  const button = h('button', {id: `tab-${id}`, role: 'tab', 'aria-selected': false,
    'aria-controls': section?.id ?? 'left', 'data-testid': `tab-${id}`, tabindex: -1,
    'aria-label': narrow !== title && title},
  icon(glyph), h('span', {}, narrow));
  tips.add(button, help);
  if (section) {
    section.append(h('h2', {class: 'unseen'}, title));
    byId('panels').append(section);
    create?.(section, app);
  }
  return {button, section};
}

/**
 * Brings a tab to the front.
 * @param {string} id
 */
export function showTab(id) {
  document.getElementById(`tab-${id}`)?.click();
}
