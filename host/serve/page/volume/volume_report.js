// Panel: geometry, values, source and warnings of the volume.
import {h} from '../elements/dom.js';
import {counted, significant} from '../elements/numbers.js';
import {intro, messageLine} from '../panel/panel_parts.js';
import {createAttributes} from './attributes.js';

/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

/** Kinds of findings that can make a picture misleading. They are marked. */
const DOUBTFUL = new Set(['assumption', 'gantry tilt', 'missing slices', 'uneven slices',
  'duplicate slices', 'mixed orientations', 'thickness differs', 'reflection']);
const NAMES = new Map([['CT', 'computed tomography'], ['MR', 'magnetic resonance'],
  ['US', 'ultrasound'], ['PT', 'positron emission tomography'], ['NM', 'nuclear medicine']]);

/**
 * The directions of the voxel axes in the patient: "right to left, ...".
 * @param {VolumeState} volume
 */
function directions(volume) {
  const ways = [['right to left', 'left to right'], ['anterior to posterior',
    'posterior to anterior'], ['inferior to superior', 'superior to inferior']];
  return [0, 1, 2].map(axis => {
    const towards = volume.voxel_to_patient.slice(4 * axis, 4 * axis + 3);
    const largest = towards.reduce(
      (best, part, n) => Math.abs(part) > Math.abs(towards[best]) ? n : best, 0);
    return `${'xyz'[axis]}: ${ways[largest][towards[largest] < 0 ? 1 : 0]}`;
  });
}

/**
 * @param {VolumeState} volume
 * @returns {[string, string][]}  What, and what it is.
 */
function facts(volume) {
  const [nx, ny, nz] = volume.size;
  const last = volume.slice_places.length > 0 ? volume.slice_places[nz - 1] : nz - 1;
  const extent = [nx - 1, ny - 1, last].map((steps, n) =>
    significant(steps * volume.spacing_mm[n], 4));
  const kind = NAMES.get(volume.modality);
  return [
    ['Size', `${nx} × ${ny} × ${nz} voxels`],
    ['Spacing', `${volume.spacing_mm.map(each => significant(each, 4)).join(' × ')} mm`],
    ['Extent', `${extent.join(' × ')} mm`],
    ['Modality', volume.modality === '' ? 'not stated in the file'
      : volume.modality + (kind ? `, ${kind}` : '')],
    ['Values', [significant(volume.minimum, 6), 'to', significant(volume.maximum, 6), volume.unit]
      .join(' ').trimEnd()],
    ...volume.suv_per_value > 0 ? /** @type {[string, string][]} */ ([['SUV',
      `value × ${significant(volume.suv_per_value, 4)} (by body weight)`]]) : [],
    ['Axes', directions(volume).join('\n')],
    ['Slices', volume.slice_places.length > 0 ? 'not evenly spaced' : 'evenly spaced'],
    ['Gaps', volume.gaps === 0 ? 'none'
      : `${counted(volume.gaps, 'place')} with missing slices`],
    ['Source', volume.source],
  ];
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  const title = h('h2', {'data-testid': 'volume-title'});
  const list = h('dl', {class: 'facts', 'data-testid': 'volume-facts'});
  const findings = h('ul', {class: 'findings', 'data-testid': 'volume-findings'});
  const message = messageLine('volume-message');
  const attributes = createAttributes(app);
  const body = h('div', {class: 'stack'}, title, list, attributes,
    h('h3', {}, 'About this scan'), findings);
  root.append(intro('Values from the file, derived values and assumptions.'),
    body, message.element);
  app.store.subscribe(['volume'], ({volume}) => {
    body.hidden = volume === null;
    message.say(volume ? '' : 'No volume is open.');
    if (!volume) {
      return;
    }
    title.textContent = volume.name;
    attributes.hidden = app.connection.watches || volume.source.startsWith('phantom:');
    list.replaceChildren(...facts(volume).flatMap(([what, is]) => [h('dt', {}, what),
      h('dd', {}, is)]));
    findings.replaceChildren(...volume.findings.map(({kind, text}) =>
      h('li', {class: DOUBTFUL.has(kind) ? 'doubtful' : ''}, h('b', {}, kind), ` ${text}`)));
    if (volume.findings.length === 0) {
      findings.append(h('li', {}, 'No warnings: slices, spacing and orientation are used as ' +
        'stated in the file.'));
    }
  });
}
