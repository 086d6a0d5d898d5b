// Keeps the settings of the slices in saved sessions.
import {shown} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';

/**
 * @param {import('../panel/app.js').App['session']} session
 * @param {import('./slices.js').SlicesPanel} panel
 */
export function keepInSession(session, panel) {
  const add = (/** @type {string} */ name, /** @type {() => unknown} */ save,
    /** @type {(saved: any) => void} */ restore) =>
    session.add(name, {save: () => panel.volume && save(), restore});
  add('window', () => panel.window.through, through => {
    need([through?.window, through?.level], 2, through);
    panel.window.look(through);
  });
  add('slices', () => panel.settings.look, look => {
    panel.settings.setLook(look);
    panel.look(panel.settings.look);
  });
  add('slabs', () => panel.slabs.slabs, slabs => panel.slabs.setSlabs(slabs));
  add('oblique', () => panel.oblique.angles, angles => {
    need([angles?.tilt, angles?.turn], 2, angles);
    panel.oblique.setAngles(angles);
  });
  add('crosshair', () => panel.voxel, voxel => {
    need(voxel, 3, voxel);
    panel.point(voxel);
  });
}

/**
 * @param {unknown} values
 * @param {number} count
 * @param {unknown} found  For the error.
 * @throws {Error} unless the values are so many numbers
 */
function need(values, count, found) {
  if (!Array.isArray(values) || values.length !== count || !values.every(Number.isFinite)) {
    throw new Error(say`it is ${shown(found)}, but ${count} numbers are needed.`);
  }
}
