// Ends of measurements on slices: where they are, and what a measurement becomes if one moves.
import {valuesOf} from '../panel/measure_math.js';
import {isRegion, through} from '../panel/measures.js';
import {toPatient, toVoxel} from './patient_grid.js';
import {depthOf} from './slice_pixels.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_measure.js').Mark} Mark */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {import('../panel/measures.js').Measure} Measure */
/** @typedef {{name: string, end: number}} End  A region has its points, then its other corners. */

const HALF_A_SLICE = 0.5;

/**
 * Whether a slice shows a measurement.
 * @param {Slice} slice
 * @param {Pick<Mark, 'slice' | 'voxels'>} mark
 */
export function isOn(slice, {slice: own, voxels}) {
  return own ? own.axis === slice.axis && own.index === slice.index
    : voxels.every(voxel => Math.abs(depthOf(slice, voxel)) <= HALF_A_SLICE);
}

/**
 * The ends that a pointer can grab.
 * @param {Slice} slice
 * @param {Pick<Mark, 'kind' | 'voxels'>} mark
 * @returns {Vector[]}
 */
export function endsOf({axes}, {kind, voxels}) {
  if (!isRegion(kind) || voxels.length < 2) {
    return voxels;
  }
  const [a, b] = voxels;
  return [a, b, mixed(a, b, axes[1]), mixed(b, a, axes[1])];
}

/**
 * The end of a measurement that is nearest to a place, if one is near.
 * @param {Slice} slice
 * @param {Mark[]} marks
 * @param {(voxel: Vector) => [number, number]} placeOf  CSS pixels.
 * @param {[number, number]} place
 * @param {number} reach
 */
export function nearestEnd(slice, marks, placeOf, place, reach) {
  let [least, found] = [reach, /** @type {End | null} */ (null)];
  for (const mark of marks.filter(each => each.name && each.kind !== 'part' && isOn(slice, each))) {
    endsOf(slice, mark).forEach((voxel, end) => {
      const [x, y] = placeOf(voxel);
      const far = Math.hypot(x - place[0], y - place[1]);
      if (far <= least) {
        [least, found] = [far, {name: mark.name ?? '', end}];
      }
    });
  }
  return found;
}

/**
 * The points after an end has moved.
 * @param {Slice} slice
 * @param {Vector[]} voxels
 * @param {number} end  As in endsOf().
 * @param {Vector} to
 */
export function pointsMoved({axes: [across, down]}, voxels, end, to) {
  if (end < voxels.length) {
    return voxels.map((voxel, k) => k === end ? to : voxel);
  }
  const [a, b] = voxels;
  return end === voxels.length ? [mixed(a, to, across), mixed(b, to, down)]
    : [mixed(a, to, down), mixed(b, to, across)];
}

/**
 * `p` with one coordinate of `q`.
 * @param {Vector} p
 * @param {Vector} q
 * @param {number} axis
 * @returns {Vector}
 */
function mixed(p, q, axis) {
  const [x, y, z] = p.map((value, k) => k === axis ? q[k] : value);
  return [x, y, z];
}

/**
 * A region between two corners, with the values of the shown slice.
 * @param {SliceView} view
 * @param {import('./patient_grid.js').Grid} volume
 * @param {import('../panel/measures.js').Kind} kind
 * @param {Vector[]} corners
 * @throws {Error} as valuesOf()
 */
export function regionOf(view, volume, kind, [a, b]) {
  const {values, area_mm2} = view.valuesIn(kind, a, b);
  return {kind, points_mm: [toPatient(volume, a), toPatient(volume, b)], value: area_mm2,
    slice: view.shown ?? undefined, values: valuesOf(values)};
}

/**
 * What a measurement becomes if an end moves on the shown slice.
 * @param {SliceView} view
 * @param {import('./patient_grid.js').Grid} volume
 * @param {Measure} measure
 * @param {number} end
 * @param {Vector} to
 * @returns {Partial<Measure>}
 * @throws {Error} as regionOf() and through()
 */
export function movedTo(view, volume, {kind, points_mm}, end, to) {
  if (isRegion(kind)) {
    return regionOf(view, volume, kind,
      view.pointsMoved(points_mm.map(p => toVoxel(volume, p)), end, to));
  }
  // Other points keep their exact places.
  return through(kind, points_mm.map((p, k) => k === end ? toPatient(volume, to) : p));
}
