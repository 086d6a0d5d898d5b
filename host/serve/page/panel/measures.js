// The measurements of the user, which panels and slices add, show and remove.
import {grouped, significant} from '../elements/numbers.js';
import {say} from '../texts/say.js';
import {angleOf, lengthOf} from './measure_math.js';
import {addTitle} from './measure_words.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {'distance' | 'angle' | 'path' | 'ellipse' | 'rectangle' | 'part' | 'note'} Kind */

/**
 * Values of the voxels in a region. A single voxel has no deviation.
 * @typedef {{voxels: number, mean: number, deviation: number | null, least: number, most: number}}
 *   Values
 */

/**
 * Where a region lies. Its values are those of a slab if the slice was shown so.
 * @typedef {{axis: 'x' | 'y' | 'z', index: number, slab_mm?: number,
 *   slab_kind?: 'max' | 'mean' | 'min'}} MeasuredSlice
 */

/**
 * A component of a surface as it was then. The faces of the scan close it if it is not closed.
 * @typedef {{surface: string, isovalue: number, cavity: boolean, closed: boolean,
 *   area_mm2: number}} Part
 */

/**
 * @typedef {object} Measure
 * @property {string} name          Counts from 1, unless the user changes it; no other has it.
 * @property {Kind} kind
 * @property {Triple[]} points_mm   LPS. Distance: both ends. Angle: its vertex is the second. Path:
 *     all corners. Ellipse and rectangle: two opposite corners of the box around them. Note: the
 *     place that its arrow points to. Part: a point of its surface.
 * @property {number} value         Distance, path: mm. Angle: degrees. Part: ml. Note: 0. Others:
 *     mm².
 * @property {string} [text]        Of a note.
 * @property {Part} [part]
 * @property {MeasuredSlice} [slice]  Of an ellipse or a rectangle.
 * @property {Values} [values]      Likewise.
 * @property {number} [frame]       Number of its volume in a time series; absent without one.
 */

export const MOST_MEASURES = 100;
export const MOST_LETTERS = 60;     // Of a name.
export const MOST_NOTE = 200;   // Letters.
const MOST_CHANGES = 500;   // That undo takes back, as of the scene.

/** How many points end a measurement; a path ends when the user says so. */
export const POINTS = {distance: 2, angle: 3, path: Infinity, ellipse: 2, rectangle: 2, part: 1,
  note: 1};

/** @type {Record<Kind, string>} */
export const KIND_TITLES = {distance: say`Distance`, angle: say`Angle`, path: say`Path`,
  ellipse: say`Ellipse`, rectangle: say`Rectangle`, part: say`Part`, note: say`Note`};

/** Why the page refuses to move the place of a part. */
export const PART_STAYS = say`The place of a part stays. Measure another part by a click on it.`;

/**
 * Whether values of voxels belong to this kind.
 * @param {Kind} kind
 * @returns {kind is 'ellipse' | 'rectangle'}
 */
export function isRegion(kind) {
  return kind === 'ellipse' || kind === 'rectangle';
}

/** The points of a distance, an angle or a path that the user makes, one by one. */
export class Points {
  /** @param {Kind} kind */
  constructor(kind) {
    this.kind = kind;
    /** @type {Triple[]} */
    this.list = [];
  }

  /**
   * Takes the next point. Returns the measurement if this was the last point.
   * @param {Triple} p_mm
   * @throws {Error} as angleOf()
   */
  take(p_mm) {
    this.list = [...this.list, p_mm];
    return this.list.length === POINTS[this.kind] ? this.whole_() : null;
  }

  /** Ends a path. Returns it if it has two points or more; other kinds are forgotten. */
  end() {
    if (this.kind === 'path' && this.list.length > 1) {
      return this.whole_();
    }
    this.list = [];
    return null;
  }

  /** @private */
  whole_() {
    const {kind, list: points_mm} = this;
    this.list = [];
    return through(kind, points_mm);
  }

