// A click on the picture: passes it to the current mode, or moves the crosshair of all views.
import {byId, h} from '../elements/dom.js';
import {grouped, short} from '../elements/numbers.js';
import {planesOf} from '../slices/slice_planes.js';
import {placeText} from '../slices/slice_words.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/**
 * A point under a pixel.
 * @typedef {object} Hit
 * @property {string} surface                        Empty for a point of a slice.
 * @property {{axis: string, index: number}} [slice]
 */

const DOUBLE_CLICK_MS = 300;  // A click waits this long for a second click.

/**
 * @param {App} app
 * @param {() => void} reset  Called at a double click. In a mode, a double click is two clicks.
 * @returns {(event: PointerEvent) => void}
 */
export function createPointing(app, reset) {
  const words = h('div', {id: 'pointed', role: 'status', 'data-testid': 'pointed', hidden: true});
  byId('middle').querySelector('#stage')?.append(words);
  app.picture.onShown(header => {
    // The text describes the previous picture.
    words.hidden ||= !header.rests;
  });
  let timer = 0;
  return event => {
    const place = app.picture.placeAt(event);
    if (app.connection.watches) {
      return;
    }
    if (app.modes.current) {
      if (place) {
        const {x, y} = app.picture.pixelOf(place);
        app.modes.current.click(x, y);
      }
    } else if (timer !== 0) {
      // A double click points at nothing.
      clearTimeout(timer);
      timer = 0;
      reset();
    } else {
      timer = window.setTimeout(() => {
        timer = 0;
        if (place) {
          void point(app, app.picture.pixelOf(place), words);
        }
      }, DOUBLE_CLICK_MS);
    }
  };
}

/**
 * @param {App} app
 * @param {{x: number, y: number}} pixel
 * @param {HTMLElement} words
 */
async function point(app, {x, y}, words) {
  const reply = await app.connection.do(`pick ${x} ${y}`, {quiet: true});
  if (!reply.ok || !reply.result?.hit) {
    words.hidden = true;
    return;
  }
  const {surface, slice, isovalue, p_mm, value} = reply.result;
  /** @type {Hit[]} */
  const hits = reply.result.hits;
  const volume = app.store.state?.volume ?? null;
  const title = titleOf({surface, slice}, volume);
  const names = hits.map(hit => titleOf(hit, volume)), chosen = names.indexOf(title);
  const others = names.filter(name => name !== title).map(name =>
    names.indexOf(name) < chosen ? say`in front: ${name}` : say`behind: ${name}`);
  const unit = volume?.unit ?? '';
  words.replaceChildren(h('strong', {}, title),
    isovalue === undefined ? ''
      : ` ${say`isovalue ${`${short(isovalue, 3)}${unit && ` ${unit}`}`}`}`,
    value === undefined ? '' : `, ${say`nearest voxel ${short(value, 3)}`}`,
    h('span', {class: 'muted'}, ` ${say`at ${sides(p_mm)}`}`),
    ...others.map(other => h('span', {class: 'muted'}, ` · ${other}`)));
  words.hidden = false;
  document.dispatchEvent(new CustomEvent('place', {detail: {p_mm, from: 'picture'}}));
}

/**
 * A surface's name, or "Axial slice 3 of 48".
 * @param {Hit} hit
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
function titleOf({surface, slice}, volume) {
  const axis = slice ? 'xyz'.indexOf(slice.axis) : -1;
  const plane = volume && planesOf(volume.voxel_to_patient).find(({number}) => number === axis);
  return slice && volume && plane
    ? placeText(plane.plane, slice.index + 1, volume.size[axis]) : surface;
}

/**
 * A patient position as text: "12.3 L, 4.0 P, 80.1 S mm".
 * @param {import('../link/types.js').Triple} p_mm
 */
function sides(p_mm) {
  const letters = [['L', 'R'], ['P', 'A'], ['S', 'I']];
  return p_mm.map((mm, k) => `${grouped(Math.abs(mm), 1)} ${letters[k][mm < 0 ? 1 : 0]}`)
    .join(', ') + ' mm';
}
