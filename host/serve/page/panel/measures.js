// The measurements of the user, which panels and slices add, show and remove.

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {'distance' | 'angle' | 'path' | 'ellipse' | 'rectangle'} Kind */

/**
 * Values of the voxels in a region. A single voxel has no deviation.
 * @typedef {{voxels: number, mean: number, deviation: number | null, least: number, most: number}}
 *   Values
 */

/**
 * @typedef {object} Measure
 * @property {string} name          Counts from 1.
 * @property {Kind} kind
 * @property {Triple[]} points_mm   LPS. Distance: both ends. Angle: its vertex is the second. Path:
 *     all corners. Ellipse and rectangle: two opposite corners of the box around them.
 * @property {number} value         Distance, path: mm. Angle: degrees. Others: mm².
 * @property {{axis: 'x' | 'y' | 'z', index: number}} [slice]  Of an ellipse or a rectangle.
 * @property {Values} [values]      Likewise.
 */

export const MOST_MEASURES = 100;

/** How many points end a measurement; a path ends when the user says so. */
const POINTS = {distance: 2, angle: 3, path: Infinity, ellipse: 2, rectangle: 2};
const ORDINALS = ['first', 'second', 'third'];

/** @type {Record<Kind, string>} */
export const KIND_TITLES = {distance: 'Distance', angle: 'Angle', path: 'Path',
  ellipse: 'Ellipse', rectangle: 'Rectangle'};

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
    return {kind, points_mm, value: kind === 'angle' ? angleOf(points_mm) : lengthOf(points_mm)};
  }

  /** "Click the second point.", "12.3 mm so far."; empty without points. */
  get sentence() {
    return this.list.length === 0 ? ''
      : this.kind === 'path' ? `${measureText({kind: 'path', value: lengthOf(this.list)})} so far.`
        : `Click the ${ORDINALS[this.list.length]} point.`;
  }
}

export class Measures {
  constructor() {
    /** @type {Measure[]} */
    this.list = [];
    /** @private */ this.count_ = 0;
    /** @private @type {Set<() => void>} */ this.watchers_ = new Set();
  }

  /** @param {() => void} act  Called now and at each change. */
  watch(act) {
    this.watchers_.add(act);
    act();
  }

  /**
   * Returns why the measurement is not kept; empty if it is.
   * @param {Omit<Measure, 'name'>} measure
   */
  add(measure) {
    if (this.list.length >= MOST_MEASURES) {
      return `There are ${MOST_MEASURES} measurements, which is the limit. Delete one first.`;
    }
    this.set_([...this.list, {name: String(++this.count_), ...measure}]);
    return '';
  }

  /** @param {Measure} measure */
  remove(measure) {
    this.set_(this.list.filter(each => each !== measure));
  }

  /** Removes all, because another volume is open. */
  clear() {
    this.set_([]);
  }

  /** @param {any[]} saved  What `list` was in a saved session; earlier ones had distances alone. */
  restore(saved) {
    this.count_ = Math.max(0, ...saved.map(({name}) => Number(name)));
    this.set_(saved.map(each => each.kind ? each : {name: each.name, kind: 'distance',
      points_mm: [each.a_mm, each.b_mm], value: each.distance_mm}));
  }

  /**
   * @private
   * @param {Measure[]} list
   */
  set_(list) {
    this.list = list;
    this.watchers_.forEach(act => act());
  }
}

/**
 * The length of a path through points.
 * @param {Triple[]} points_mm
 */
export function lengthOf(points_mm) {
  return points_mm.slice(1).reduce((sum, p, k) => sum + Math.hypot(p[0] - points_mm[k][0],
    p[1] - points_mm[k][1], p[2] - points_mm[k][2]), 0);
}

/**
 * The angle at the second of three points, in degrees.
 * @param {Triple[]} points_mm
 * @throws {Error} if the vertex is one of the others
 */
