// The measurements of the user, which panels and slices add, show and remove.

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {'distance' | 'angle' | 'path' | 'ellipse' | 'rectangle'} Kind */

/**
 * Values of the voxels in a region.
 * @typedef {{voxels: number, mean: number, deviation: number, least: number, most: number}} Values
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
export const POINTS = {distance: 2, angle: 3, path: Infinity, ellipse: 2, rectangle: 2};

/** @type {Record<Kind, string>} */
export const KIND_TITLES = {distance: 'Distance', angle: 'Angle', path: 'Path',
  ellipse: 'Ellipse', rectangle: 'Rectangle'};

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
   * @param {Omit<Measure, 'name'>} measure
   * @throws {Error} if there are too many
   */
  add(measure) {
    if (this.list.length >= MOST_MEASURES) {
      throw new Error(`There are ${MOST_MEASURES} measurements, which is the limit. ` +
        'Delete one first.');
    }
    this.set_([...this.list, {name: String(++this.count_), ...measure}]);
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
    deviation: Math.sqrt(squares / Math.max(1, values.length - 1)),
    least: values.reduce((a, b) => Math.min(a, b)), most: values.reduce((a, b) => Math.max(a, b))};
}

/** @param {Kind} kind */
export function unitOf(kind) {
  return kind === 'angle' ? '°' : kind === 'distance' || kind === 'path' ? 'mm' : 'mm²';
}

/** @param {Pick<Measure, 'kind' | 'value'>} measure */
export function measureText({kind, value}) {
  const digits = value.toFixed(value < 100 || kind === 'angle' ? 1 : 0);
  return kind === 'angle' ? `${digits}°` : `${digits} ${unitOf(kind)}`;
}

/**
 * "mean 41.2, deviation 8.1, 12 to 60 HU, 314 voxels"
 * @param {Values} values
 * @param {string} unit
 */
export function valuesText({voxels, mean, deviation, least, most}, unit) {
  const [m, d, a, b] = [mean, deviation, least, most].map(each => Number(each.toPrecision(4)));
  return `mean ${m}, deviation ${d}, ${a} to ${b}${unit ? ` ${unit}` : ''}, ` +
    `${voxels.toLocaleString('en')} ${voxels === 1 ? 'voxel' : 'voxels'}`;
}

const COLUMNS = ['name', 'kind', 'value', 'unit', 'points_mm_LPS', 'slice', 'voxels', 'mean',
  'standard_deviation', 'minimum', 'maximum', 'value_unit'];

/**
 * One line per measurement, for spreadsheets.
 * @param {Measure[]} measures
 * @param {string} unit     Of the volume's values.
 */
export function csvOf(measures, unit) {
  const lines = measures.map(({name, kind, value, points_mm, slice, values}) => [name, kind, value,
    kind === 'angle' ? 'degrees' : kind === 'distance' || kind === 'path' ? 'mm' : 'mm2',
    points_mm.map(p => p.join(' ')).join('; '), slice ? `${slice.axis} ${slice.index}` : '',
    ...values ? [values.voxels, values.mean, values.deviation, values.least, values.most, unit]
      : ['', '', '', '', '', '']]);
  const cell = (/** @type {unknown} */ each) => /[",\n]/.test(String(each))
    ? `"${String(each).replaceAll('"', '""')}"` : String(each);
  return [COLUMNS, ...lines].map(line => `${line.map(cell).join(',')}\r\n`).join('');
}

/**
 * The same as JSON.
 * @param {Measure[]} measures
 * @param {{name: string, unit: string}} volume
 */
export function jsonOf(measures, {name, unit}) {
  return `${JSON.stringify({volume: name, value_unit: unit, measurements: measures.map(each => ({
    ...each, unit: each.kind === 'angle' ? 'degrees' : unitOf(each.kind).replace('²', '2'),
  }))}, null, 2)}\n`;
}
