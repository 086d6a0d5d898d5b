// Saves a mesh, a picture or the session, and reopens a session.
import {h} from '../elements/dom.js';
import {short} from '../elements/numbers.js';
import {saveAs, saveBlob} from '../elements/save_file.js';
import {word} from '../link/lines.js';
import {address} from '../link/token.js';
import {placeWarning} from '../panel/volume_words.js';
import {sessionText} from './session_file.js';
import {openSession, SESSION_ENDING} from './upload.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/types.js').LegendLine} LegendLine */

const MESHES = /** @type {const} */ ([['glb', 'glTF binary (.glb)'], ['stl', 'STL (.stl)'],
  ['ply', 'PLY (.ply)'], ['obj', 'Wavefront (.obj)'], ['vtp', 'VTK (.vtp)']]);
const KEEPS = /** @type {const} */ ([['', 'all triangles'], ['0.5', '50 %'],
  ['0.25', '25 %'], ['0.1', '10 %']]);

const SAMPLES = [16, 4, 1];     // Per pixel, the best first.
const MOST_PX = 4096;           // A side of a picture that the command `snapshot` accepts.
const NO_ROOM = /are summed in/;  // A Renderer's memory is too small for the samples.

/**
 * Exports a mesh and saves it. Its certificate, and the colors of an OBJ, are links in the note:
 * browsers ask before a page saves several files.
 * @param {App} app
 * @param {string} name
 * @param {string} options  Of the command.
 */
async function saveMesh(app, name, options) {
  const {ok, result} = await app.connection.do(`export download:${word(name)}${options}`);
  if (!ok || !result?.download) {
    return;
  }
  const {href} = address(result.download);
  saveAs(href, name);
  const besides = [['certificate', String(result.certificate).split('/').at(-1) ?? '']];
  if (name.endsWith('.obj')) {
    besides.push(['colors', name.replace(/obj$/, 'mtl')]);
  }
  app.toasts.info(`Saved ${name}, ${result.closed ? 'closed' : 'open: see the certificate'}.`,
    besides.map(([text, file]) => h('a', {download: file, 'data-testid': `saved-${text}`,
      href: address(result.download.replace(/[^/]*$/, encodeURIComponent(file))).href}, text)));
}

/**
 * The volume's name without characters that a file name cannot have.
 * @param {App} app
 */
function baseName({store}) {
  return (store.state?.volume?.name ?? 'pxpl5').replace(/[^\w.-]+/g, '-');
}

/**
 * @param {App} app
 * @returns {() => void} shows the dialog
 */
