// Sentences about slices. Pure functions.
import {grouped} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';

/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */
/** @typedef {import('../link/vocabulary.js').ClipState} ClipState */

const LEAST_TILT_DEG = 0.1;  // Smaller angles are rounding errors of the file.

/**
 * The words for each plane: alone, in a list, and with "slice".
 * @type {Record<string, string[]>}
 */
const PLANES = {
  Axial: [say`Axial`, say`axial`, say`Axial slice`],
  Coronal: [say`Coronal`, say`coronal`, say`Coronal slice`],
  Sagittal: [say`Sagittal`, say`sagittal`, say`Sagittal slice`],
  Oblique: [say`Oblique`, say`oblique`, say`Oblique slice`],
};

/** @param {string} plane  A key of PLANES, as in the functions below. */
export function planeWord(plane) {
  return PLANES[plane][0];
}

/** @param {string} plane */
export function smallPlaneWord(plane) {
  return PLANES[plane][1];
}

/** @param {string} plane */
export function sliceWord(plane) {
  return PLANES[plane][2];
}

/**
 * "Axial slice 3 of 48"
 * @param {string} plane
 * @param {number} number
 * @param {number} count
 */
export function placeText(plane, number, count) {
  return say`${sliceWord(plane)} ${number} of ${count}`;
}

/**
 * Where slices differ from the scan; empty if they do not.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 * @param {number} skew_deg
 */
export function differing(volume, skew_deg) {
  const gaps = volume?.gaps ?? 0;
  const isTilted = Math.abs(skew_deg) >= LEAST_TILT_DEG;
  const isGantry = volume?.modality === 'CT', angle = grouped(Math.abs(skew_deg), 1);
  return [
    gaps > 0 ? plural(gaps, say`Slices are missing in 1 place: rows beside a gap are taller.`,
      say`Slices are missing in ${grouped(gaps)} places: rows beside a gap are taller.`) : '',
    !isTilted ? '' : isGantry
      ? say`The gantry was tilted by ${angle}°. Slices across the tilt are drawn without shear.`
      : say`The slices are sheared by ${angle}°. Slices across the shear are drawn without shear.`,
  ].filter(Boolean).join(' ');
}

/**
 * What slices show and the picture hides; empty if both show the same.
 * @param {{surfaces: SurfaceState[], clips: ClipState[]}} state
 */
export function beyond({surfaces, clips}) {
  // Surfaces of a comparison have no lines in slices.
  const shown = surfaces.filter(each => each.visible && each.compared_with === '');
  const filtered = shown.filter(({components}) => !['', 'all'].includes(components));
  const hidden = shown.length === 0 ? [] : [
    clips.length > 0 ? say`parts behind clip planes` : '',
    filtered.length > 0 ? say`components of ${filtered.map(({name}) => name).join(', ')}` : '',
  ].filter(Boolean);
  return hidden.length === 0 ? ''
    : hidden.length === 1 ? say`Not in the 3D picture: ${hidden[0]}.`
    : say`Not in the 3D picture: ${hidden[0]} and ${hidden[1]}.`;
}
