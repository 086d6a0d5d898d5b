// Panel: geometry, values, source and warnings of the volume.
import {ENGLISH, h} from '../elements/dom.js';
import {grouped, significant} from '../elements/numbers.js';
import {intro, messageLine} from '../panel/panel_parts.js';
import {plural, say} from '../texts/say.js';
import {createAttributes} from './attributes.js';

/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

/** Kinds of findings that can make a picture misleading. They are marked. */
const DOUBTFUL = new Set(['assumption', 'gantry tilt', 'missing slices', 'uneven slices',
  'missing volumes', 'duplicate slices', 'mixed orientations', 'thickness differs', 'reflection']);
/** The kinds of findings, as the page writes them. */
const KINDS = new Map([['note', say`note|finding`], ['conversion', say`conversion`],
  ['assumption', say`assumption`], ['reflection', say`reflection`],
  ['gantry tilt', say`gantry tilt`], ['missing slices', say`missing slices`],
  ['uneven slices', say`uneven slices`], ['duplicate slices', say`duplicate slices`],
  ['mixed orientations', say`mixed orientations`], ['thickness differs', say`thickness differs`],
  ['other series', say`other series`], ['processed', say`processed`],
  ['missing volumes', say`missing volumes`]]);
const NAMES = new Map([['CT', say`computed tomography`], ['MR', say`magnetic resonance`],
  ['US', say`ultrasound`], ['PT', say`positron emission tomography`],
  ['NM', say`nuclear medicine`]]);

/**
 * The directions of the voxel axes in the patient: "right to left, ...".
 * @param {VolumeState} volume
 */
function directions(volume) {
  const ways = [[say`right to left`, say`left to right`],
    [say`anterior to posterior`, say`posterior to anterior`],
    [say`inferior to superior`, say`superior to inferior`]];
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
    [say`Size`, say`${nx} × ${ny} × ${nz} voxels`],
    [say`Spacing`, `${volume.spacing_mm.map(each => significant(each, 4)).join(' × ')} mm`],
    [say`Extent`, `${extent.join(' × ')} mm`],
    [say`Modality`, volume.modality === '' ? say`not stated in the file`
      : volume.modality + (kind ? `, ${kind}` : '')],
    [say`Values`, `${rangeText(volume)} ${volume.unit}`.trimEnd()],
    ...volume.suv_per_value > 0 ? /** @type {[string, string][]} */ ([[say`SUV`,
      say`value × ${significant(volume.suv_per_value, 4)} (by body weight)`]]) : [],
    ...volume.gradient === 'smooth' ? /** @type {[string, string][]} */ ([[say`Shading`,
      say`smooth, for noisy scans`]]) : [],
    [say`Axes`, directions(volume).join('\n')],
    [say`Slices`, volume.slice_places.length > 0 ? say`not evenly spaced` : say`evenly spaced`],
    [say`Gaps`, volume.gaps === 0 ? say`none`
      : plural(volume.gaps, say`1 place with missing slices`,
        say`${grouped(volume.gaps)} places with missing slices`)],
    [say`Source`, volume.source],
  ];
}

/** @param {VolumeState} volume */
function rangeText({minimum, maximum}) {
  return say`${significant(minimum, 6)} to ${significant(maximum, 6)}`;
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
    h('h3', {}, say`About this scan`), findings);
  root.append(intro(say`Values from the file, derived values and assumptions.`),
    body, message.element);
  app.store.subscribe(['volume'], ({volume}) => {
    body.hidden = volume === null;
    message.say(volume ? '' : say`No volume is open.`);
    if (!volume) {
      return;
    }
    title.textContent = volume.name;
    attributes.hidden = app.connection.watches || volume.source.startsWith('phantom:');
    list.replaceChildren(...facts(volume).flatMap(([what, is]) => [h('dt', {}, what),
      h('dd', {}, is)]));
    findings.replaceChildren(...volume.findings.map(({kind, text}) =>
      h('li', {class: DOUBTFUL.has(kind) ? 'doubtful' : ''},
        h('b', {}, KINDS.get(kind) ?? kind), ' ', h('span', ENGLISH, text))));
    if (volume.findings.length === 0) {
      findings.append(h('li', {}, say`No warnings: slices, spacing and orientation are used as
        stated in the file.`));
    }
  });
}
