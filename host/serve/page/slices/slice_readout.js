// The line below the slices: a voxel, its value and place, and the values of slabs there.
import {h} from '../elements/dom.js';
import {significant} from '../elements/numbers.js';
import {say} from '../texts/say.js';
import {nearestVoxel, patientText, toPatient} from './patient_grid.js';
import {slabText} from './slice_slab.js';
import {planeWord} from './slice_words.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */
/** @typedef {import('./slice_slab.js').ShownSlab} ShownSlab */
/** @typedef {{plane: string, value: number, slab: ShownSlab}} SlabValue */

/** @type {Record<'pointer' | 'crosshair' | 'between', (voxel: string) => string>} */
const WHERE = {
  pointer: voxel => say`at voxel ${voxel}`,
  crosshair: voxel => say`at the crosshair, voxel ${voxel}`,
  between: voxel => say`interpolated, near voxel ${voxel}`,
};

export class SliceReadout {
  constructor() {
    this.element = h('p', {class: 'readout', 'data-testid': 'slices-readout'});
  }

  clear() {
    this.element.textContent = '';
  }

  /**
   * Tells the value under the pointer; without a pointer, the crosshair's, with those of all slabs.
   * @param {VolumeState | null} volume
   * @param {{plane: string, view: import('./slice_view.js').SliceView}[]} views
   * @param {object} at
   * @param {import('./slice_input.js').Under | null} at.under
   * @param {number} at.number        The view with the pointer; the oblique one follows the last.
   * @param {Vector} at.crosshair
   */
  show(volume, views, {under, number, crosshair}) {
    const shown = views.map(({plane, view}, each) => ({plane, slab: view.slab,
      at: !under ? view.valueAt(crosshair) : each === number ? under : null}));
    const own = under ?? shown.find(({at}) => at)?.at;
    if (!volume || !own) {
      this.clear();
      return;
    }
    this.tell(volume, own.voxel, own.own,
      !under ? 'crosshair' : number < views.length ? 'pointer' : 'between',
      shown.flatMap(({plane, slab, at}) => slab && at ? [{plane, slab, value: at.value}] : []));
  }

  /**
   * @param {VolumeState} volume
   * @param {Vector} voxel            Not rounded.
   * @param {number} value            Of the voxel, or interpolated there.
   * @param {'pointer' | 'crosshair' | 'between'} where  'between': the pointer, between voxels.
   * @param {SlabValue[]} slabs       What slabs show there.
   */
  tell(volume, voxel, value, where, slabs) {
    const [x, y, z] = nearestVoxel(volume, voxel);
    const text = (/** @type {number} */ number) => [significant(number, 6), volume.unit,
      volume.suv_per_value > 0 ? `(SUV ${significant(number * volume.suv_per_value, 3)})` : '',
    ].filter(Boolean).join(' ');
    this.element.replaceChildren(h('b', {}, text(value)),
      ` ${WHERE[where](`${x}, ${y}, ${z}`)}`,
      h('span', {}, patientText(toPatient(volume, voxel))),
      ...slabs.map(({plane, value: shown, slab}) => h('span', {},
        `${planeWord(plane)}, ${slabText(slab)}: ${text(shown)}`)));
  }
}
