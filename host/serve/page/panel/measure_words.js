// The values of a region or a part in words.
import {counted, grouped, significant} from '../elements/numbers.js';

/** @typedef {import('./measures.js').MeasuredSlice} MeasuredSlice */
/** @typedef {import('./measures.js').Part} Part */
/** @typedef {import('./measures.js').Values} Values */

/**
 * "mean 41.2, deviation 8.1, 12 to 60 HU, 314 voxels"
 * @param {Values} values
 * @param {string} unit
 */
export function valuesText({voxels, mean, deviation, least, most}, unit) {
  const spread = deviation === null ? '' : `, deviation ${significant(deviation, 4)}`;
  return `mean ${significant(mean, 4)}${spread}, ${significant(least, 6)} to ` +
    `${significant(most, 6)}${unit ? ` ${unit}` : ''}, ${counted(voxels, 'voxel')}`;
}

/**
 * ", max of a slab of 10 mm" if the values of a region are those of a slab.
 * @param {MeasuredSlice} [slice]
 */
export function slabNote(slice) {
  return slice?.slab_mm ? `, ${slice.slab_kind} of a slab of ` +
    `${significant(slice.slab_mm, 4)} mm` : '';
}

/**
 * "bone at 250.5 HU, 2,107.7 cm²", with what is special about the part.
 * @param {Part} part
 * @param {string} unit
 */
export function partText({surface, isovalue, cavity, closed, area_mm2}, unit) {
  const area_cm2 = area_mm2 / 100;
  const area = area_cm2 < 1 ? significant(area_cm2, 2) : grouped(area_cm2, 1);
  return `${cavity ? 'cavity in ' : ''}${surface} at ${significant(isovalue, 6)}` +
    `${unit ? ` ${unit}` : ''}, ${area} cm²` +
    `${closed ? '' : ', closed by the faces of the scan'}`;
}
