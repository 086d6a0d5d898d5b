// The voxel axis that is perpendicular to each anatomical plane. Pure functions.

/** @typedef {import('./slice_pixels.js').Axis} Axis */

/** Planes as they stand on the screen, and the patient's axis (L, P, S) that each is across. */
const PLANES = [['Axial', 2], ['Coronal', 1], ['Sagittal', 0]];

/**
 * The voxel axis of each plane: of all ways to pair voxel axes with the patient's, the one whose
 * cosines are largest in sum. So each axis is used once, however oblique the scan.
 * @param {number[]} voxelToPatient  4 x 4, column-major.
 * @returns {{plane: string, axis: Axis, number: number}[]}
 */
export function planesOf(voxelToPatient) {
  const cosine = (/** @type {number} */ axis, /** @type {number} */ patient) =>
    Math.abs(voxelToPatient[4 * axis + patient]) /
      Math.hypot(...voxelToPatient.slice(4 * axis, 4 * axis + 3));
  const pairings = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
  const worth = (/** @type {number[]} */ pairing) =>
    pairing.reduce((sum, axis, patient) => sum + cosine(axis, patient), 0);
  const best = pairings.reduce((a, b) => worth(b) > worth(a) ? b : a);
  return PLANES.map(([plane, patient]) => {
    const number = best[/** @type {number} */ (patient)];
    return {plane: String(plane), axis: /** @type {Axis} */ ('xyz'[number]), number};
  });
}
