// Sentences about slices. Pure functions.

/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */
/** @typedef {import('../link/vocabulary.js').ClipState} ClipState */

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
