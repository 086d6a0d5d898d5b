// Measuring on slices: distances, angles and paths from point to point, regions by dragging.
import {h} from '../elements/dom.js';
import {sentenceOf} from '../panel/panel_parts.js';
import {KIND_TITLES, POINTS, angleOf, lengthOf, measureText, valuesOf, valuesText}
  from '../panel/measures.js';
import {toPatient, toVoxel} from './patient_grid.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
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

const NEXT = ['', 'Click the second point, in any slice.', 'Click the third point, in any slice.'];

/** @param {Kind} kind */
const isRegion = kind => kind === 'ellipse' || kind === 'rectangle';

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
    /** Places of the clicks so far, mm. @private @type {Vector[]} */ this.points_ = [];
    /** Whether the points are those of a path. @private */ this.isPath_ = false;
    /** The region that is being drawn. @private @type {Mark | null} */ this.region_ = null;
    this.kind = h('select', {'aria-label': 'What to measure', hidden: true,
      'data-testid': 'slices-kind', onchange: () => {
        this.finish();
        this.done.hidden = this.kind_() !== 'path';
        this.message_.say(isRegion(this.kind_()) ? 'Drag from corner to corner.'
          : 'Click the first point.');
      }},
    ...Object.entries(KIND_TITLES).map(([value, title]) => h('option', {value}, title)));
    this.done = h('button', {type: 'button', disabled: true, hidden: true,
      'data-testid': 'slices-path-done', onclick: () => this.finish()}, 'End path');
  }

  /** @private */
  kind_() {
    return /** @type {Kind} */ (this.kind.value);
  }

  /** @param {boolean} isOn  Whether the tool is chosen. */
  show(isOn) {
    this.kind.hidden = !isOn;
    this.done.hidden = !isOn || this.kind_() !== 'path';
    this.finish();
  }

  /** Forgets the points so far. */
  forget() {
    this.points_ = [];
    this.region_ = null;
    this.done.disabled = true;
    this.changed_();
  }

  /** Keeps a path of two or more points, and forgets others that are not whole. */
  finish() {
    const points = this.points_;
    this.forget();
    if (this.isPath_ && points.length > 1) {
      this.add_({kind: 'path', points_mm: points, value: lengthOf(points)});
    }
  }

  /**
   * @param {import('./slice_view.js').Phase} phase
   * @param {Vector | null} voxel     Not rounded; null outside of the slice.
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  take(phase, voxel, view, volume) {
    const kind = this.kind_();
    if (isRegion(kind)) {
      this.drag_(phase, kind, voxel, view, volume);
    } else if (phase === 'press' && voxel) {
      void this.click_(kind, toPatient(volume, voxel));
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
    return [...marks, ...this.region_ ? [this.region_] : [], ...this.points_.length > 0
      ? [{kind: this.kind_(), voxels: voxels(this.points_), text: ''}] : []];
  }

  /**
   * @private
   * @param {Kind} kind
   * @param {Vector} p_mm
   */
  async click_(kind, p_mm) {
    const points = [...this.points_, p_mm];
    const isWhole = points.length === POINTS[kind];
    this.points_ = isWhole ? [] : points;
    this.isPath_ = kind === 'path';
    this.done.disabled = points.length < 2;
    this.message_.say(kind === 'path' ? `${measureText({kind, value: lengthOf(points)})} so far.`
      : isWhole ? '' : NEXT[points.length]);
    this.changed_();
    if (isWhole && kind === 'angle') {
      try {
        this.add_({kind, points_mm: points, value: angleOf(points)});
      } catch (error) {
        this.message_.fail(sentenceOf(error));
      }
    } else if (isWhole) {
      const {ok, error = '', result} = await this.app_.connection.do(
        `measure ${points[0].join(',')} ${p_mm.join(',')}`, {quiet: true});
      if (ok) {
        this.add_({kind: 'distance', points_mm: [result.a_mm, result.b_mm],
          value: result.distance_mm});
      } else {
        this.message_.fail(error);
      }
    }
  }

  /**
   * @private
   * @param {import('./slice_view.js').Phase} phase
   * @param {Kind} kind
   * @param {Vector | null} voxel     Outside of the slice, the last one counts.
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  drag_(phase, kind, voxel, view, volume) {
    const slice = view.shown;
    if (phase === 'press') {
      this.region_ = slice && voxel && {kind, voxels: [voxel, voxel], slice, text: ''};
    }
    const region = this.region_;
    const isSame = region?.slice?.axis === slice?.axis && region?.slice?.index === slice?.index;
    if (!region || !isSame || phase === 'cancel') {  // Another slice came meanwhile.
      this.region_ = null;
    } else {
      region.voxels = [region.voxels[0], voxel ?? region.voxels[1]];
      if (phase === 'release') {
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
  keep_({kind, voxels, slice}, view, volume) {
    const [a, b] = voxels;
    try {
      const {values, area_mm2} = view.valuesIn(kind, a, b);
      this.add_({kind, points_mm: [toPatient(volume, a), toPatient(volume, b)], value: area_mm2,
        slice, values: valuesOf(values)});
    } catch (error) {
      this.message_.fail(sentenceOf(error));
    }
  }

  /**
   * @private
   * @param {Omit<Measure, 'name'>} measure
   */
  add_(measure) {
    try {
      this.app_.measures.add(measure);
    } catch (error) {
      this.message_.fail(sentenceOf(error));
      return;
    }
    const unit = this.app_.store.state?.volume?.unit ?? '';
    this.message_.say(measure.values
      ? `${measureText(measure)}: ${valuesText(measure.values, unit)}.`
      : `${measureText(measure)}. The tab Measure lists all measurements.`);
  }
}
