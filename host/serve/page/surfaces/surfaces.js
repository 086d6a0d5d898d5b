// The list of surfaces, tissues to add, and the mode that picks a tissue.
import {byId, h, setText} from '../elements/dom.js';
import {grouped, short} from '../elements/numbers.js';
import {isoCommand, roundIso, toLine, word} from '../link/lines.js';
import {plural, say} from '../texts/say.js';
import {mayBeHounsfield} from './bands.js';
import {SurfaceCard} from './surface_card.js';
import {LIMITS} from '../link/vocabulary.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').State} State */
/** @typedef {import('../state/selection.js').Selection} Selection */
/** @typedef {{name: string, isovalue: number, help: string}} Tissue */

const ANNOUNCE_MS = 800;
/** Tissues of the command `presets`: how the page writes the name and the help of each. */
const TISSUE_WORDS = /** @type {Record<string, [string, string]>} */ ({
  lung: [say`lung`, say`air-filled tissue against the chest's soft parts`],
  skin: [say`skin`, say`the body against the air around it`],
  fat: [say`fat`, say`outside of fat`],
  muscle: [say`muscle`, say`between fat and muscle`],
  bone: [say`bone`, say`all bone; contrast-filled vessels too`],
  cortex: [say`cortex`, say`dense bone and teeth`],
  metal: [say`metal`, say`implants, fillings`],
});

/**
 * @param {HTMLElement} root
 * @param {App} app
 * @param {Selection} selection
 */
export function createSurfaces(root, app, selection) {
  /** @type {Map<string, SurfaceCard>} */
  const cards = new Map();
  const announce = announcer();
  const list = h('ul', {id: 'surfaces', 'data-testid': 'surfaces'});
  const empty = h('p', {class: 'muted', 'data-testid': 'no-surfaces'});
  const add = h('button', {class: 'quiet', 'data-testid': 'surface-add',
    title: say`Add a surface at the middle of the value range`,
    onclick: () => addSurface(app, selection)},
    say`+ Add`);
  root.append(h('h2', {class: 'spread'}, h('span', {}, say`Surfaces`), add), list, empty);
  const ownOf = (/** @type {State} */ {surfaces}) =>
    surfaces.filter(each => each.compared_with === '');
  app.store.subscribe(['surfaces', 'volume'], state => selection.keepTo(ownOf(state)));
  app.store.follow(['surfaces', 'volume'], state => {
    const own = ownOf(state);
    empty.hidden = own.length > 0 || !state.volume;
    setText(empty, state.volume && mayBeHounsfield(state.volume)
      ? say`No surfaces. Add a surface, or choose a tissue above.`
      : say`No surfaces. Add a surface.`);
    add.disabled = !state.volume || own.length >= LIMITS.max_user_surfaces;
    for (const [name, card] of cards) {
      if (!own.some(each => each.name === name)) {
        card.remove();
        cards.delete(name);
      }
    }
    for (const surface of own) {
      let card = cards.get(surface.name);
      if (!card) {
        card = new SurfaceCard(app, selection, surface.name);
        cards.set(surface.name, card);
        list.append(card.root);
      }
      card.show(surface);
    }
    announce(own);
  });
}

/** Announces a changed isovalue at rest, for screen readers. */
function announcer() {
  /** @type {Map<string, number>} */
  const told = new Map();
  let timer = 0;
  return (/** @type {import('../link/vocabulary.js').SurfaceState[]} */ surfaces) => {
    clearTimeout(timer);
    timer = window.setTimeout(() => {
      const changed = surfaces.filter(each => told.get(each.name) !== each.isovalue);
      told.clear();  // Removed surfaces would stay.
      for (const {name, isovalue} of surfaces) {
        told.set(name, isovalue);
      }
      byId('live').textContent = changed.map(({name, isovalue, triangles}) => {
        const mesh = plural(triangles, say`1 triangle`, say`${grouped(triangles)} triangles`);
        return say`${name} at ${short(isovalue, 3)}: ${mesh}`;
      }).join('; ');
    }, ANNOUNCE_MS);
  };
}

