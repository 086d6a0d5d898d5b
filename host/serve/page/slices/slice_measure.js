// Measuring on slices: distances, angles and paths from point to point, regions by dragging.
import {h} from '../elements/dom.js';
import {MeasureList} from '../panel/measure_list.js';
import {slabNote, valuesText} from '../panel/measure_words.js';
import {KIND_TITLES, PART_STAYS, Points, isRegion, labelText, measureText}
  from '../panel/measures.js';
import {sentenceOf} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';
import {toPatient, toVoxel} from './patient_grid.js';
import {movedTo, regionOf} from './slice_ends.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_input.js').Phase} Phase */
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
 * @property {Measure['slice']} [slice]  The only slice that shows it.
 * @property {string} [name]    Of the measurement; none as long as the user makes it.
 */

/**
 * What the panel of the slices does for measurements.
 * @typedef {object} Panel
 * @property {() => void} changed               Other marks are to be shown.
 * @property {(voxel: Vector) => void} point    Moves the crosshair.
 * @property {() => SliceView[]} views          The large one first.
 */

const ASIDE = 22;           // From the point of a note to the field, CSS pixels.
const LATER = say`The slice of this end is not shown yet. Press the key again.`;

export class SliceMeasure {
  /**
   * @param {import('../panel/app.js').App} app
   * @param {{say: (text: string) => void, fail: (text: string) => void}} message
   * @param {Panel} panel
   */
  constructor(app, message, panel) {
    /** @private */ this.app_ = app;
    /** @private */ this.message_ = message;
    /** @private */ this.panel_ = panel;
    /** @private */ this.points_ = new Points('distance');
    /** The region that is being drawn. @private @type {Mark | null} */ this.region_ = null;
    /** The note that is being written. @private @type {Mark | null} */ this.note_ = null;
    this.kind = h('select', {'aria-label': say`What to measure`, hidden: true,
      'data-testid': 'slices-kind', onchange: () => this.choose_()},
    ...Object.entries(KIND_TITLES).filter(([kind]) => kind !== 'part').map(([value, title]) =>
      h('option', {value}, title)));
    this.done = h('button', {type: 'button', disabled: true, hidden: true,
      'data-testid': 'slices-path-done', onclick: () => this.finish()}, say`End path`);
    this.list = new MeasureList(app, 'slices', this.mover_(), message);
    this.list.element.hidden = true;
  }

  /** @private @returns {import('../panel/measure_list.js').Mover} */
  mover_() {
    const volume = () => this.app_.store.state?.volume ?? null;
    return {
      refusal: ({kind}) => kind === 'part' ? PART_STAYS : '',
      hint: say`Arrow keys move it by a voxel, with Shift by 10, in the large slice; the corners of
        a region in its own slice.`,
      look: ({points_mm}, end) => {
        const grid = volume();
        if (grid) {
          this.panel_.point(toVoxel(grid, points_mm[end]));
        }
      },
      move: (measure, end, across, down) => {
        const grid = volume();
        if (grid) {
          this.step_(grid, measure, end, [across, down]);
        }
      },
      leave: () => this.app_.measures.drop(),
    };
  }

  /** @private */
  choose_() {
    const refusal = this.finish();
    const kind = /** @type {Kind} */ (this.kind.value);
    this.points_ = new Points(kind);
    this.done.hidden = kind !== 'path';
    if (!refusal) {
      this.message_.say(isRegion(kind) ? say`Drag from corner to corner.`
        : kind === 'note' ? say`Click a point, then type the note.` : say`Click the first point.`);
    }
  }

  /** @param {boolean} isOn  Whether the tool is chosen. */
  show(isOn) {
    this.kind.hidden = !isOn;
    this.done.hidden = !isOn || this.kind.value !== 'path';
    this.list.element.hidden = !isOn;
    this.finish();
  }

  /** Forgets the points so far. */
  forget() {
    this.points_ = new Points(this.points_.kind);
    this.region_ = null;
    this.done.disabled = true;
    this.panel_.changed();
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
    } else if (phase === 'press' && voxel && this.rewrite_(voxel, view)) {
      this.region_ = null;
    } else if (isRegion(this.points_.kind)) {
      this.drag_(phase, voxel, view, volume);
    } else if (phase === 'press' && voxel && this.points_.kind === 'note') {
      this.write_(voxel, view, volume);
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
    const marks = this.app_.measures.seen.map(measure => ({kind: measure.kind,
      voxels: voxels(measure.points_mm), slice: measure.slice,
      text: labelText(measure), name: measure.name}));
    const {kind, list} = this.points_;
    return [...marks, ...[this.region_, this.note_].filter(each => each !== null),
      ...list.length > 0 ? [{kind, voxels: voxels(list), text: ''}] : []];
  }

