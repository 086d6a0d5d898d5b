// Saves a mesh, a picture or the session, and reopens a session.
import {h} from '../elements/dom.js';
import {word} from '../link/lines.js';
import {address} from '../link/token.js';
import {openFiles, SESSION_ENDING} from './upload.js';

/** @typedef {import('../panel/app.js').App} App */

const MESHES = /** @type {const} */ ([['glb', 'glTF binary (.glb)'], ['stl', 'STL (.stl)'],
  ['ply', 'PLY (.ply)'], ['obj', 'Wavefront (.obj)'], ['vtp', 'VTK (.vtp)']]);
const KEEPS = /** @type {const} */ ([['', 'all triangles'], ['0.5', '50 %'],
  ['0.25', '25 %'], ['0.1', '10 %']]);

/**
 * Lets the browser save the file at an address.
 * @param {string} href
 * @param {string} name
 */
function saveAs(href, name) {
  const link = h('a', {href, download: name});
  document.body.append(link);
  link.click();
  link.remove();
}

/**
 * Runs a command that writes a download, then saves the file.
 * @param {App} app
 * @param {string} line
 * @param {string} name
 */
async function download(app, line, name) {
  const reply = await app.connection.do(line);
  const path = reply.result?.download;
  if (reply.ok && path) {
    saveAs(address(path).href, name);
    app.toasts.info(`Saved ${name}.`);
  }
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
  const dialog = h('dialog', {id: 'save', 'aria-labeledby': 'save-title', 'data-testid': 'save'});
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
  return h('section', {}, h('h3', {}, 'Mesh'),
    h('p', {class: 'muted'}, 'The visible surfaces, in patient coordinates (mm).'),
    h('div', {class: 'row wrap'}, format, axes, keep, h('span', {class: 'grow'}),
      h('button', {class: 'primary', 'data-testid': 'export-go', onclick: () => {
        const name = `${baseName(app)}.${format.value}`;
        dialog.close();
        void download(app, `export download:${word(name)} axes=${axes.value}`
          + (keep.value ? ` keep=${keep.value}` : ''), name);
      }}, 'Save mesh')));
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function picturePart(app, dialog) {
  const format = choice([['png', 'PNG'], ['tif', 'TIFF'], ['exr', 'OpenEXR']], 'Format',
    'save-picture-format');
  const overlay = h('input', {type: 'checkbox', 'data-testid': 'save-overlay'});
  return h('section', {}, h('h3', {}, 'Picture'),
    h('div', {class: 'row wrap'}, format,
      h('label', {class: 'row'}, overlay, 'with letters and scale bar'), h('span', {class: 'grow'}),
      h('button', {class: 'primary', 'data-testid': 'snapshot', onclick: async () => {
        const name = `${baseName(app)}.${format.value}`;
        dialog.close();
        await app.connection.do(`overlay ${overlay.checked ? 'on' : 'off'}`);
        void download(app, `snapshot download:${word(name)}`, name);
      }}, 'Save picture')));
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
    void openFiles(app, [...input.files ?? []].map(file => ({file, name: file.name})));
    input.value = '';
  });
  return h('section', {}, h('h3', {}, 'Session'),
    h('p', {class: 'muted'}, 'A script that repeats all commands of this session, here or with '
      + 'pxpl5 run.'),
    h('div', {class: 'row'}, input, h('span', {class: 'grow'}),
      h('button', {'data-testid': 'reopen-session',
        onclick: () => input.click()}, 'Reopen a session …'),
      h('button', {class: 'primary', 'data-testid': 'session-save', onclick: async () => {
        dialog.close();
        const reply = await app.connection.do('history');
        if (reply.ok) {
          const href = URL.createObjectURL(new Blob([reply.result?.script ?? reply.text ?? ''],
            {type: 'text/plain'}));
          saveAs(href, baseName(app) + SESSION_ENDING);
          URL.revokeObjectURL(href);
        }
      }}, 'Save session')));
}
