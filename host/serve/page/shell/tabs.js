// The panels on the right, each behind a tab.
import {byId, h} from '../elements/dom.js';
import {create as createInspector} from '../inspect/inspector.js';
import {create as createMachine} from '../machine/machine_panel.js';
import {create as createMeasure} from '../inspect/measure.js';
import {create as createSlices} from '../slices/slices.js';
import {create as createVolume} from '../volume/volume_report.js';

/**
 * @typedef {object} Tab
 * @property {string} id       ID of the section, and in `data-testid="tab-ID"`.
 * @property {string} title
 * @property {string} help     Tooltip, one line.
 * @property {(root: HTMLElement, app: import('../panel/app.js').App) => void} create
 */

/**
 * The tabs in order. A section receives `panelshow` and `panelhide` when its visibility changes.
 * @type {Tab[]}
 */
const TABS = [
  {id: 'slices', title: 'Slices', help: 'Three slices of the scan', create: createSlices},
  {id: 'measure', title: 'Measure', help: 'Distances, angles, paths, regions',
    create: createMeasure},
  {id: 'inspector', title: 'Inspector', help: 'Explains the color of a pixel',
    create: createInspector},
  {id: 'machine', title: 'Machine', help: 'Activity of the nodes', create: createMachine},
  {id: 'volume', title: 'Volume', help: 'Geometry, values and warnings', create: createVolume},
];

/** @param {import('../panel/app.js').App} app */
export function createTabs(app) {
  const bar = byId('tabs');
  const panels = byId('panels');
  const made = TABS.map(({id, title, help, create}) => {
    const section = h('section', {id: `panel-${id}`, role: 'tabpanel', hidden: true,
      'aria-labelledby': `tab-${id}`, tabindex: 0});  // The keyboard scrolls it.
    const button = h('button', {id: `tab-${id}`, role: 'tab', title: help, 'aria-selected': false,
      'aria-controls': section.id, 'data-testid': `tab-${id}`, tabindex: -1}, title);
    panels.append(section);
    bar.append(button);
    create(section, app);
    return {button, section};
  });

  const choose = (/** @type {number} */ chosen, focus = false) => {
    made.forEach(({button, section}, index) => {
      const now = index === chosen;
      button.setAttribute('aria-selected', String(now));
      button.tabIndex = now ? 0 : -1;
      if (section.hidden === now) {
        section.hidden = !now;
        section.dispatchEvent(new Event(now ? 'panelshow' : 'panelhide'));
      }
      if (now && focus) {
        button.focus();
      }
    });
  };
  made.forEach(({button}, index) => {
    button.addEventListener('click', () => choose(index));
    button.addEventListener('keydown', event => {
      const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
      if (step !== 0) {
        event.stopPropagation();
        choose((index + step + made.length) % made.length, true);
      }
    });
  });
  if (made.length > 0) {
    choose(0);
  }
}

/**
 * Brings a tab to the front.
 * @param {string} id
 */
export function showTab(id) {
  document.getElementById(`tab-${id}`)?.click();
}
