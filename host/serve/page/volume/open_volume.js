// Opens a volume: a path on the server's computer, dropped files, or a built-in volume. The
// browser unpacks dropped ZIP archives.
import {closeBeside} from '../elements/dialog.js';
import {h, setMessage} from '../elements/dom.js';
import {word} from '../link/lines.js';
import {say} from '../texts/say.js';
import {createFileBrowser} from './file_browser.js';
import {createOptions} from './open_options.js';
import {createRecentFiles, rememberFile} from './recent_files.js';
import {createSeries} from './series_list.js';
import {sourceOf} from './session_file.js';
import {continueSession, openFiles} from './upload.js';
import {UPLOAD} from './words.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('./upload.js').Named} Named */

const PHANTOMS = [
  {name: 'pelvis', about: say`CT of skin and bone, as in the paper`},
  {name: 'head', about: say`CT of a head with fine structures`},
  {name: 'fetus', about: say`Ultrasound, noisy`},
  {name: 'letters', about: say`Shows left and right in every view`},
  {name: 'torus', about: say`Known area and volume`},
  {name: 'sphere', about: say`Known area and volume`},
];

/**
 * @param {App} app
 * @returns {() => void} shows the dialog
 */
export function createOpenDialog(app) {
  const path = h('input', {type: 'text', class: 'grow', id: 'open-path', autocomplete: 'off',
    spellcheck: 'false', 'data-testid': 'open-path'});
  const options = createOptions();
  const dialog = h('dialog', {id: 'open', 'aria-labelledby': 'open-title', 'data-testid': 'open'});
  const wrong = h('p', {class: 'wrong', role: 'alert', hidden: true, 'data-testid': 'open-error'});
  const series = createSeries(app);
  let isLoading = false;
  let dropped = '';  // Path of the files that were not opened: options may be missing.
  /**
   * @param {string} text  Why nothing was opened.
   * @param {boolean} [isOwn]  See setMessage.
   */
  const tell = (text, isOwn = true) => {
    setMessage(wrong, text, isOwn);
    wrong.hidden = text === '';
    series.show('', '', () => {});
    options.root.hidden = app.session.wanting !== null;  // The session has its own options.
    if (!dialog.open) {
      dialog.showModal();
      recent.show();
      void browser.show();
    }
  };
  /**
   * @param {string} source
   * @param {string} [given]  Options of `load`, a blank before each.
   */
  const load = async (source, given = '') => {
    if (isLoading) {
      return;
    }
    isLoading = true;
    wrong.hidden = true;
    const reply = await app.connection.do(`load ${word(source)}${given}`, {quiet: true});
    isLoading = false;
    if (reply.ok) {
      if (!UPLOAD.test(source) && !source.startsWith('phantom:')) {
        rememberFile(source);
      }
      options.clear();
      dialog.close();
      return;
    }
    const error = (reply.error ?? '').replace(UPLOAD, '');
    tell(error, reply.isOwn ?? false);
    [path.value, dropped] = UPLOAD.test(source) ? ['', source] : [source, ''];
    const isChoice = series.show(error, source, number => {
      options.set('series', number);
      void load(source, options.words());
    });
    if (isChoice) {
      wrong.hidden = true;
    } else {
      options.hint(error);
    }
  };
  app.session.ask = ({name, script}, why) => {
    path.value = sourceOf(script).replace(UPLOAD, '');
    options.clear();
    tell(say`${why.replace(UPLOAD, '')}. The session ${name} continues with the files that you
      choose or drop here.`);
  };
  const dismiss = () => {
    app.session.wanting = null;
    options.clear();
    dialog.close();
  };
  dialog.addEventListener('cancel', dismiss);
  // The progress of a long load appears over the picture, with a Cancel button.
  app.connection.on('progress', progress => {
    if (progress && isLoading) {
      dialog.close();
    }
  });
  const open = (/** @type {Named[]} */ chosen) => {
    // A file that is dropped beside the closed dialog has no options that the user sees.
    const given = dialog.open ? options.words() : '';
    dialog.close();
    void openFiles(app, chosen, source => void load(source, given));
  };
  const openPhantom = (/** @type {string} */ name) => {
    app.session.wanting = null;
    void load(`phantom:${name}`, options.words());
  };
  const openPath = () => {
    const source = path.value.trim() || dropped;
    if (source !== '' && app.session.wanting) {
      dialog.close();
      void continueSession(app, source);
    } else if (source !== '') {
      void load(source, options.words());
    }
  };
  const pick = (/** @type {string} */ chosen) => { path.value = chosen; };
  const browser = createFileBrowser(app, {pick, open: openPath});
  const recent = createRecentFiles(chosen => {
    pick(chosen);
    openPath();
  });
  const files = fileInput(open, false), folder = fileInput(open, true);
  dialog.append(
    h('div', {class: 'row spread'}, h('h2', {id: 'open-title'}, say`Open a volume`),
      h('button', {class: 'quiet icon', 'aria-label': say`Close`,
        onclick: dismiss}, '×')),
    h('form', {method: 'dialog', onsubmit: (/** @type {Event} */ event) => {
      event.preventDefault();
      openPath();
    }},
      h('label', {for: 'open-path'}, say`File or DICOM folder on the computer that runs pxpl5`),
      h('div', {class: 'row'}, path,
        h('button', {class: 'primary', 'data-testid': 'open-go'}, say`Open`)),
      wrong, series.root, browser.root, recent.root, options.root),
    h('p', {}, say`From this computer`),
    h('div', {class: 'drop row', 'data-testid': 'drop'},
      h('span', {class: 'grow muted'}, say`Drop files, a DICOM folder or a ZIP archive anywhere on
        the page, or`),
      h('button', {onclick: () => files.click()}, say`Choose files`),
      h('button', {onclick: () => folder.click()}, say`Choose a folder`), files, folder),
    h('p', {}, say`Built in`),
    h('div', {class: 'cards'}, ...PHANTOMS.map(({name, about}) => h('button', {class: 'card',
      'data-testid': `phantom-${name}`, onclick: () => openPhantom(name)},
      h('strong', {}, name), h('span', {class: 'muted'}, about)))));
  closeBeside(dialog, dismiss);
  document.body.append(dialog);
  watchDrops(open);
  return () => {
    if (!app.connection.watches) {
      app.session.wanting = null;
      dropped = '';
      tell('');
      path.focus();
    }
  };
}

/**
 * @param {(files: Named[]) => void} open
 * @param {boolean} isFolder
 */
function fileInput(open, isFolder) {
  const input = h('input', {type: 'file', multiple: true, hidden: true, webkitdirectory: isFolder,
    'data-testid': isFolder ? 'open-folder' : 'open-files'});
  input.addEventListener('change', () => {
    open([...input.files ?? []].map(file => ({file, name: file.webkitRelativePath || file.name})));
    input.value = '';
  });
  return input;
}

/** @param {(files: Named[]) => void} open */
function watchDrops(open) {
  const hold = (/** @type {DragEvent} */ event) => {
    if (event.dataTransfer?.types.includes('Files')) {
      event.preventDefault();
      document.body.dataset.drop = say`Drop to open`;
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
    // The browser empties the transfer at the first await.
    const entries = [...event.dataTransfer.items].map(item => item.webkitGetAsEntry());
    const found = [];
    for (const entry of entries) {
      found.push(...entry ? await filesIn(entry) : []);
    }
    open(found);
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
