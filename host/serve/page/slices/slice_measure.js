// Measuring on slices: distances, angles and paths from point to point, regions by dragging.
import {h} from '../elements/dom.js';
import {KIND_TITLES, Points, isRegion, measureText, valuesOf, valuesText}
  from '../panel/measures.js';
import {sentenceOf} from '../panel/panel_parts.js';
import {toPatient, toVoxel} from './patient_grid.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_view.js').Phase} Phase */
/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */
/** @typedef {import('../panel/measures.js').Kind} Kind */
/** @typedef {import('../panel/measures.js').Measure} Measure */
/**
 * A measurement as a slice shows it.
 * @typedef {object} Mark
 * @property {Kind} kind
 * @property {Vector[]} voxels
 * @property {string} text
 * @property {{axis: 'x' | 'y' | 'z', index: number}} [slice]  The only slice that shows it.
 */

export class SliceMeasure {
  /**
   * @param {import('../panel/app.js').App} app
   * @param {{say: (text: string) => void, fail: (text: string) => void}} message
   * @param {() => void} changed  The points so far are other ones.
   */
  constructor(app, message, changed) {
    /** @private */ this.app_ = app;
    /** @private */ this.message_ = message;
    /** @private */ this.changed_ = changed;
    /** @private */ this.points_ = new Points('distance');
    /** The region that is being drawn. @private @type {Mark | null} */ this.region_ = null;
    this.kind = h('select', {'aria-label': 'What to measure', hidden: true,
      'data-testid': 'slices-kind', onchange: () => this.choose_()},
    ...Object.entries(KIND_TITLES).map(([value, title]) => h('option', {value}, title)));
    this.done = h('button', {type: 'button', disabled: true, hidden: true,
      'data-testid': 'slices-path-done', onclick: () => this.finish()}, 'End path');
  }

  /** @private */
  choose_() {
    const refusal = this.finish();
    const kind = /** @type {Kind} */ (this.kind.value);
    this.points_ = new Points(kind);
    this.done.hidden = kind !== 'path';
    if (!refusal) {
      this.message_.say(isRegion(kind) ? 'Drag from corner to corner.' : 'Click the first point.');
    }
  }

  /** @param {boolean} isOn  Whether the tool is chosen. */
  show(isOn) {
    this.kind.hidden = !isOn;
    this.done.hidden = !isOn || this.kind.value !== 'path';
    this.finish();
  }

  /** Forgets the points so far. */
  forget() {
    this.points_ = new Points(this.points_.kind);
    this.region_ = null;
    this.done.disabled = true;
    this.changed_();
  }

  /**
   * Keeps a path of two or more points, and forgets others that are not whole. Returns why the path
   * is not kept; empty if it is.
   */
  finish() {
    const path = this.points_.end();
    this.forget();
    return path ? this.add_(path) : '';
  }

  /**
   * @param {Phase} phase
   * @param {Vector | null} voxel     Not rounded; null if the phase has no place.
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  take(phase, voxel, view, volume) {
    if (phase === 'end') {
      this.finish();
    } else if (isRegion(this.points_.kind)) {
      this.drag_(phase, voxel, view, volume);
    } else if (phase === 'press' && voxel) {
      this.click_(toPatient(volume, voxel));
    }
  }

  /**
   * What slices show: all measurements, and the one that is being made.
   * @param {VolumeState} volume
   * @returns {Mark[]}
   */
  marks(volume) {
    const voxels = (/** @type {Vector[]} */ points) => points.map(p => toVoxel(volume, p));
    const marks = this.app_.measures.list.map(measure => ({kind: measure.kind,
      voxels: voxels(measure.points_mm), slice: measure.slice,
      text: `${measure.name}: ${measureText(measure)}`}));
    const {kind, list} = this.points_;
    return [...marks, ...this.region_ ? [this.region_] : [],
      ...list.length > 0 ? [{kind, voxels: voxels(list), text: ''}] : []];
  }

  /**
   * @private
   * @param {Vector} p_mm
   */
  click_(p_mm) {
    try {
      const whole = this.points_.take(p_mm);
      if (whole) {
        this.add_(whole);
      } else {
        this.message_.say(this.points_.sentence);
      }
    } catch (same) {
      this.message_.fail(sentenceOf(same));
    }
    this.done.disabled = this.points_.list.length < 2;
    this.changed_();
  }

  /**
   * @private
   * @param {Phase} phase
   * @param {Vector | null} voxel
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  drag_(phase, voxel, view, volume) {
    const slice = view.shown;
    // A second press, of the key Enter, is the other corner.
    const isEnd = phase === 'release' || phase === 'press' && this.region_ !== null;
    if (phase === 'press' && !isEnd) {
      this.region_ = slice && voxel &&
        {kind: this.points_.kind, voxels: [voxel, voxel], slice, text: ''};
    }
    const region = this.region_;
    const isSame = region?.slice?.axis === slice?.axis && region?.slice?.index === slice?.index;
    if (!region || !isSame || phase === 'cancel') {  // Another slice came meanwhile.
      this.region_ = null;
    } else {
      region.voxels = [region.voxels[0], voxel ?? region.voxels[1]];
      if (isEnd) {
        this.region_ = null;
        this.keep_(region, view, volume);
      }
    }
    this.changed_();
  }

  /**
   * @private
   * @param {Mark} region
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  keep_({kind, voxels: [a, b], slice}, view, volume) {
    try {
      const {values, area_mm2} = view.valuesIn(kind, a, b);
      this.add_({kind, points_mm: [toPatient(volume, a), toPatient(volume, b)], value: area_mm2,
        slice, values: valuesOf(values)});
    } catch (empty) {
      this.message_.fail(sentenceOf(empty));
    }
  }

  /**
   * @private
   * @param {Omit<Measure, 'name'>} measure
   */
  add_(measure) {
    const refusal = this.app_.measures.add(measure);
    if (refusal) {
      this.message_.fail(refusal);
      return refusal;
    }
    const unit = this.app_.store.state?.volume?.unit ?? '';
    this.message_.say(measure.values
      ? `${measureText(measure)}: ${valuesText(measure.values, unit)}.`
      : `${measureText(measure)}. The tab Measure lists all measurements.`);
    return '';
  }
}
