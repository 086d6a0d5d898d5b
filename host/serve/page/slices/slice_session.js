// Keeps the settings of the slices in saved sessions.

/**
 * @param {import('../panel/app.js').App['session']} session
 * @param {import('./slices.js').SlicesPanel} panel
 */
export function keepInSession(session, panel) {
  const add = (/** @type {string} */ name, /** @type {() => unknown} */ save,
    /** @type {(saved: any) => void} */ restore) =>
    session.add(name, {save: () => panel.volume && save(), restore});
  add('window', () => panel.window.through, through => panel.window.look(through));
  add('slices', () => panel.settings.look, look => {
    panel.settings.setLook(look);
    panel.look(panel.settings.look);
  });
  add('slabs', () => panel.slabs.slabs, slabs => panel.slabs.setSlabs(slabs));
  add('oblique', () => panel.oblique.angles, angles => panel.oblique.setAngles(angles));
  add('crosshair', () => panel.voxel, voxel => panel.point(voxel));
}