export function createSaveDialog(app) {
  const dialog = h('dialog', {id: 'save', 'aria-labelledby': 'save-title', 'data-testid': 'save'});
  dialog.append(
    h('div', {class: 'row spread'}, h('h2', {id: 'save-title'}, 'Save'),
      h('button', {class: 'quiet icon', 'aria-label': 'Close',
        onclick: () => dialog.close()}, '×')),
    meshPart(app, dialog), picturePart(app, dialog), sessionPart(app, dialog));
  dialog.addEventListener('click', event => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  document.body.append(dialog);
  return () => {
    if (!app.connection.watches) {
      dialog.showModal();
    }
  };
}

/**
 * @param {readonly (readonly [string, string])[]} choices
 * @param {string} label
 * @param {string} testid
 */
function choice(choices, label, testid) {
  return h('select', {'aria-label': label, 'data-testid': testid},
    ...choices.map(([value, text]) => h('option', {value}, text)));
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function meshPart(app, dialog) {
  const format = choice(MESHES, 'Format', 'export-format');
  const axes = choice([['LPS', 'LPS (DICOM)'], ['RAS', 'RAS (NIfTI)']], 'Axes',
    'save-axes');
  const keep = choice(KEEPS, 'Triangles kept', 'save-keep');
  const cap = h('input', {type: 'checkbox', 'data-testid': 'save-cap'});
  return h('section', {}, h('h3', {}, 'Mesh'),
    h('p', {class: 'muted'}, 'The visible surfaces, in patient coordinates (mm).'),
    h('div', {class: 'row wrap'}, format, axes, keep,
      h('label', {class: 'row', title: 'Closes the mesh at the border of the scan and at clip '
        + 'planes'}, cap, 'closed at cuts'), h('span', {class: 'grow'}),
      h('button', {class: 'primary', 'data-testid': 'export-go', onclick: () => {
        dialog.close();
        void saveMesh(app, `${baseName(app)}.${format.value}`, ` axes=${axes.value}`
          + (keep.value ? ` keep=${keep.value}` : '') + (cap.checked ? ' cap=yes' : ''));
      }}, 'Save mesh')));
}

/**
 * Draws the picture on the machine, with as many samples per pixel as there is memory for.
 * @param {App} app
 * @param {string} name
 * @param {string} size  WIDTHxHEIGHT, of one eye's picture.
 * @returns {Promise<{href: string, samples: number} | null>}  null after an error, which is shown.
 */
async function drawn(app, name, size) {
  let text = '';
  for (const samples of SAMPLES) {
    const {ok, result, error = ''} = await app.connection.do(`snapshot download:${word(name)} `
      + `size=${size} samples=${samples} overlay=off`, {quiet: true});
    if (ok && result?.download) {
      return {href: address(result.download).href, samples};
    }
    text = error;
    if (!NO_ROOM.test(error)) {
      break;
    }
  }
  app.toasts.error(text);
  return null;
}

/**
 * The size of a saved picture: all sides grow by the same factor, up to MOST_PX.
 * @param {number[]} size  Of the picture on the screen.
 * @param {number} factor
 */
function enlarged(size, factor) {
  const least = Math.min(factor, MOST_PX / Math.max(...size));
  return size.map(side => Math.round(side * least));
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function picturePart(app, dialog) {
  const format = choice([['png', 'PNG'], ['tif', 'TIFF, no marks'], ['exr', 'OpenEXR, no marks']],
    'Format', 'save-picture-format');
  const scale = choice([['1', 'as on the screen'], ['2', 'twice'], ['3', '3 times'],
    ['4', '4 times']], 'Size', 'save-picture-size');
  const mark = (/** @type {string} */ testid) =>
    h('input', {type: 'checkbox', checked: true, 'data-testid': testid});
  const marks = mark('save-overlay'), legend = mark('save-legend');
  const save = async () => {
    const name = `${baseName(app)}.${format.value}`;
    const eye = enlarged(app.store.state?.size ?? [1, 1], Number(scale.value));
    const [width, height] = app.picture.wholeSize(eye);
    dialog.close();
    const picture = await drawn(app, name, eye.join('x'));
    if (!picture) {
      return;
    }
    const {href, samples} = picture;
    if (format.value !== 'png') {
      saveAs(href, name);
    } else {
      const drawing = await (await fetch(href)).blob();
      saveBlob(await app.picture.marked(drawing,
        {marks: marks.checked, legend: [...marks.checked || legend.checked ? warningOf(app) : [],
          ...legend.checked ? legendOf(app) : []]}), name);
    }
    app.toasts.info(`Saved ${name}, ${width} × ${height} pixels, ${samples} `
      + `sample${samples === 1 ? '' : 's'} per pixel.${fewSamples(app, samples)}`);
  };
  return h('section', {}, h('h3', {}, 'Picture'),
    h('div', {class: 'row wrap'}, format, scale,
      h('label', {class: 'row'}, marks, 'letters, scale, measurements'),
      h('label', {class: 'row'}, legend, 'legend'), h('span', {class: 'grow'}),
      h('button', {class: 'primary', 'data-testid': 'snapshot', onclick: () => void save()},
        'Save picture')));
}

/**
 * Reports what a picture lacks that is drawn with fewer samples than the screen's.
 * @param {App} app
 * @param {number} samples  Per pixel.
 */
function fewSamples({store}, samples) {
  const isTransparent = store.state?.surfaces.some(({visible, opacity}) => visible && opacity < 1);
  return samples > 1 || !isTransparent ? ''
    : ' The Renderers have no memory for more samples at this size: transparent surfaces look '
      + 'like a grid. Choose a smaller size.';
}

/**
 * @param {App} app
 * @returns {LegendLine[]}
 */
function warningOf({store}) {
  const text = placeWarning(store.state?.volume ?? null);
  return text === '' ? [] : [{color: '', text}];
}

/**
 * The volume's name and the visible surfaces.
 * @param {App} app
 * @returns {LegendLine[]}
 */
function legendOf({store}) {
  const {volume, archive, surfaces = []} = store.state ?? {};
  const unit = volume?.unit ?? '';
  return [{color: '', text: volume?.name ?? archive ?? ''},
    ...surfaces.filter(({visible}) => visible).map(({color, name, isovalue}) =>
      ({color, text: `${name}  ${short(isovalue)} ${unit}`.trim()}))];
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function sessionPart(app, dialog) {
  const input = h('input', {type: 'file', hidden: true, accept: SESSION_ENDING,
    'data-testid': 'session-open'});
  input.addEventListener('change', () => {
    dialog.close();
    const [file] = input.files ?? [];
    if (file) {
      void openSession(app, file);
    }
    input.value = '';
  });
  const note = h('p', {class: 'muted', 'data-testid': 'session-note'});
  app.store.subscribe(['volume'], ({volume}) => {
    note.textContent = 'A script of this scene with the path of its volume, for this page and for '
      + 'pxpl5 run. It has window, crosshair and measurements, too. ' + (isUpload(volume)
      ? 'Keep the files that you dropped: the server keeps its copy until it ends or needs the '
        + 'room, and then asks for the files.' : '');
  });
  return h('section', {}, h('h3', {}, 'Session'), note,
    h('div', {class: 'row'}, input, h('span', {class: 'grow'}),
      h('button', {'data-testid': 'reopen-session',
        onclick: () => input.click()}, 'Reopen a session …'),
      h('button', {class: 'primary', 'data-testid': 'session-save', onclick: async () => {
        dialog.close();
        const text = await sessionText(app);
        if (text !== '') {
          const name = baseName(app) + SESSION_ENDING;
          saveBlob(new Blob([text], {type: 'text/plain'}), name);
          app.toasts.info(`Saved ${name}.`);
        }
      }}, 'Save session')));
}

/**
 * Whether the volume came from the browser: its path is in a folder of the server's uploads.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
function isUpload(volume) {
  return /\/uploads\/\d+-[\w-]+\//.test(volume?.source ?? '');
}
