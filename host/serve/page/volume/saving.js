// Saves a mesh, a picture or the session, and reopens a session.
import {closeBeside} from '../elements/dialog.js';
import {h} from '../elements/dom.js';
import {saveAs, saveBlob} from '../elements/save_file.js';
import {word} from '../link/lines.js';
import {address} from '../link/token.js';
import {say} from '../texts/say.js';
import {createPrivacyHint} from './privacy.js';
import {filmPart} from './save_film.js';
import {baseName, choice} from './save_parts.js';
import {picturePart} from './save_picture.js';
import {sessionText} from './session_file.js';
import {openSession, SESSION_ENDING} from './upload.js';

/** @typedef {import('../panel/app.js').App} App */

const MESHES = /** @type {const} */ ([['glb', 'glTF binary (.glb)'], ['stl', 'STL (.stl)'],
  ['ply', 'PLY (.ply)'], ['obj', 'Wavefront (.obj)'], ['vtp', 'VTK (.vtp)']]);
const KEEPS = /** @type {const} */ ([['', say`all triangles`], [' keep=0.5', '50 %'],
  [' keep=0.25', '25 %'], [' keep=0.1', '10 %'], [' error=0.1', say`within 0.1 mm`],
  [' error=0.5', say`within 0.5 mm`]]);
const SMOOTHINGS = /** @type {const} */ ([['', say`not smoothed`],
  [' smoothing=10', say`smoothed a little`], [' smoothing=50', say`smoothed`]]);

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
  const certificate = String(result.certificate).split('/').at(-1) ?? '';
  const besides = [{key: 'certificate', text: say`certificate`, file: certificate}];
  if (name.endsWith('.obj')) {
    besides.push({key: 'colors', text: say`colors`, file: name.replace(/obj$/, 'mtl')});
  }
  app.toasts.info(result.closed ? say`Saved ${name}, closed.`
    : say`Saved ${name}, open: see the certificate.`,
    besides.map(({key, text, file}) => h('a', {download: file, 'data-testid': `saved-${key}`,
      href: address(result.download.replace(/[^/]*$/, encodeURIComponent(file))).href}, text)));
}

/**
 * @param {App} app
 * @returns {() => void} shows the dialog
 */
export function createSaveDialog(app) {
  const dialog = h('dialog', {id: 'save', 'aria-labelledby': 'save-title', 'data-testid': 'save'});
  const privacy = createPrivacyHint(app);
  const picture = picturePart(app, dialog), film = filmPart(app, dialog);
  dialog.append(
    h('div', {class: 'row spread'}, h('h2', {id: 'save-title'}, say`Save`),
      h('button', {class: 'quiet icon', 'aria-label': say`Close`,
        onclick: () => dialog.close()}, '×')),
    privacy.root,
    picture.element, film.element, meshPart(app, dialog), sessionPart(app, dialog));
  closeBeside(dialog);
  document.body.append(dialog);
  return () => {
    if (!app.connection.watches) {
      document.dispatchEvent(new Event('pauseseries'));
      picture.refresh();
      film.refresh();
      dialog.showModal();
      void privacy.show();
    }
  };
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function meshPart(app, dialog) {
  const format = choice(MESHES, say`Format`, 'export-format');
  const axes = choice([['LPS', 'LPS (DICOM)'], ['RAS', 'RAS (NIfTI)']], say`Axes`,
    'save-axes');
  const keep = choice(KEEPS, say`Triangles kept`, 'save-keep');
  const smoothing = choice(SMOOTHINGS, say`Smoothing`, 'save-smoothing');
  const cap = h('input', {type: 'checkbox', 'data-testid': 'save-cap'});
  return h('section', {}, h('h3', {}, say`Mesh`),
    h('p', {class: 'muted'}, say`The visible surfaces, in patient coordinates (mm).`),
    h('div', {class: 'row wrap'}, format, axes, keep, smoothing,
      h('label', {class: 'row', title: say`Closes the mesh at the border of the scan and at clip
        planes`}, cap, say`closed at cuts`), h('span', {class: 'grow'}),
      h('button', {class: 'primary', 'data-testid': 'export-go', onclick: () => {
        dialog.close();
        void saveMesh(app, `${baseName(app)}.${format.value}`, ` axes=${axes.value}`
          + keep.value + smoothing.value + (cap.checked ? ' cap=yes' : ''));
      }}, say`Save mesh`)));
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
    const about = say`A script of this scene with the path of its volume, for this page and for
      pxpl5 run. It has window, crosshair and measurements, too.`;
    const keep = isUpload(volume) ? say`Keep the files that you dropped: the server keeps its copy
      until it ends or needs the room, and then asks for the files.` : '';
    note.textContent = `${about} ${keep}`;
  });
  return h('section', {}, h('h3', {}, say`Session`), note,
    h('div', {class: 'row'}, input, h('span', {class: 'grow'}),
      h('button', {'data-testid': 'reopen-session',
        onclick: () => input.click()}, say`Reopen a session …`),
      h('button', {class: 'primary', 'data-testid': 'session-save', onclick: async () => {
        dialog.close();
        const text = await sessionText(app);
        if (text !== '') {
          const name = baseName(app) + SESSION_ENDING;
          saveBlob(new Blob([text], {type: 'text/plain'}), name);
          app.toasts.info(say`Saved ${name}.`);
        }
      }}, say`Save session`)));
}

/**
 * Whether the volume came from the browser: its path is in a folder of the server's uploads.
 * @param {import('../link/vocabulary.js').VolumeState | null} volume
 */
function isUpload(volume) {
  return /\/uploads\/\d+-[\w-]+\//.test(volume?.source ?? '');
}