/**
 * @param {App} app
 * @param {Selection} selection
 */
async function addSurface(app, selection) {
  const state = app.store.state;
  if (!state?.volume) {
    return;
  }
  const taken = new Set(state.surfaces.map(({name}) => name));
  let number = state.surfaces.length + 1;
  while (taken.has(`surface-${number}`)) {
    number += 1;
  }
  const {minimum, maximum} = state.volume;
  const name = `surface-${number}`;
  const value = roundIso((minimum + maximum) / 2, state.volume);
  const reply = await app.connection.do(toLine(isoCommand(name, value)));
  if (reply.ok) {
    selection.choose(name);
  }
}

/**
 * Chips of the tissues of CT, and the button of the tissue mode.
 * @param {HTMLElement} root
 * @param {App} app
 * @param {Selection} selection
 */
export function createTissues(root, app, selection) {
  const chips = h('div', {class: 'chips', role: 'group', 'aria-label': say`Tissues`});
  const pick = h('button', {'data-testid': 'tissue-mode', 'aria-pressed': false,
    onclick: () => toggleTissueMode(app, selection)}, say`Pick tissue`);
  root.append(chips, h('div', {class: 'row drives'}, pick));
  app.modes.watch(mode => pick.setAttribute('aria-pressed', String(mode?.name === 'tissue')));
  selection.watch(name => {
    pick.disabled = name === '';
    pick.title = name === '' ? say`Click tissue to set the isovalue of a surface`
      : say`Click tissue to set the isovalue of ${name}`;
  });
  /** @type {Tissue[]} */
  let tissues = [];
  const draw = (/** @type {State} */ {volume}) => {
    chips.hidden = !volume || !mayBeHounsfield(volume);
    const {minimum, maximum} = volume ?? {minimum: 0, maximum: 0};
    chips.replaceChildren(...tissues.map(({name, isovalue, help}) => {
      const [title, meaning] = TISSUE_WORDS[name] ?? [name, help];
      return h('button', {class: 'chip', 'data-testid': `preset-${name}`,
        title: `${title}: ${meaning} (${short(isovalue)} HU)`,
        disabled: isovalue <= minimum || isovalue > maximum,
        onclick: () => showTissue(app, selection, name)}, title);
    }));
  };
  app.store.subscribe(['volume'], async state => {
    draw(state);
    if (tissues.length === 0 && state.volume && !app.connection.watches) {
      const reply = await app.connection.do('presets', {quiet: true});
      tissues = reply.result?.presets ?? [];
      draw(app.store.state ?? state);
    }
  });
}

/**
 * Sets the surface of that name to the tissue's threshold, and adds it if it is missing.
 * @param {App} app
 * @param {Selection} selection
 * @param {string} tissue
 */
async function showTissue(app, selection, tissue) {
  app.connection.mark();
  const reply = await app.connection.do(`surface ${word(tissue)} preset=${tissue} visible=yes`);
  if (reply.ok) {
    selection.choose(tissue);
  }
}

/**
 * @param {App} app
 * @param {Selection} selection
 */
function toggleTissueMode({connection, modes, store}, selection) {
  if (modes.current?.name === 'tissue') {
    modes.leave();
    return;
  }
  const name = selection.name;
  modes.enter({
    name: 'tissue', surface: name,
    hint: say`Click tissue, here or in a slice, to set the isovalue of ${name}.`,
    click: (x, y) => {
      connection.mark();
      void connection.do(`pick ${x} ${y} set=${word(name)}`);
    },
    value: value => {
      const volume = store.state?.volume;
      if (volume) {
        connection.mark();
        void connection.set(isoCommand(name, roundIso(value, volume)));
      }
    },
  });
}
