// Opens a volume: a path on the server's computer, dropped files, or a built-in volume.
import {h} from '../elements/dom.js';
import {word} from '../link/lines.js';
import {loadVolume, openFiles} from './upload.js';

/** @typedef {import('../panel/app.js').App} App */

const PHANTOMS = [
  {name: 'pelvis', about: 'CT of skin and bone, as in the paper'},
  {name: 'head', about: 'CT of a head with fine structures'},
  {name: 'fetus', about: 'Ultrasound, noisy'},
  {name: 'letters', about: 'Shows left and right in every view'},
  {name: 'torus', about: 'Known area and volume'},
  {name: 'sphere', about: 'Known area and volume'},
];

/**
 * @param {App} app
 * @returns {() => void} shows the dialog
 */
export function createOpenDialog(app) {
  const path = h('input', {type: 'text', class: 'grow', id: 'open-path', autocomplete: 'off',
    spellcheck: 'false', 'data-testid': 'open-path'});
  const options = createOptions();
  const dialog = h('dialog', {id: 'open', 'aria-labeledby': 'open-title', 'data-testid': 'open'});
  const wrong = h('p', {class: 'wrong', role: 'alert', hidden: true, 'data-testid': 'open-error'});
  let isLoading = false;
  /** @param {string} words  Arguments of `load`. */
  const load = async words => {
    if (isLoading) {
      return;
    }
    isLoading = true;
    wrong.hidden = true;
    const reply = await loadVolume(app, words, {quiet: true});
    isLoading = false;
    if (reply.ok) {
      dialog.close();
      return;
    }
    wrong.textContent = reply.error ?? '';
    wrong.hidden = false;
    if (!dialog.open) {
      dialog.showModal();
    }
    options.hint(reply.error ?? '');
  };
  // The progress of a long load appears over the picture, with a Cancel button.
  app.connection.on('progress', progress => {
    if (progress && isLoading) {
      dialog.close();
    }
  });
  const files = fileInput(app, dialog, false), folder = fileInput(app, dialog, true);
  dialog.append(
    h('div', {class: 'row spread'}, h('h2', {id: 'open-title'}, 'Open a volume'),
      h('button', {class: 'quiet icon', 'aria-label': 'Close',
        onclick: () => dialog.close()}, '×')),
    h('form', {method: 'dialog', onsubmit: (/** @type {Event} */ event) => {
      event.preventDefault();
      if (path.value.trim() !== '') {
        void load(word(path.value.trim()) + options.words());
      }
    }},
      h('label', {for: 'open-path'}, 'File or DICOM folder on the computer that runs pxpl5'),
      h('div', {class: 'row'}, path,
        h('button', {class: 'primary', 'data-testid': 'open-go'}, 'Open')),
      wrong, options.root),
    h('p', {}, 'From this computer'),
    h('div', {class: 'drop row', 'data-testid': 'drop'},
      h('span', {class: 'grow muted'}, 'Drop files or a DICOM folder anywhere on the page, or'),
      h('button', {onclick: () => files.click()}, 'Choose files'),
      h('button', {onclick: () => folder.click()}, 'Choose a folder'), files, folder),
    h('p', {}, 'Built in'),
    h('div', {class: 'cards'}, ...PHANTOMS.map(({name, about}) => h('button', {class: 'card',
      'data-testid': `phantom-${name}`, onclick: () => void load(`phantom:${name}`)},
      h('strong', {}, name), h('span', {class: 'muted'}, about)))));
  dialog.addEventListener('click', event => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  document.body.append(dialog);
  watchDrops(app, dialog);
  return () => {
    if (!app.connection.watches) {
      wrong.hidden = true;
      dialog.showModal();
      path.focus();
    }
  };
}

/** The options of `load`. */
function createOptions() {
  const rows = /** @type {const} */ ([
    ['crop', 'Crop', 'First and last voxel, e.g. 10:90,0:127,5:40'],
    ['resample', 'Resample', 'Number of voxels, e.g. 128x128x64'],
    ['resample_mm', 'Resample (mm)', 'New spacing in mm, e.g. 1,1,1'],
    ['smooth', 'Smooth', 'Standard deviation in mm, e.g. 1.5'],
    ['series', 'Series', 'Series of a DICOM folder, e.g. 2'],
    ['spacing', 'Spacing', 'In mm, if the file does not state it, e.g. 0.5,0.5,1'],
    ['raw', 'Raw layout', 'Of a file without a header, e.g. 64x64x32,int16'],
  ]).map(([key, label, title]) => {
    const input = h('input', {type: 'text', class: 'grow', id: `open-${key}`, title,
      autocomplete: 'off', 'data-testid': `open-${key}`});
    return {key, input, row: h('label', {class: 'row', title}, h('span', {class: 'field'}, label),
      input, h('span', {class: 'muted example'}, title))};
  });
  const root = h('details', {}, h('summary', {}, 'Options'), ...rows.map(({row}) => row));
  return {
    root,
    /** Shows the option that an error names, for example series=N. */
    hint: (/** @type {string} */ error) => {
      const asked = rows.find(({key}) => error.includes(`${key}=`));
      root.open ||= asked !== undefined;
      asked?.input.focus();
    },
    words: () => rows.filter(({input}) => input.value.trim() !== '')
      .map(({key, input}) => ` ${key}=${word(input.value.trim())}`).join(''),
  };
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 * @param {boolean} isFolder
 */
function fileInput(app, dialog, isFolder) {
  const input = h('input', {type: 'file', multiple: true, hidden: true, webkitdirectory: isFolder,
    'data-testid': isFolder ? 'open-folder' : 'open-files'});
  input.addEventListener('change', () => {
    dialog.close();
    void openFiles(app, [...input.files ?? []].map(file =>
      ({file, name: file.webkitRelativePath || file.name})));
    input.value = '';
  });
  return input;
}

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
function watchDrops(app, dialog) {
  const hold = (/** @type {DragEvent} */ event) => {
    if (event.dataTransfer?.types.includes('Files')) {
      event.preventDefault();
      document.body.classList.toggle('dropping', event.type !== 'dragleave'
        || event.relatedTarget !== null);
    }
  };
  document.addEventListener('dragover', hold);
  document.addEventListener('dragleave', hold);
  document.addEventListener('drop', async event => {
    document.body.classList.remove('dropping');
    if (!event.dataTransfer?.types.includes('Files')) {
      return;
    }
    event.preventDefault();
    dialog.close();
    // The browser empties the transfer at the first await.
    const entries = [...event.dataTransfer.items].map(item => item.webkitGetAsEntry());
    const found = [];
    for (const entry of entries) {
      found.push(...entry ? await filesIn(entry) : []);
    }
    void openFiles(app, found);
  });
}

/**
 * All files of an entry, including the files in its folders.
 * @param {FileSystemEntry} entry
 * @returns {Promise<{file: File, name: string}[]>}
 */
async function filesIn(entry) {
  if (entry.isFile) {
    const file = await new Promise((take, fail) =>
      /** @type {FileSystemFileEntry} */ (entry).file(take, fail));
    return [{file, name: entry.fullPath.replace(/^\//, '')}];
  }
  const reader = /** @type {FileSystemDirectoryEntry} */ (entry).createReader();
  const found = [];
  for (;;) {
    // A reader returns some entries at a time and none at the end.
    const some = await new Promise((take, fail) => reader.readEntries(take, fail));
    if (some.length === 0) {
      return found;
    }
    for (const each of some) {
      found.push(...await filesIn(each));
    }
  }
}
