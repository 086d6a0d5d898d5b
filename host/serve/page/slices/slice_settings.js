// How slices look: zoom, interpolation, contours, colors.
import {h} from '../elements/dom.js';
import {significant} from '../elements/numbers.js';
import {say} from '../texts/say.js';
import {MOST_TIMES, ZOOM_STEP} from './slice_zoom.js';
import {COLOR_MAPS} from './windows.js';

/**
 * How slices look.
 * @typedef {object} Look
 * @property {boolean} smooth   Interpolates between voxels.
 * @property {import('./slice_paint.js').Lines} lines
 * @property {import('./windows.js').ColorMap} map
 */

/** How slices look at first. @type {Readonly<Look>} */
export const USUAL = {smooth: true, lines: 'thick', map: 'gray'};

const LINES = {thick: say`thick`, thin: say`thin`, filled: say`filled`, off: say`none`};

/**
 * @param {string} label
 * @param {string} testid
 * @param {Record<string, string>} choices  Titles by name.
 * @param {() => void} changed
 */
function choice(label, testid, choices, changed) {
  const select = h('select', {'data-testid': testid, onchange: changed},
    ...Object.entries(choices).map(([value, title]) => h('option', {value}, title)));
  return {select, element: h('label', {class: 'number-field'}, label, select)};
}

/** A closed block below the tools. */
export class SliceSettings {
  /**
   * @param {(look: Look) => void} changed
   * @param {(by: number) => void} zoom   `by` times larger; 0: the whole slice.
   * @param {Node[]} more                 Go below.
   */
  constructor(changed, zoom, more) {
    const tell = () => changed(this.look);
    /** @private */
    this.lines_ = choice(say`Contours`, 'slice-lines', LINES, tell);
    /** @private */
    this.map_ = choice(say`Colors`, 'slice-colors', COLOR_MAPS, tell);
    /** @private */
    this.smooth_ = h('input', {type: 'checkbox', 'data-testid': 'slice-smooth', onchange: tell});
    /** @private */
    this.times_ = h('output', {class: 'slice-count', 'data-testid': 'slice-times'});
    /** @private */
    this.smaller_ = this.button_('−', say`Zoom out`, 'slice-smaller', () => zoom(1 / ZOOM_STEP));
    /** @private */
    this.larger_ = this.button_('+', say`Zoom in`, 'slice-larger', () => zoom(ZOOM_STEP));
    this.element = h('details', {class: 'slice-settings', 'data-testid': 'slice-settings'},
      h('summary', {}, say`Zoom, contours, colors, slabs, windows`),
      h('div', {class: 'tool-row'}, h('span', {class: 'number-field'}, say`Zoom`, this.smaller_,
        this.times_, this.larger_),
      this.button_(say`Whole slice`, say`Shows whole slices`, 'slice-whole', () => zoom(0)),
      h('label', {class: 'check', title: say`Interpolates between voxels`}, this.smooth_,
        say`Smooth`)),
      h('div', {class: 'tool-row'}, this.lines_.element, this.map_.element), ...more);
    this.tellTimes(1);
    this.setLook(USUAL);
  }

  /**
   * @private
   * @param {string} text
   * @param {string} title
   * @param {string} testid
   * @param {() => void} press
   */
  button_(text, title, testid, press) {
    return h('button', {type: 'button', title, 'aria-label': /\w/.test(text) ? null : title,
      'data-testid': testid, onclick: press}, text);
  }

  /** @returns {Look} */
  get look() {
    return {smooth: this.smooth_.checked,
      lines: /** @type {Look['lines']} */ (this.lines_.select.value),
      map: /** @type {Look['map']} */ (this.map_.select.value)};
  }

  /** @param {Look} look */
  setLook({smooth, lines, map}) {
    this.smooth_.checked = smooth;
    this.lines_.select.value = lines;
    this.map_.select.value = map;
  }

  /** @param {number} times  The zoom. */
  tellTimes(times) {
    this.times_.textContent = `${significant(times, 2)} ×`;
    this.smaller_.disabled = times <= 1;
    this.larger_.disabled = times >= MOST_TIMES;
  }
}
