// The line below the slices: a voxel, its value and place, and the values of slabs there.
import {h} from '../elements/dom.js';
import {significant} from '../elements/numbers.js';
import {nearestVoxel, patientText, toPatient} from './patient_grid.js';
import {slabText} from './slice_slab.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */
/** @typedef {import('./slice_slab.js').ShownSlab} ShownSlab */
/** @typedef {{plane: string, value: number, slab: ShownSlab}} SlabValue */

export class SliceReadout {
  constructor() {
    this.element = h('p', {class: 'readout', 'data-testid': 'slices-readout'});
  }

  clear() {
    this.element.textContent = '';
  }

  /**
   * @param {VolumeState} volume
   * @param {Vector} voxel            Not rounded.
   * @param {number} value            Of the voxel.
   * @param {boolean} isCrosshair     Else the pointer is there.
   * @param {SlabValue[]} slabs       What slabs show there.
   */
  tell(volume, voxel, value, isCrosshair, slabs) {
    const [x, y, z] = nearestVoxel(volume, voxel);
    const text = (/** @type {number} */ number) =>
      `${significant(number, 6)} ${volume.unit}`.trim();
    this.element.replaceChildren(h('b', {}, text(value)),
      ` at ${isCrosshair ? 'the crosshair, ' : ''}voxel ${x}, ${y}, ${z}`,
      h('span', {}, patientText(toPatient(volume, voxel))),
      ...slabs.map(({plane, value: shown, slab}) => h('span', {},
        `${plane}, ${slabText(slab)}: ${text(shown)}`)));
  }
}
