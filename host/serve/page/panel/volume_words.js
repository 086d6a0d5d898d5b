// Sentences about a volume that several parts of the page show.
import {short} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/**
 * The warning on every picture of a volume whose place or spacing is assumed; '' for others.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
export function placeWarning(volume) {
  return volume?.findings.some(({kind}) => kind === 'assumption')
    ? say`place or spacing ASSUMED` : '';
}

/**
 * "14/30, 390 ms: heart": place in the time series and name, as below the machine's pictures.
 * @param {import('../link/vocabulary.js').VolumeState} volume
 */
export function volumeTitle({name, frame, frames, time_ms}) {
  const when = time_ms >= 0 ? `, ${short(time_ms, 6)} ms` : '';
  return frames === 1 ? name : `${frame}/${frames}${when}: ${name}`;
}
