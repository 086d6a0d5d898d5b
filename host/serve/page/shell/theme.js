// Dark or light: as the system says, or as the user says. Paper is always light.
import {byId, h} from '../elements/dom.js';
import {choiceRow} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';

const KEY = 'pxpl5-theme';
/** When the light style sheet holds. */
const MEDIA = {system: 'print, (prefers-color-scheme: light)', dark: 'print', light: 'all'};
const CHOICES = /** @type {const} */ ([
  {name: 'system', title: say`System`, help: say`As the system or the browser is set`},
  {name: 'dark', title: say`Dark`, help: say`Light text on dark panels`},
  {name: 'light', title: say`Light`, help: say`Dark text on light panels`},
]);

/** @returns {HTMLElement} the choice of the theme, which the browser keeps */
export function createTheme() {
  const row = choiceRow(say`Theme`, [...CHOICES], name => {
    take(name);
    try {
      localStorage.setItem(KEY, name);
    } catch {
      // Without storage each visit begins with the theme of the system.
    }
  });
  let kept = null;
  try {
    kept = localStorage.getItem(KEY);
  } catch {
    // The same.
  }
  const name = CHOICES.find(each => each.name === kept)?.name ?? 'system';
  row.show(name);
  take(name);
  return h('div', {class: 'row spread'}, h('span', {class: 'muted'}, say`Theme`), row.element);
}

/** @param {keyof typeof MEDIA} name */
function take(name) {
  /** @type {HTMLLinkElement} */ (byId('light')).media = MEDIA[name];
}