export function angleOf([a, vertex, b]) {
  const from = (/** @type {Triple} */ p) => p.map((value, k) => value - vertex[k]);
  const [u, v] = [from(a), from(b)];
  const lengths = Math.hypot(...u) * Math.hypot(...v);
  if (lengths === 0) {
    throw new Error('Two points of the angle are the same. Click three different points.');
  }
  // By sine and cosine: the cosine alone is inexact near 0 and 180 degrees.
  const cross = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
    u[0] * v[1] - u[1] * v[0]);
  return Math.atan2(cross, u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * 180 / Math.PI;
}

/**
 * Mean, standard deviation (divided by n - 1), least and largest value.
 * @param {number[]} values
 * @returns {Values}
 * @throws {Error} without values
 */
export function valuesOf(values) {
  if (values.length === 0) {
    throw new Error('The region holds the middle of no voxel. Draw a larger region.');
  }
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const squares = values.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return {voxels: values.length, mean,
    deviation: values.length > 1 ? Math.sqrt(squares / (values.length - 1)) : null,
    least: values.reduce((a, b) => Math.min(a, b)), most: values.reduce((a, b) => Math.max(a, b))};
}

/**
 * Units as files have them.
 * @param {Kind} kind
 */
function unitOf(kind) {
  return kind === 'angle' ? 'degrees' : isRegion(kind) ? 'mm2' : 'mm';
}

/** @param {Pick<Measure, 'kind' | 'value'>} measure */
export function measureText({kind, value}) {
  if (kind === 'angle') {
    return `${value.toFixed(1)}°`;
  }
  const digits = value < 1 ? Number(value.toPrecision(2)) : value.toFixed(value < 100 ? 1 : 0);
  return `${digits} ${isRegion(kind) ? 'mm²' : 'mm'}`;
}

/**
 * "mean 41.2, deviation 8.1, 12 to 60 HU, 314 voxels"
 * @param {Values} values
 * @param {string} unit
 */
export function valuesText({voxels, mean, deviation, least, most}, unit) {
  const digits = (/** @type {number} */ value, /** @type {number} */ count) =>
    Number(value.toPrecision(count));
  const spread = deviation === null ? '' : `, deviation ${digits(deviation, 4)}`;
  const count = `${voxels.toLocaleString('en')} ${voxels === 1 ? 'voxel' : 'voxels'}`;
  return `mean ${digits(mean, 4)}${spread}, ${digits(least, 6)} to ${digits(most, 6)}` +
    `${unit ? ` ${unit}` : ''}, ${count}`;
}

const COLUMNS = ['volume', 'name', 'kind', 'value', 'unit', 'points_mm_LPS', 'voxel_axis',
  'voxel_index', 'voxels', 'mean', 'deviation', 'least', 'most', 'value_unit'];

/**
 * One line per measurement, for spreadsheets. Voxels count from 0, as in the line below the slices.
 * @param {Measure[]} measures
 * @param {{name: string, unit: string}} volume
 */
export function csvOf(measures, volume) {
  const lines = measures.map(({name, kind, value, points_mm, slice, values}) => [volume.name, name,
    kind, value, unitOf(kind), points_mm.map(p => p.join(' ')).join('; '),
    ...slice ? [slice.axis, slice.index] : ['', ''],
    ...values ? [values.voxels, values.mean, values.deviation ?? '', values.least, values.most,
      volume.unit] : ['', '', '', '', '', '']]);
  const cell = (/** @type {unknown} */ each) => /[",\r\n]/.test(String(each))
    ? `"${String(each).replaceAll('"', '""')}"` : String(each);
  return [COLUMNS, ...lines].map(line => `${line.map(cell).join(',')}\r\n`).join('');
}

/**
 * The same as JSON.
 * @param {Measure[]} measures
 * @param {{name: string, unit: string}} volume
 */
export function jsonOf(measures, {name, unit}) {
  return `${JSON.stringify({volume: name, value_unit: unit, positions: 'mm, LPS',
    measurements: measures.map(({slice, ...measure}) => ({...measure, unit: unitOf(measure.kind),
      ...slice && {voxel_axis: slice.axis, voxel_index: slice.index}}))}, null, 2)}\n`;
}
