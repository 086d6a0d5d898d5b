// Checks the measurements of a session's file, which anybody may have written.
import {grouped} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';
import {KIND_TITLES, MOST_LETTERS, MOST_MEASURES, MOST_NOTE, POINTS, isRegion, through}
  from './measures.js';
import {shown} from './panel_parts.js';

/** @typedef {import('./measures.js').Measure} Measure */

const LEAST_OF_PATH = 2;     // Points.
const MOST_POINTS = 10_000;  // Of a path.
const SLAB_KINDS = ['mean', 'max', 'min'];

const isNumber = (/** @type {unknown} */ value) => Number.isFinite(value);
const isText = (/** @type {unknown} */ value, /** @type {number} */ most) =>
  typeof value === 'string' && value.trim() !== '' && value.length <= most;
const isPoint = (/** @type {unknown} */ value) =>
  Array.isArray(value) && value.length === 3 && value.every(isNumber);

/** @type {Record<string, {isRight: (value: unknown) => boolean, needed: string}>} */
const PART_FIELDS = {
  surface: {isRight: value => typeof value === 'string' && value !== '',
    needed: say`the name of a surface`},
  isovalue: {isRight: isNumber, needed: say`a number`},
  cavity: {isRight: value => typeof value === 'boolean', needed: say`true or false`},
  closed: {isRight: value => typeof value === 'boolean', needed: say`true or false`},
  area_mm2: {isRight: value => isNumber(value) && Number(value) >= 0,
    needed: say`a number of 0 or more`},
};

/**
 * The measurements that are right, and an error for each of the others.
 * @param {unknown} saved  Earlier sessions had distances alone.
 * @returns {{list: Measure[], errors: string[]}}
 */
export function checked(saved) {
  if (!Array.isArray(saved)) {
    return {list: [], errors: [say`measurements is ${shown(saved)}, but a list is needed.`]};
  }
  /** @type {Measure[]} */
  const list = [];
  const errors = saved.flatMap((each, index) => {
    const measure = each && each.kind === undefined && each.a_mm ? {name: each.name,
      kind: 'distance', points_mm: [each.a_mm, each.b_mm], value: each.distance_mm} : each;
    const error = list.length >= MOST_MEASURES
      ? say`there are ${saved.length} measurements, but at most ${MOST_MEASURES} are kept.`
      : errorOf(measure, list);
    if (error === '') {
      list.push(cleaned(measure));
      return [];
    }
    const name = isText(each?.name, MOST_LETTERS) ? each.name : say`number ${index + 1}`;
    return [say`Measurement ${name} was left out: ${error}`];
  });
  return {list, errors};
}

/**
 * A right measurement without fields that do not belong to its kind.
 * @param {Measure} measure
 * @returns {Measure}
 */
function cleaned({frame, ...measure}) {
  return {...withoutOthers(measure), ...frame !== undefined && {frame}};
}

/**
 * @param {Omit<Measure, 'frame'>} measure
 * @returns {Measure}
 */
function withoutOthers({name, kind, points_mm, value, text, slice, values, part}) {
  const fields = Object.keys(PART_FIELDS).map(field =>
    [field, part?.[/** @type {keyof import('./measures.js').Part} */ (field)]]);
  return isRegion(kind) ? {name, kind, points_mm, value, slice, values}
    : kind === 'part' ? {name, kind, points_mm, value, part: Object.fromEntries(fields)}
    : kind === 'note' ? {name, kind, points_mm, value: 0, text}
      : {name, ...through(kind, points_mm)};
}

/**
 * What is wrong with a measurement; empty for nothing.
 * @param {any} measure
 * @param {Measure[]} before
 */
function errorOf(measure, before) {
  if (typeof measure !== 'object' || measure === null) {
    return say`it is ${shown(measure)}, but an object is needed.`;
  }
  const {name, kind, points_mm, value, text, slice, values, part, frame} = measure;
  const needs = (/** @type {string} */ field, /** @type {unknown} */ is,
    /** @type {string} */ what) => say`${field} is ${shown(is)}, but ${what} is needed.`;
  if (!isText(name, MOST_LETTERS) || before.some(each => each.name === name)) {
    return needs('name', name, say`a text of its own with at most ${MOST_LETTERS} letters`);
  }
  if (!Object.keys(KIND_TITLES).includes(kind)) {
    return needs('kind', kind, say`one of ${Object.keys(KIND_TITLES).join(', ')}`);
  }
  const isPath = kind === 'path';
  const count = isPath ? LEAST_OF_PATH : POINTS[/** @type {keyof typeof POINTS} */ (kind)];
  const isMany = Array.isArray(points_mm) && points_mm.length <= MOST_POINTS
    && (isPath ? points_mm.length >= count : points_mm.length === count);
  if (!isMany || !points_mm.every(isPoint)) {
    return needs('points_mm', points_mm,
      isPath ? say`a list of at least ${grouped(count)} points with 3 numbers each`
        : plural(count, say`a list of 1 point with 3 numbers each`,
          say`a list of ${grouped(count)} points with 3 numbers each`));
  }
  if (!isNumber(value) || value < 0) {
    return needs('value', value, say`a number of 0 or more`);
  }
  if (frame !== undefined && !(Number.isInteger(frame) && frame >= 1)) {
    return needs('frame', frame, say`the number of a volume, from 1`);
  }
  if (kind === 'note' && !isText(text, MOST_NOTE)) {
    return needs('text', text, say`a text with at most ${MOST_NOTE} letters`);
  }
  if (kind === 'part') {
    const wrong = Object.entries(PART_FIELDS).find(([field, {isRight}]) =>
      !isRight(part?.[field]));
    return wrong ? needs(`part.${wrong[0]}`, part?.[wrong[0]], wrong[1].needed) : '';
  }
  if (!isRegion(kind)) {
    return slice !== undefined || values !== undefined
      ? needs('slice', slice ?? values, say`none for this kind`)
      : kind === 'note' ? '' : differenceOf(measure);
  }
  if (!['x', 'y', 'z'].includes(slice?.axis) || !Number.isInteger(slice.index) || slice.index < 0) {
    return needs('slice', slice, say`an axis x, y or z and an index of 0 or more`);
  }
  if (slice.slab_mm !== undefined && !(isNumber(slice.slab_mm) && slice.slab_mm >= 0
    && SLAB_KINDS.includes(slice.slab_kind))) {
    return needs('slice', slice, say`slab_mm of 0 or more and slab_kind mean, max or min`);
  }
  const wrong = ['voxels', 'mean', 'deviation', 'least', 'most'].find(field =>
    !isNumber(values?.[field]) && !(field === 'deviation' && values?.deviation === null));
  return wrong ? needs(`values.${wrong}`, values?.[wrong], say`a number`) : '';
}

const ROUNDING = 1e-3;      // Share of a value by which a file may round it.

/**
 * How the value of a distance, an angle or a path differs from that of its points; empty if not.
 * @param {Measure} measure
 */
function differenceOf({kind, points_mm, value}) {
  try {
    const own = through(kind, points_mm).value;
    return Math.abs(own - value) <= ROUNDING * Math.max(own, 1) ? ''
      : say`value is ${shown(value)}, but its points give ${shown(own)}.`;
  } catch (error) {
    return /** @type {Error} */ (error).message;
  }
}
