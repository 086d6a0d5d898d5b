// Sentences about a volume that several parts of the page show.

/**
 * The warning on every picture of a volume whose place or spacing is assumed; '' for others.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
export function placeWarning(volume) {
  return volume?.findings.some(({kind}) => kind === 'assumption') ? 'place or spacing ASSUMED' : '';
}
