// Layout, sides and full screen: buttons in the title bar; in narrow windows they are in the menu
// with the theme.
import {byId, h, update} from '../elements/dom.js';
import {icon, setIcon} from '../elements/icons.js';
import {choiceRow} from '../panel/panel_parts.js';
import {createTheme} from './theme.js';

/** @typedef {import('../panel/app.js').App} App */

const NARROW = '(max-width: 900px)';  // parts.css
const LAYOUTS = /** @type {const} */ ([
  {name: 'picture', title: 'Picture alone', help: 'Picture alone; slices in their panel (key 7)'},
  {name: 'beside', title: 'Picture and three slices', help: 'Picture, three slices beside (key 8)'},
  {name: 'four', title: 'Two by two', help: 'Picture and slices, two by two (key 9)'},
  {name: 'slices', title: 'Slices alone', help: 'Slices alone (key 0)'},
]);
const SIDES = /** @type {const} */ ([
  {side: 'left', title: 'Surfaces', key: ','},
  {side: 'right', title: 'Panels', key: '.'},
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
  const menu = h('div', {id: 'view-menu', role: 'group', 'aria-label': 'View', hidden: true},
    createTheme());
  const button = h('button', {class: 'icon', 'data-testid': 'view-menu', 'aria-label': 'View',
    title: 'Theme; in narrow windows also layout, sides, full screen',
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
  const narrow = matchMedia(NARROW);
  const follow = () => {
    open(false);
    if (narrow.matches) {
      menu.prepend(tools);
    } else {
      place.prepend(tools);
    }
  };
  narrow.addEventListener('change', follow);
  follow();
  return [place];
}

/** @param {App} app */
function layoutChoice(app) {
  const row = choiceRow('Layout', LAYOUTS.map(each => ({...each, glyph: icon(each.name)})),
    name => app.layout.change({name}));
  app.layout.watch(({name}) => row.show(name));
  return row.element;
}

/**
 * @param {App} app
 * @param {typeof SIDES[number]} what
 */
function sideButton(app, {side, title, key}) {
  const button = h('button', {class: 'icon', 'aria-label': title, 'data-testid': `side-${side}`,
    'aria-controls': side, onclick: () => app.layout.toggle(side)}, icon(side));
  app.layout.watch(now => {
    const isOpen = now[side];
    byId(side).hidden = !isOpen;
    update(button, {'aria-expanded': String(isOpen),
      title: `${isOpen ? 'Hide' : 'Show'} the ${side} side: ${title.toLowerCase()} (key ${key})`});
  });
  return button;
}

function fullButton() {
  const button = h('button', {class: 'icon', 'data-testid': 'full-screen',
    hidden: !document.fullscreenEnabled, onclick: toggleFullScreen}, icon('full'));
  const follow = () => {
    const isFull = document.fullscreenElement !== null;
    setIcon(button, isFull ? 'window' : 'full');
    update(button, {'aria-pressed': String(isFull), 'aria-label': 'Full screen',
      title: `${isFull ? 'Leave full screen' : 'Full screen'} (key F)`});
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
