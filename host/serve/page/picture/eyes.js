// The eyes for which marks are drawn over the picture.
import {camerasAt} from './camera.js';
import {projectToPicture} from './projection.js';
import {partsOf, stereoOf} from './stereo.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('../link/vocabulary.js').State} State */

/**
 * An eye, and its part of the picture in places. In an anaglyph, both parts are the whole picture.
 * @typedef {object} Eye
 * @property {'middle' | 'left' | 'right'} name
 * @property {number} left    Of the part's left edge.
 * @property {number} width
 * @property {(p_mm: Triple) => {x: number, y: number, visible: boolean}} project  The place of a
 *     patient position.
 */

/**
 * The eyes from left to right. Alternate rows belong to both eyes, which marks cannot: there a mark
 * is drawn once, as the camera between the eyes sees it.
 * @param {import('../link/vocabulary.js').CameraState} camera  Between the eyes.
 * @param {number[]} size  Of the picture of one eye, pixels.
 * @param {State} state
 * @param {number} width   Of the picture, places.
 * @param {number} height
 * @returns {Eye[]}
 */
export function eyesOf(camera, size, state, width, height) {
  const eye = (/** @type {Eye['name']} */ name, /** @type {number[]} */ clip,
    /** @type {number} */ left, /** @type {number} */ across) => ({name, left, width: across,
    project: (/** @type {Triple} */ p_mm) => {
      const {x, y, visible} = projectToPicture(clip, p_mm, across, height);
      return {x: left + x, y, visible};
    }});
  if (state.stereo === 'off' || state.stereo === 'rows') {
    return [eye('middle', camera.patient_to_clip, 0, width)];
  }
  const cameras = camerasAt(camera, camera, size[0] / size[1], stereoOf(state));
  return partsOf(state.stereo).flatMap(part => part.eyes.map(index =>
    eye(index === 0 ? 'left' : 'right', cameras[index].patient_to_clip, part.left * width,
      part.width * width)));
}
