// The left side: histogram, surfaces, clip planes, light and material.
import {byId, h} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {createClips} from './clips.js';
import {Histogram} from './histogram.js';
import {createLook} from './look.js';
import {createSurfaces, createTissues} from './surfaces.js';

const ROOMY_PX = 1000;  // From this window height on, all blocks fit unfolded.

/** @param {import('../panel/app.js').App} app */
export function createLeft(app) {
  const {modes, selection} = app;
  // A mode that changes a surface ends when another surface is chosen.
  selection.watch(name => {
    if (modes.current?.surface !== undefined && modes.current.surface !== name) {
      modes.leave();
    }
  });
  // A fieldset disables all controls at once on a view-only page.
  const all = h('fieldset', {class: 'controls'});
  const block = (/** @type {string} */ title, isOpen = false) => {
    const details = h('details', {class: 'block', open: isOpen},
      h('summary', {}, title));
    all.append(details);
    return details;
  };
  const values = h('section', {class: 'block'});
  const surfaces = h('section', {class: 'block'});
  all.append(values, surfaces);
  new Histogram(values, app, selection);
  createTissues(values, app, selection);
  createSurfaces(surfaces, app, selection);
  const isRoomy = innerHeight >= ROOMY_PX;
  createClips(block(say`Clip planes`, isRoomy), app);
  createLook(block(say`Light and material`, isRoomy), app);
  byId('left').append(all);
  app.connection.on('hello', ({role}) => { all.disabled = role === 'watcher'; });
}
