// Kinds of measurements, and the values of a region or a part, in words.
import {grouped, significant} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';

/** @typedef {import('./measures.js').Kind} Kind */
/** @typedef {import('./measures.js').MeasuredSlice} MeasuredSlice */
/** @typedef {import('./measures.js').Part} Part */
/** @typedef {import('./measures.js').Values} Values */

/**
 * A kind inside of a line.
 * @param {Kind} kind
 */
export function kindWord(kind) {
  return {distance: say`distance`, angle: say`angle`, path: say`path`, ellipse: say`ellipse`,
    rectangle: say`rectangle`, part: say`part`, note: say`note`}[kind];
}

/**
 * What undo says of a new measurement: "add distance 3".
 * @param {Kind} kind
 * @param {string} name
 */
export function addTitle(kind, name) {
  return {distance: say`add distance ${name}`, angle: say`add angle ${name}`,
    path: say`add path ${name}`, ellipse: say`add ellipse ${name}`,
    rectangle: say`add rectangle ${name}`, part: say`add part ${name}`,
    note: say`add note ${name}`}[kind];
}

/**
 * "mean 41.2, deviation 8.1, 12 to 60 HU, 314 voxels"
 * @param {Values} values
 * @param {string} unit
 */
export function valuesText({voxels, mean, deviation, least, most}, unit) {
  const last = `${significant(most, 6)}${unit ? ` ${unit}` : ''}`;
  return [say`mean ${significant(mean, 4)}`,
    ...deviation === null ? [] : [say`deviation ${significant(deviation, 4)}`],
    say`${significant(least, 6)} to ${last}`,
    plural(voxels, say`1 voxel`, say`${grouped(voxels)} voxels`)].join(', ');
}

/**
 * ", max of a slab of 10 mm" if the values of a region are those of a slab.
 * @param {MeasuredSlice} [slice]
 */
export function slabNote(slice) {
  if (!slice?.slab_mm) {
    return '';
  }
  const mm = significant(slice.slab_mm, 4);
  const note = slice.slab_kind === 'max' ? say`max of a slab of ${mm} mm`
    : slice.slab_kind === 'min' ? say`min of a slab of ${mm} mm` : say`mean of a slab of ${mm} mm`;
  return `, ${note}`;
}

/**
 * "bone at 250.5 HU, 2,107.7 cm²", with what is special about the part.
 * @param {Part} part
 * @param {string} unit
 */
export function partText({surface, isovalue, cavity, closed, area_mm2}, unit) {
  const area_cm2 = area_mm2 / 100;
  const area = area_cm2 < 1 ? significant(area_cm2, 2) : grouped(area_cm2, 1);
  const value = `${significant(isovalue, 6)}${unit ? ` ${unit}` : ''}`;
  const what = cavity ? say`cavity in ${surface} at ${value}, ${area} cm²`
    : say`${surface} at ${value}, ${area} cm²`;
  return closed ? what : `${what}, ${say`closed by the faces of the scan`}`;
}
