// The German texts of the page. texts/de has a file for each room that shows texts.
import elements from './de/elements.js';
import headset from './de/headset.js';
import index from './de/index.js';
import inspect from './de/inspect.js';
import link from './de/link.js';
import machine from './de/machine.js';
import panel from './de/panel.js';
import picture from './de/picture.js';
import shell from './de/shell.js';
import slices from './de/slices.js';
import state from './de/state.js';
import surfaces from './de/surfaces.js';
import tour from './de/tour.js';
import volume from './de/volume.js';

/** @type {Record<string, string>} */
export default {
  ...elements, ...headset, ...index, ...inspect, ...link, ...machine, ...panel, ...picture,
  ...shell, ...slices, ...state, ...surfaces, ...tour, ...volume,
};
