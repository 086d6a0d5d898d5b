// The options of `load` in the dialog Open.
import {h} from '../elements/dom.js';
import {word} from '../link/lines.js';
import {say} from '../texts/say.js';

/** The options of `load`. */
export function createOptions() {
  const rows = /** @type {const} */ ([
    ['crop', say`Crop`, say`First and last voxel, e.g. 10:90,0:127,5:40`],
    ['resample', say`Resample`, say`Number of voxels, e.g. 128x128x64`],
    ['resample_mm', say`Resample (mm)`, say`New spacing in mm, e.g. 1,1,1`],
    ['smooth', say`Smooth`, say`Standard deviation in mm, e.g. 1.5`],
    ['series', say`Series`, say`Series of a DICOM folder, e.g. 2`],
    ['frame', say`Frame`, say`Volume of a time series in a file, e.g. 3`],
    ['spacing', say`Spacing`, say`In mm, if the file does not state it, e.g. 0.5,0.5,1`],
    ['orientation', say`Orientation`,
      say`Sides to which x, y, z point, if not stated, e.g. RAI`],
    ['origin', say`Origin`, say`First voxel in mm, LPS, if not stated, e.g. -120,-120,40`],
    ['raw', say`Raw layout`, say`Of a file without a header, e.g. 64x64x32,int16`],
    ['gradient', say`Shading`,
      say`Normals from two neighbors along each axis, or from 3x3x3 voxels`,
      {'': say`central differences, as in the paper`, smooth: say`smooth, for noisy scans`}],
    ['read', say`Read by`,
      say`The GPs each read their part of an uncompressed file, if it is large`,
      {'': say`host, or GPs above 8 GiB`, host: say`host`, gps: say`GPs`}],
  ]).map(([key, label, title, choices]) => {
    const given = {class: 'grow', id: `open-${key}`, title, 'data-testid': `open-${key}`};
    const input = choices
      ? h('select', given, ...Object.entries(choices).map(([value, text]) =>
        h('option', {value}, text)))
      : h('input', {...given, type: 'text', autocomplete: 'off'});
    return {key, input, row: h('label', {class: 'row', title}, h('span', {class: 'field'}, label),
      input, h('span', {class: 'muted example'}, title))};
  });
  const root = h('details', {},
    h('summary', {}, say`Options for files, folders and built-in volumes`),
    ...rows.map(({row}) => row));
  return {
    root,
    /** Shows the option that an error names, for example series=N. */
    hint: (/** @type {string} */ error) => {
      const asked = rows.find(({key}) => error.includes(`${key}=`));
      root.open ||= asked !== undefined;
      asked?.input.focus();
    },
    /** For the next volume. */
    clear: () => rows.forEach(({input}) => { input.value = ''; }),
    /** @param {string} key  @param {string} value */
    set: (key, value) => {
      const row = rows.find(each => each.key === key);
      if (row) {
        row.input.value = value;
      }
    },
    words: () => rows.filter(({input}) => input.value.trim() !== '')
      .map(({key, input}) => ` ${key}=${word(input.value.trim())}`).join(''),
  };
}
