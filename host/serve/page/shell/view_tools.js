// Layout, sides and full screen: buttons in the title bar; in narrow windows they are in the menu
// with the theme.
import {byId, h, update} from '../elements/dom.js';
import {icon, setIcon} from '../elements/icons.js';
import {choiceRow} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';
import {createTheme} from './theme.js';

/** @typedef {import('../panel/app.js').App} App */

const NARROW = '(max-width: 900px)', PHONE = '(max-width: 560px)';  // layouts.css, parts.css
const LAYOUTS = /** @type {const} */ ([
  {name: 'picture', title: say`Picture alone`,
    help: say`Picture alone; slices in their panel (key 7)`},
  {name: 'beside', title: say`Picture and three slices`,
    help: say`Picture, three slices beside (key 8)`},
  {name: 'four', title: say`Two by two`, help: say`Picture and slices, two by two (key 9)`},
  {name: 'slices', title: say`Slices alone`, help: say`Slices alone (key 0)`},
]);
const SIDES = /** @type {const} */ ([
  {side: 'left', title: say`Surfaces`, key: ',', hide: say`Hide the left side: surfaces (key ,)`,
    show: say`Show the left side: surfaces (key ,)`},
  {side: 'right', title: say`Panels`, key: '.', hide: say`Hide the right side: panels (key .)`,
    show: say`Show the right side: panels (key .)`},
]);
/** Keys of the layouts, in order. */
export const LAYOUT_KEYS = new Map(LAYOUTS.map(({name}, index) => ['7890'[index], name]));
/** @type {Map<string, 'left' | 'right'>} */
export const SIDE_KEYS = new Map(SIDES.map(({side, key}) => [key, side]));

/**
 * @param {App} app
 * @returns {HTMLElement[]} what stands in the title bar
 */
export function createViewTools(app) {
  const tools = h('div', {class: 'row view-tools'}, layoutChoice(app),
    h('div', {class: 'row pair'}, ...SIDES.map(each => sideButton(app, each))), fullButton());
  const menu = h('div', {id: 'view-menu', role: 'group', 'aria-label': say`View`, hidden: true},
    createTheme());
  const button = h('button', {class: 'icon', 'data-testid': 'view-menu', 'aria-label': say`View`,
    title: say`Theme; in narrow windows also layout, sides, full screen`,
    'aria-expanded': false, 'aria-controls': menu.id,
    onclick: () => open(menu.hidden !== false)}, icon('view'));
  const place = h('div', {class: 'view-place'}, tools, button, menu);
  const open = (/** @type {boolean} */ isOpen) => {
    menu.hidden = !isOpen;
    update(button, {'aria-expanded': String(isOpen)});
  };
  place.addEventListener('keydown', event => {
    if (event.key === 'Escape' && !menu.hidden) {
      event.stopPropagation();
      open(false);
      button.focus();
    }
  });
  document.addEventListener('pointerdown', event => {
    if (!place.contains(/** @type {Node} */ (event.target))) {
      open(false);
    }
  });
  menu.addEventListener('click', event => {
    if (event.target instanceof Element && event.target.closest('#views')) {
      open(false);  // It lies over the picture.
    }
  });
  inMenu(NARROW, tools, () => place.prepend(tools), () => menu.prepend(tools));
  matchMedia(NARROW).addEventListener('change', () => open(false));
  return [place];
}

/**
 * Puts controls into the menu in small windows, and back in others.
 * @param {string} query    When.
 * @param {HTMLElement} what
 * @param {() => void} back
 * @param {() => void} into
 */
function inMenu(query, what, back, into) {
  const small = matchMedia(query);
  const follow = () => (small.matches ? into : back)();
  small.addEventListener('change', follow);
  follow();
}

/**
 * In small windows, moves controls to a row of the menu with a title.
 * @param {'narrow' | 'phone'} when
 * @param {string} title
 * @param {HTMLElement} what
 * @param {() => void} back  Puts them where they are otherwise.
 */
export function moveToMenu(when, title, what, back) {
  const row = h('div', {class: 'row spread'}, h('span', {class: 'muted'}, title));
  inMenu(when === 'narrow' ? NARROW : PHONE, what, () => {
    row.remove();
    back();
  }, () => {
    row.append(what);
    const menu = byId('view-menu');
    menu.insertBefore(row, when === 'narrow' ? menu.querySelector('.spread') : null);
  });
}

/** @param {App} app */
function layoutChoice(app) {
  const row = choiceRow(say`Layout`, LAYOUTS.map(each => ({...each, glyph: icon(each.name)})),
    name => app.layout.change({name}));
  app.layout.watch(({name}) => row.show(name));
  return row.element;
}

/**
 * @param {App} app
 * @param {typeof SIDES[number]} what
 */
function sideButton(app, {side, title, hide, show}) {
  const button = h('button', {class: 'icon', 'aria-label': title, 'data-testid': `side-${side}`,
    'aria-controls': side, onclick: () => app.layout.toggle(side)}, icon(side));
  app.layout.watch(now => {
    const isOpen = now[side];
    byId(side).hidden = !isOpen;
    update(button, {'aria-expanded': String(isOpen), title: isOpen ? hide : show});
  });
  return button;
}

function fullButton() {
  const button = h('button', {class: 'icon', 'data-testid': 'full-screen',
    hidden: !document.fullscreenEnabled, onclick: toggleFullScreen}, icon('full'));
  const follow = () => {
    const isFull = document.fullscreenElement !== null;
    setIcon(button, isFull ? 'window' : 'full');
    update(button, {'aria-pressed': String(isFull), 'aria-label': say`Full screen`,
      title: isFull ? say`Leave full screen (key F)` : say`Full screen (key F)`});
  };
  document.addEventListener('fullscreenchange', follow);
  follow();
  return button;
}

/** Does nothing in browsers without full screen, or where a page forbids it. */
export function toggleFullScreen() {
  if (document.fullscreenElement) {
    void document.exitFullscreen();
  } else if (document.fullscreenEnabled) {
    document.documentElement.requestFullscreen().catch(() => {});
  }
}