  /** "Click the second point.", "12.3 mm so far."; empty without points. */
  get sentence() {
    const {kind, list} = this;
    return list.length === 0 ? ''
      : kind === 'path' ? say`${measureText({kind, value: lengthOf(list)})} so far.`
        : list.length === 1 ? say`Click the second point.` : say`Click the third point.`;
  }
}

/**
 * The list beside a change.
 * @typedef {object} Change
 * @property {readonly Measure[]} list
 * @property {string} title     What was done.
 * @property {number} step      Number of the scene's step then.
 */

export class Measures {
  constructor() {
    /** @type {readonly Measure[]} */
    this.list = [];
    /** The shown volume of a time series; empty without one. @type {{frame?: number}} */
    this.time = {};
    /** Name of the measurement whose ends the lists show, '' for none. */
    this.chosen = '';
    /** The number of the scene's step now. Called before each change that can be undone. */
    this.clock = () => 0;
    /**
     * Changes that undo() and redo() would make, the next one last.
     * @type {{undo: Change[], redo: Change[]}}
     */
    this.changed = {undo: [], redo: []};
    /** Number of undos and redos so far. */
    this.jumps = 0;
    /** @private */ this.count_ = 0;
    /** @private @type {Set<() => void>} */ this.watchers_ = new Set();
    /** The list before a drag. @private @type {Pick<Change, 'list' | 'title'> | null} */
    this.held_ = null;
  }

  /** @param {() => void} act  Called now and at each change. */
  watch(act) {
    this.watchers_.add(act);
    act();
  }

  /** Those of the shown volume. */
  get seen() {
    return this.list.filter(measure => this.isSeen(measure));
  }

  /** @param {Measure} measure */
  isSeen({frame}) {
    return frame === undefined || frame === this.time.frame;
  }

  /** @param {import('../link/vocabulary.js').State['volume']} volume  It is shown now. */
  show(volume) {
    const frame = volume && volume.frames > 1 ? volume.frame : undefined;
    if (frame !== this.time.frame) {
      this.time = frame === undefined ? {} : {frame};
      this.set_(this.list);
    }
  }

  /** @param {string} name */
  named(name) {
    return this.list.find(each => each.name === name) ?? null;
  }

  /** @param {string} name  '' for none. */
  choose(name) {
    this.chosen = name;
    this.set_(this.list);
  }

  /**
   * Returns why the measurement is not kept; empty if it is.
   * @param {Omit<Measure, 'name'>} measure
   */
  add(measure) {
    if (this.list.length >= MOST_MEASURES) {
      return say`There are ${MOST_MEASURES} measurements, which is the limit. Delete one first.`;
    }
    do {
      ++this.count_;
    } while (this.named(String(this.count_)));
    const name = String(this.count_);
    this.change_(addTitle(measure.kind, name), [...this.list, {name, ...measure, ...this.time}]);
    return '';
  }

  /** @param {string} name */
  remove(name) {
    this.change_(say`delete measurement ${name}`, this.list.filter(each => each.name !== name));
  }

  /** Removes all; undo() brings them back. */
  removeAll() {
    this.change_(say`delete all measurements`, []);
  }

  /**
   * Returns why the measurement keeps its name; empty if it has the new one.
   * @param {string} name
   * @param {string} wanted
   */
  rename(name, wanted) {
    const next = wanted.trim().slice(0, MOST_LETTERS);
    if (next === name) {
      return '';
    }
    if (next === '' || this.named(next)) {
      return next === '' ? say`Measurement ${name}: the name is empty. Type a name.`
        : say`There is already a measurement ${next}. Choose another name for ${name}.`;
    }
    const list = this.list.map(each => each.name === name ? {...each, name: next} : each);
    this.chosen = this.chosen === name ? next : this.chosen;
    this.change_(say`rename measurement ${name} to ${next}`, list);
    return '';
  }

  /**
   * Changes the text of a note; an empty one is not taken.
   * @param {string} name
   * @param {string} wanted
   */
  write(name, wanted) {
    const text = wanted.trim().slice(0, MOST_NOTE);
    if (text !== '' && text !== this.named(name)?.text) {
      this.change_(say`change note ${name}`,
        this.list.map(each => each.name === name ? {...each, text} : each));
    }
  }