  /**
   * Asks for the text of a new note.
   * @private
   * @param {Vector} voxel
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  write_(voxel, view, volume) {
    const {store} = this.app_;
    this.note_ = {kind: 'note', voxels: [voxel], text: ''};
    this.panel_.changed();
    this.message_.say(say`Type the text of the note. Enter keeps it.`);
    const [x, y] = view.placeOf(voxel);
    view.edit([x + ASIDE, y - ASIDE], '', text => {
      this.note_ = null;
      if (text !== null && store.state?.volume?.identity === volume.identity) {
        this.add_({kind: 'note', points_mm: [toPatient(volume, voxel)], value: 0, text});
      }
      this.panel_.changed();
    });
  }

  /**
   * Changes the note whose text is at a place. Returns whether there is one.
   * @private
   * @param {Vector} voxel
   * @param {SliceView} view
   */
  rewrite_(voxel, view) {
    const {measures} = this.app_, [x, y] = view.placeOf(voxel);
    const found = [...view.labels].find(([name, {left, top, width, height}]) =>
      measures.named(name)?.kind === 'note' && x >= left && x <= left + width && y >= top &&
      y <= top + height);
    if (found) {
      const [name, {left, top}] = found;
      view.edit([left, top], measures.named(name)?.text ?? '', text =>
        text !== null && measures.write(name, text));
    }
    return Boolean(found);
  }

  /**
   * A pointer drags an end of a measurement.
   * @param {Phase} phase
   * @param {import('./slice_ends.js').End} end
   * @param {Vector | null} voxel     Not rounded; null if the drag stops.
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  drag(phase, {name, end}, voxel, view, volume) {
    const {measures} = this.app_, measure = measures.named(name);
    if (voxel && measure) {
      this.put_(view, volume, measure, end, voxel);
    }
    if (phase === 'release') {
      measures.drop();
    } else if (phase === 'cancel') {
      measures.putBack();
      this.message_.say(say`The end is back in its place.`);
    }
  }

  /**
   * Moves an end by voxels, and the crosshair with it.
   * @private
   * @param {VolumeState} volume
   * @param {Measure} measure
   * @param {number} end
   * @param {[number, number]} by     Across, down.
   */
  step_(volume, measure, end, [across, down]) {
    const {slice: own} = measure, voxel = toVoxel(volume, measure.points_mm[end]);
    const view = this.panel_.views().find(({shown}) => !own || shown?.axis === own.axis);
    const isShown = own ? view?.shown?.index === own.index : view?.shows(voxel);
    const to = view?.beside(voxel, across, down);
    if (!view || !to || !isShown || view.isOld) {
      this.message_.fail(LATER);
    } else if (!view.isInside(to)) {
      this.message_.fail(say`The end of measurement ${measure.name} is at the edge of the slice,
        and cannot move further.`);
    } else {
      this.put_(view, volume, measure, end, to);
      this.panel_.point(to);
    }
  }

  /**
   * @private
   * @param {SliceView} view
   * @param {VolumeState} volume
   * @param {Measure} measure
   * @param {number} end
   * @param {Vector} to
   */
  put_(view, volume, measure, end, to) {
    try {
      const changed = movedTo(view, volume, measure, end, to);
      this.app_.measures.drag(measure.name, changed);
      this.say_({...measure, ...changed});
    } catch (wrong) {
      this.message_.fail(sentenceOf(wrong));
    }
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
    this.panel_.changed();
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
      if (!this.panel_.views().includes(view)) {
        this.message_.fail(say`Regions are drawn on the other three slices.`);
      }
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
    this.panel_.changed();
  }

  /**
   * @private
   * @param {Mark} region
   * @param {SliceView} view
   * @param {VolumeState} volume
   */
  keep_({kind, voxels}, view, volume) {
    try {
      this.add_(regionOf(view, volume, kind, voxels));
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
    this.say_(measure);
    return '';
  }

  /**
   * @private
   * @param {Omit<Measure, 'name'>} measure
   */
  say_(measure) {
    const unit = this.app_.store.state?.volume?.unit ?? '';
    this.message_.say(measure.values
      ? `${measureText(measure)}: ${valuesText(measure.values, unit)}` +
        `${slabNote(measure.slice)}.`
      : say`${measureText(measure)}. The list below has all measurements.`);
  }
}
