// The left side: histogram and surfaces, then how they look, then where they are cut.
import {byId, h} from '../elements/dom.js';
import {createClips} from './clips.js';
import {Histogram} from './histogram.js';
import {createLook} from './look.js';
import {createSurfaces, createTissues} from './surfaces.js';

const ROOMY_PX = 1000;  // From this height on everything fits, open.

/** @param {import('../panel/app.js').App} app */
export function createLeft(app) {
  const {modes, selection} = app;
  // A mode that sets something of a surface ends with it, and when another one is chosen.
  selection.watch(name => {
    if (modes.current?.surface !== undefined && modes.current.surface !== name) {
      modes.leave();
    }
  });
  // A fieldset disables all controls at once for those who only watch.
  const all = h('fieldset', {class: 'controls'});
  const block = (/** @type {string} */ title, isOpen = false) => {
    const details = h('details', {class: 'block', open: isOpen},
      h('summary', {}, title));
    all.append(details);
    return details;
  };
  const values = h('section', {class: 'block'}, h('h2', {class: 'spread'},
    h('span', {}, 'Values'), h('span', {class: 'muted small',
      title: 'How many voxels have each value, on a logarithmic scale'}, 'log scale')));
  const surfaces = h('section', {class: 'block'});
  all.append(values, surfaces);
  new Histogram(values, app, selection);
  createTissues(values, app, selection);
  createSurfaces(surfaces, app, selection);
  const isRoomy = innerHeight >= ROOMY_PX;
  createClips(block('Cut', isRoomy), app);
  createLook(block('Light and material', isRoomy), app);
  byId('left').append(all);
  app.connection.on('hello', ({role}) => { all.disabled = role === 'watcher'; });
}