  /**
   * Shows other points of a measurement while an end is dragged.
   * @param {string} name
   * @param {Partial<Measure>} changed
   */
  drag(name, changed) {
    this.held_ ??= {list: this.list, title: say`move an end of measurement ${name}`};
    this.set_(this.list.map(each => each.name === name ? {...each, ...changed} : each));
  }

  /** Ends a drag: the points stay. */
  drop() {
    const [held, now] = [this.held_, this.list];
    this.held_ = null;
    if (held) {
      this.list = held.list;
      this.change_(held.title, now);
    }
  }

  /** Ends a drag: the points from before the drag return. */
  putBack() {
    if (this.held_) {
      const {list} = this.held_;
      this.held_ = null;
      this.set_(list);
    }
  }

  undo() {
    this.jumps += 1;
    this.go_(this.changed.undo, this.changed.redo);
  }

  redo() {
    this.jumps += 1;
    this.go_(this.changed.redo, this.changed.undo);
  }

  /** A new step of the scene has taken the place of undone changes. */
  forgetUndone() {
    this.changed.redo = [];
  }

  /** Removes all for good, because another volume is open. */
  clear() {
    this.restore([]);
  }

  /** @param {Measure[]} saved  See checked(). */
  restore(saved) {
    this.count_ = Math.max(0, ...saved.map(({name}) => Number(name)).filter(Number.isFinite));
    this.chosen = '';
    this.held_ = null;
    this.changed = {undo: [], redo: []};
    this.set_(saved);
  }

  /**
   * @private
   * @param {string} title
   * @param {readonly Measure[]} list
   */
  change_(title, list) {
    this.drop();
    const undo = [...this.changed.undo, {list: this.list, title, step: this.clock()}];
    this.changed = {undo: undo.slice(-MOST_CHANGES), redo: []};
    this.set_(list);
  }

  /**
   * @private
   * @param {Change[]} from
   * @param {Change[]} to
   */
  go_(from, to) {
    const change = from.pop();
    if (change) {
      to.push({...change, list: this.list});
      this.chosen = change.list.some(({name}) => name === this.chosen) ? this.chosen : '';
      this.set_(change.list);
    }
  }

  /**
   * @private
   * @param {readonly Measure[]} list
   */
  set_(list) {
    this.list = list;
    this.watchers_.forEach(act => act());
  }
}

/**
 * A distance, an angle, a path or a note through other points.
 * @param {Kind} kind
 * @param {Triple[]} points_mm
 * @throws {Error} as angleOf()
 */
export function through(kind, points_mm) {
  return {kind, points_mm, value: kind === 'angle' ? angleOf(points_mm) : lengthOf(points_mm)};
}

/**
 * What a slice and the picture write beside a measurement.
 * @param {Measure} measure
 */
export function labelText(measure) {
  return measure.kind === 'note' ? measureText(measure)
    : `${measure.name}: ${measureText(measure)}`;
}

/**
 * What a point of a measurement is called: "First end", "Vertex", "Corner 2".
 * @param {Kind} kind
 * @param {number} index
 * @param {number} count  Number of points.
 */
export function endTitle(kind, index, count) {
  if (isRegion(kind)) {
    return say`Corner ${index + 1}`;
  }
  if (kind === 'note' || kind === 'part') {
    return say`Place`;
  }
  if (kind === 'angle' && index === 1) {
    return say`Vertex`;
  }
  return index === 0 ? say`First end`
    : index === count - 1 ? say`Last end` : say`Point ${index + 1}`;
}

/** @param {Pick<Measure, 'kind' | 'value' | 'text'>} measure */
export function measureText({kind, value, text = ''}) {
  if (kind === 'note') {
    return text;
  }
  if (kind === 'angle') {
    return `${grouped(value, 1)}°`;
  }
  const digits = value < 1 ? significant(value, 2) : grouped(value, value < 100 ? 1 : 0);
  return `${digits} ${kind === 'part' ? 'ml' : isRegion(kind) ? 'mm²' : 'mm'}`;
}
