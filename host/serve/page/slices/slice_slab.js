// Slabs: how thick each slice is shown, and what of the slab's voxels.
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {numberField, shown} from '../panel/panel_parts.js';
import {plural, say} from '../texts/say.js';
import {smallPlaneWord} from './slice_words.js';

/** @typedef {'max' | 'mean' | 'min'} SlabKind */
/** @typedef {{mm: number, kind: SlabKind}} Slab  0 mm: a single slice. */
/**
 * A slab as `ask slice` answers it.
 * @typedef {{thickness_mm: number, kind: SlabKind, slices: [number, number], type: string}}
 *   ShownSlab
 */

/** @type {Record<SlabKind, string>} */
const WORDS = {max: say`maximum`, mean: say`mean`, min: say`minimum`};
/** Short, for pictures. @type {Record<SlabKind, string>} */
export const SLAB_KINDS = {max: say`max`, mean: say`mean`, min: say`min`};
const MOST_MM = 1e6;  // As the host's limit of places.
const ALL = 'all';

/**
 * "maximum of 11 slices"
 * @param {ShownSlab} slab
 */
export function slabText({kind, slices: [first, last]}) {
  const count = last - first + 1;
  return plural(count, say`${WORDS[kind]} of 1 slice`,
    say`${WORDS[kind]} of ${grouped(count)} slices`);
}

/** A row of fields: thickness, kind, and the slices that they are for. */
export class SlabControls {
  /**
   * @param {string[]} planes
   * @param {() => void} changed
   */
  constructor(planes, changed) {
    /** @private @type {Slab[]} */
    this.slabs_ = planes.map(() => ({mm: 0, kind: 'max'}));
    /** @private */ this.changed_ = changed;
    /** @private */
    this.mm_ = numberField(say`Slab, mm`, 'slab-mm', mm =>
      this.set_({mm: Math.min(Math.max(mm, 0), MOST_MM)}));
    this.mm_.input.min = '0';
    /** @private */
    this.kind_ = h('select', {'aria-label': say`What the slab shows`, 'data-testid': 'slab-kind',
      onchange: () => this.set_({kind: /** @type {SlabKind} */ (this.kind_.value)})},
    ...Object.entries(WORDS).map(([value, word]) =>
      h('option', {value}, value === 'max' ? `${word} (MIP)` : word)));
    /** @private */
    this.plane_ = h('select', {'aria-label': say`Slices that are slabs`,
      'data-testid': 'slab-plane', onchange: () => this.tell_()},
    h('option', {value: ALL}, say`all slices`),
    ...planes.map((plane, value) => h('option', {value}, smallPlaneWord(plane))));
    this.element = h('div', {class: 'tool-row',
      title: say`Shows the voxels of all slices within half of this thickness. 0: a single slice`},
    this.mm_.element, this.kind_, this.plane_);
    this.tell_();
  }

  /** @private */
  get chosen_() {
    return this.slabs_.map((_, number) => number)
      .filter(number => [ALL, String(number)].includes(this.plane_.value));
  }

  /**
   * @private
   * @param {Partial<Slab>} part
   */
  set_(part) {
    for (const number of this.chosen_) {
      this.slabs_[number] = {...this.slabs_[number], ...part};
    }
    this.tell_();
    this.changed_();
  }

  /** @private */
  tell_() {
    const {mm, kind} = this.slabs_[this.chosen_[0]];
    this.mm_.input.value = String(mm);
    this.kind_.value = kind;
  }

  /** By plane. */
  get slabs() {
    return this.slabs_;
  }

  /**
   * @param {Slab[]} slabs
   * @throws {Error} if there is no slab for each plane
   */
  setSlabs(slabs) {
    const isSlab = (/** @type {any} */ each) => Number.isFinite(each?.mm) && each.mm >= 0
      && each.mm <= MOST_MM && Object.hasOwn(WORDS, each.kind);
    if (!Array.isArray(slabs) || slabs.length !== this.slabs_.length || !slabs.every(isSlab)) {
      throw new Error(say`it is ${shown(slabs)}, but ${this.slabs_.length}
        thicknesses of 0 to ${MOST_MM} mm with a kind are needed.`);
    }
    this.slabs_ = slabs;
    this.tell_();
    this.changed_();
  }
}
