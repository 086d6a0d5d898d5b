// A fourth slice: any plane through the crosshair, turned by two angles.
import {h} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {moved, normalOf, planeThrough} from './oblique_plane.js';
import {nearestVoxel, toPatient, toVoxel} from './patient_grid.js';
import {SliceSource} from './slice_source.js';

/** @typedef {import('./oblique_plane.js').Angles} Angles */
/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

const MOST_DEG = 90;
/** @type {{name: 'tilt' | 'turn', title: string, label: string, help: string}[]} */
const FIELDS = [
  {name: 'tilt', title: say`Tilt`, label: say`Tilt of the oblique slice, degrees`,
    help: say`From axial (0) to coronal (90), about the axis from right to left`},
  {name: 'turn', title: say`Turn`, label: say`Turn of the oblique slice, degrees`,
    help: say`About the axis from the top to the bottom of this slice. With a tilt of 90:
      from coronal (0) to sagittal (90)`},
];

/** A closed block below the three slices. It asks for slices while it is open. */
export class ObliquePane {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {SliceView} view
   * @param {object} events
   * @param {() => void} events.changed   The plane may be another one, or not shown.
   * @param {(slice: import('./slice_pixels.js').Slice) => void} events.shown  To be shown.
   * @param {(sentence: string) => void} events.failed
   */
  constructor(connection, view, {changed, shown, failed}) {
    this.view = view;
    /** @private */ this.changed_ = changed;
    /** @private @type {Angles} */ this.angles_ = {tilt: 45, turn: 0};
    /** @private @type {VolumeState | null} */ this.volume_ = null;
    /** The crosshair. @private @type {Vector} */ this.voxel_ = [0, 0, 0];
    /** A place of the plane, mm: in the voxel of the crosshair. @private @type {Vector} */
    this.place_ = [0, 0, 0];
    /** @private What the contours depend on. */ this.of_ = '';
    /** @private */
    this.source_ = new SliceSource(connection, {slice: shown, failed});
    /** @private */
    this.fields_ = FIELDS.map(({name, title, label, help}) => {
      const value = h('output', {class: 'slice-count', 'data-testid': `oblique-${name}-value`});
      const input = h('input', {type: 'range', min: -MOST_DEG, max: MOST_DEG, step: 1,
        'aria-label': label, title: help,
        'data-testid': `oblique-${name}`,
        oninput: () => this.setAngles({...this.angles_, [name]: Number(input.value)})});
      return {name, input, value, element: h('label', {class: 'oblique-angle', title: help}, title,
        input, value)};
    });
    /** @private */
    this.block_ = h('details', {class: 'slice-settings', 'data-testid': 'oblique',
      ontoggle: () => this.refresh(this.of_)},
    h('summary', {}, say`Oblique slice`), ...this.fields_.map(({element}) => element), view.canvas,
    h('p', {class: 'legend'}, say`Values are interpolated between voxels, and contours are
      approximate. The other slices show this plane as a dashed line.`));
    this.tell_();
  }

  get element() {
    return this.block_;
  }

  /** The shown plane; null if the block is closed. */
  get plane() {
    return this.block_.open && this.volume_
      ? planeThrough(this.volume_, this.angles_, this.place_) : null;
  }

  /** The plane as (normal, offset); null as `plane`. */
  get equation() {
    const plane = this.plane;
    if (!plane) {
      return null;
    }
    const n = normalOf(plane), p = plane.center_mm;
    return [...n, -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2])];
  }

  get angles() {
    return this.angles_;
  }

  /** @param {Angles} angles */
  setAngles({tilt, turn}) {
    this.angles_ = {tilt, turn};
    this.tell_();
    this.refresh(this.of_);
  }

  /** @private */
  tell_() {
    for (const {name, input, value} of this.fields_) {
      input.value = String(this.angles_[name]);
      value.textContent = `${this.angles_[name]}°`;
    }
  }

  /**
   * @param {VolumeState | null} volume
   * @param {boolean} same  Another volume of the same series.
   */
  open(volume, same) {
    this.volume_ = volume;
    this.source_.forget();
    if (!same) {
      this.view.clear();
    }
  }

  /** @param {Vector} voxel  The crosshair. */
  move(voxel) {
    this.voxel_ = voxel;
    // Within the voxel the plane stays: it does not drift by the rounding of the crosshair.
    if (this.volume_ && nearestVoxel(this.volume_, toVoxel(this.volume_, this.place_)).join() !==
        voxel.join()) {
      this.place_ = toPatient(this.volume_, voxel);
    }
    this.view.setCrosshair(voxel);
  }

  /**
   * The plane goes through this place from now on, if the crosshair moves into its voxel.
   * @param {Vector} voxel    Not rounded.
   */
  hold(voxel) {
    if (this.volume_) {
      this.place_ = toPatient(this.volume_, voxel);
    }
    return voxel;
  }

  /**
   * Moves the plane by `by` pixels along its normal, away from the viewer, but not out of the
   * volume. Returns the voxel of the crosshair.
   * @param {number} by
   * @returns {Vector}
   */
  stepped(by) {
    const plane = this.plane, volume = this.volume_;
    if (!plane || !volume) {
      return this.voxel_;
    }
    const voxel = toVoxel(volume, moved(this.place_, normalOf(plane), by * plane.pixel_mm));
    const isWithin = voxel.every((each, axis) => each >= -0.5 && each <= volume.size[axis] - 0.5);
    return isWithin ? this.hold(voxel) : this.voxel_;
  }

  /**
   * Asks for the slice if it may have changed.
   * @param {string} of   Identifies volume and contours.
   */
  refresh(of) {
    this.of_ = of;
    const plane = this.plane, volume = this.volume_;
    if (plane && volume) {
      this.source_.want({axis: 'oblique', oblique: {grid: volume, plane}}, of);
    }
    this.changed_();
  }
}
