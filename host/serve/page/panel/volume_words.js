// Sentences about a volume that several parts of the page show.

/**
 * The warning on every picture of a volume whose place or spacing is assumed; '' for others.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
export function placeWarning(volume) {
  return volume?.findings.some(({kind}) => kind === 'assumption') ? 'place or spacing ASSUMED' : '';
}

/**
 * Name and place in its time series, as the machine writes it below its pictures.
 * @param {import('../link/vocabulary.js').VolumeState} volume
 */
export function volumeTitle({name, frame, frames, frame_ms}) {
  return frames === 1 ? name : `${name}, ${frame} of ${frames}`
    + `${frame_ms > 0 ? `, ${Number((frame_ms * (frame - 1)).toPrecision(6))} ms` : ''}`;
}
