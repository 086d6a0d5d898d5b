// Files of measurements: CSV and JSON.
import {isRegion} from './measures.js';

/** @typedef {import('./measures.js').Kind} Kind */
/** @typedef {import('./measures.js').Measure} Measure */

/**
 * Units as files have them.
 * @param {Kind} kind
 */
function unitOf(kind) {
  return kind === 'note' ? '' : kind === 'angle' ? 'degrees' : kind === 'part' ? 'ml'
    : isRegion(kind) ? 'mm2' : 'mm';
}

const COLUMNS = ['volume', 'name', 'kind', 'value', 'unit', 'points_mm_LPS', 'voxel_axis',
  'voxel_index', 'voxels', 'mean', 'deviation', 'least', 'most', 'value_unit', 'slab_mm',
  'slab_kind', 'text', 'surface', 'isovalue', 'cavity', 'closed', 'area_mm2', 'frame'];

/**
 * A text that a spreadsheet does not take for a formula. It may come from another person's session.
 * @param {string} text
 */
function plainText(text) {
  return /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
}

/**
 * One line per measurement, for spreadsheets. Voxels count from 0, as in the line below the slices.
 * @param {readonly Measure[]} measures
 * @param {{name: string, unit: string}} volume
 */
export function csvOf(measures, volume) {
  const lines = measures.map(({name, kind, value, points_mm, slice, values, text, part,
    frame}) => [
    plainText(volume.name), plainText(name), kind, kind === 'note' ? '' : value, unitOf(kind),
    points_mm.map(p => p.join(' ')).join('; '),
    ...slice ? [slice.axis, slice.index] : ['', ''],
    ...values ? [values.voxels, values.mean, values.deviation ?? '', values.least, values.most,
      volume.unit] : ['', '', '', '', '', ''],
    slice?.slab_mm ?? '', slice?.slab_kind ?? '', plainText(text ?? ''),
    ...part ? [plainText(part.surface), part.isovalue, part.cavity ? 'yes' : 'no',
      part.closed ? 'yes' : 'no', part.area_mm2] : ['', '', '', '', ''], frame ?? '']);
  const cell = (/** @type {unknown} */ each) => /[",\r\n]/.test(String(each))
    ? `"${String(each).replaceAll('"', '""')}"` : String(each);
  return [COLUMNS, ...lines].map(line => `${line.map(cell).join(',')}\r\n`).join('');
}

/**
 * The same as JSON.
 * @param {readonly Measure[]} measures
 * @param {{name: string, unit: string}} volume
 */
export function jsonOf(measures, {name, unit}) {
  return `${JSON.stringify({volume: name, value_unit: unit, positions: 'mm, LPS',
    measurements: measures.map(({slice, value, ...measure}) => ({...measure,
      ...measure.kind !== 'note' && {value, unit: unitOf(measure.kind)},
      ...slice && {voxel_axis: slice.axis, voxel_index: slice.index,
        ...slice.slab_mm && {slab_mm: slice.slab_mm, slab_kind: slice.slab_kind}}}))}, null, 2)}\n`;
}
