// The window of the slices: two fields, presets, drags.
import {h} from '../elements/dom.js';
import {short} from '../elements/numbers.js';
import {LIMITS} from '../link/vocabulary.js';
import {numberField} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';
import {CT_WINDOWS, allValues, firstWindow, isHounsfield, mostValues, ownWindows, uptakesOf}
  from './windows.js';

/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */
/** @typedef {import('./windows.js').Counts} Counts */
/** @typedef {import('./windows.js').Window} Window */

const DRAG_ACROSS_RANGE = 400;  // CSS pixels of a drag per 1,000 values.
const IN_FIRST_ROW = 3;         // Presets beside Auto and Full.

export class WindowControls {
  /** @param {(through: Window) => void} changed */
  constructor(changed) {
    /** @private */ this.changed_ = changed;
    /** @private @type {VolumeState | null} */ this.volume_ = null;
    /** @private @type {Counts | null} */ this.counts_ = null;
    /** @private Whether the window is still the first one of the volume. */ this.isFirst_ = true;
    /** @type {Window} */
    this.through = {window: 1, level: 0};
    /** @private */
    this.window_ = numberField(say`Window`, 'slices-window', window =>
      this.look({...this.through, window: Math.max(window, LIMITS.least_window)}));
    /** @private */
    this.level_ = numberField(say`Level`, 'slices-level', level =>
      this.look({...this.through, level}));
    this.fields = h('div', {class: 'tool-row'}, this.window_.element, this.level_.element);
    /** @private */
    this.most_ = this.chip_('most', say`Auto`,
      say`All but the lowest and highest 2 % of the voxels`,
      () => this.counts_ && mostValues(this.counts_));
    const presets = CT_WINDOWS.map(({name, title, window, level}) => this.chip_(name, title,
      say`Window ${short(window)}, level ${short(level)}`, () => ({window, level}), 'hounsfield'));
    /** @private Windows of the scan itself. */
    this.own_ = h('span', {class: 'own-windows'});
    this.presets = h('div', {class: 'presets'}, this.own_, ...presets.slice(0, IN_FIRST_ROW),
      this.most_, this.chip_('full', say`Full`, say`Full range of values`,
        () => this.volume_ && allValues(this.volume_)));
    /** Further presets, for a place that may be closed. */
    this.more = h('div', {class: 'presets'}, ...presets.slice(IN_FIRST_ROW));
    this.most_.hidden = true;
  }

  /**
   * @private
   * @param {string} name
   * @param {string} text
   * @param {string} title
   * @param {() => Window | null} window
   * @param {string} [kind]
   */
  chip_(name, text, title, window, kind = '') {
    return h('button', {type: 'button', class: `chip ${kind}`.trim(), title,
      'data-testid': `window-${name}`, onclick: () => {
        const chosen = window();
        if (chosen) {
          this.look(chosen);
        }
      }}, text);
  }

  /**
   * @param {VolumeState} volume
   * @param {boolean} same    The volume was open already: its window stays.
   */
  open(volume, same) {
    this.volume_ = volume;
    for (const chip of [...this.presets.children, ...this.more.children]) {
      if (chip.classList.contains('hounsfield')) {
        chip.toggleAttribute('hidden', !isHounsfield(volume));
      }
    }
    const own = ownWindows(volume), uptakes = uptakesOf(volume).length;
    this.own_.hidden = own.length === 0;
    this.own_.replaceChildren(...own.map(({name, window, level}, k) => this.chip_(`own-${k}`, name,
      k < uptakes
        ? say`Standardized uptake values: window ${short(window)}, level ${short(level)}`
        : say`As the file states: window ${short(window)}, level ${short(level)}`,
      () => ({window, level}))));
    if (!same) {
      this.count(null);
      this.look(firstWindow(volume, null));
      this.isFirst_ = true;
    }
  }

  /** @param {Counts | null} counts  The histogram of the volume. */
  count(counts) {
    this.counts_ = counts;
    this.most_.hidden = !counts;
    if (counts && this.volume_ && this.isFirst_) {
      this.look(firstWindow(this.volume_, counts));
    }
  }

  /**
   * Changes the window by a drag, as on workstations: across widens, down darkens.
   * @param {number} across   CSS pixels.
   * @param {number} down
   */
  drag(across, down) {
    const range = this.volume_ ? this.volume_.maximum - this.volume_.minimum : 1;
    const each = Math.min(range, 1000) / DRAG_ACROSS_RANGE;
    this.look({
      window: Math.max(this.through.window + 2 * across * each, each),
      level: this.through.level + down * each,
    });
  }

  /** @param {Window} through */
  look(through) {
    this.isFirst_ = false;
    this.through = through;
    this.window_.input.value = String(Number(through.window.toPrecision(4)));
    this.level_.input.value = String(Number(through.level.toPrecision(4)));
    this.changed_(through);
  }
}
