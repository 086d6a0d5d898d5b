// Sentences about slices. Pure functions.
import {counted, grouped} from '../elements/numbers.js';

/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */
/** @typedef {import('../link/vocabulary.js').ClipState} ClipState */

const LEAST_TILT_DEG = 0.1;  // Smaller angles are rounding errors of the file.

/**
 * Where slices differ from the scan; empty if they do not.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 * @param {number} skew_deg
 */
export function differing(volume, skew_deg) {
  const gaps = volume?.gaps ?? 0;
  const isTilted = Math.abs(skew_deg) >= LEAST_TILT_DEG;
  const isGantry = volume?.modality === 'CT';
  return [
    gaps > 0 ? `Slices are missing in ${counted(gaps, 'place')}: rows beside ` +
      'a gap are taller.' : '',
    isTilted ? `The ${isGantry ? 'gantry was tilted' : 'slices are sheared'} by ` +
      `${grouped(Math.abs(skew_deg), 1)}°. Slices across the ${isGantry ? 'tilt' : 'shear'} ` +
      'are drawn without shear.' : '',
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
    clips.length > 0 ? 'parts behind clip planes' : '',
    filtered.length > 0 ? `components of ${filtered.map(({name}) => name).join(', ')}` : '',
  ].filter(Boolean);
  return hidden.length === 0 ? '' : `Not in the 3D picture: ${hidden.join(' and ')}.`;
}
