// Uploads files and opens them.
import {byId, h} from '../elements/dom.js';
import {word} from '../link/lines.js';
import {address} from '../link/token.js';

/** @typedef {import('../panel/app.js').App} App */

const MOST_FILES = 100000;          // The server's limits: host/serve/README.md.
const MOST_BYTES = 4 * 2 ** 30;
const AT_ONCE = 4;                  // Requests of an upload.
/** File name ending of a session. */
export const SESSION_ENDING = '.pxpl5';

/** @typedef {{file: File, name: string}} Named  The name may hold folders: "a/b.dcm". */

/**
 * Uploads files and opens them: replays a session, or loads all files as one volume.
 * @param {App} app
 * @param {Named[]} files
 */
export async function openFiles(app, files) {
  const path = await upload(app, files);
  if (path !== null) {
    const isSession = files.length === 1 && files[0].name.endsWith(SESSION_ENDING);
    await (isSession ? app.connection.do(`play ${word(path)}`) : loadVolume(app, word(path)));
  }
}

/**
 * Opens a volume and resets the view, whose zoom and pan belong to the previous volume.
 * @param {App} app
 * @param {string} words  Arguments of `load`.
 * @param {{quiet?: boolean}} [options]  quiet: the caller shows the error.
 */
export async function loadVolume({connection}, words, options = {}) {
  const reply = await connection.do(`load ${words}`, options);
  if (reply.ok) {
    await connection.do('view anterior zoom=1');
  }
  return reply;
}

/**
 * @param {App} app
 * @param {Named[]} files
 * @returns {Promise<string | null>} path on the server; null after an error, which is shown
 */
async function upload(app, files) {
  const {hello, watches} = app.connection;
  if (files.length === 0 || !hello || watches) {
    return null;
  }
  const total = files.reduce((sum, {file}) => sum + file.size, 0);
  if (files.length > MOST_FILES || total > MOST_BYTES) {
    app.toasts.error(`Cannot upload ${files.length.toLocaleString('en')} files with `
      + `${total.toLocaleString('en')} bytes: the limits are ${MOST_FILES.toLocaleString('en')} `
      + `files and ${MOST_BYTES.toLocaleString('en')} bytes. Enter their path instead.`);
    return null;
  }
  const batch = crypto.getRandomValues(new Uint32Array(1))[0].toString(16);
  const stop = new AbortController();
  const bar = h('progress', {max: total || 1, value: 0, 'aria-label': 'Upload progress'});
  const share = h('span', {class: 'number muted'}, '0 %');
  const box = h('div', {class: 'toast info upload', 'data-testid': 'uploading'},
    h('p', {}, `Uploading ${files.length === 1 ? files[0].name : `${files.length} files`} …`),
    share, h('button', {onclick: () => stop.abort()}, 'Cancel'), bar);
  byId('toasts').append(box);
  /** @type {Map<File, number>} bytes sent of each file */
  const sent = new Map();
  const tell = (/** @type {File} */ file, /** @type {number} */ bytes) => {
    sent.set(file, Math.min(bytes, file.size));
    bar.value = [...sent.values()].reduce((sum, each) => sum + each, 0);
    share.textContent = `${Math.floor(bar.value / bar.max * 100)} %`;
  };
  // Several at once: on a slow link each request waits mostly for its answer.
  const rest = [...files];
  const sendRest = async () => {
    for (let next = rest.shift(); next; next = rest.shift()) {
      const {file, name} = next;
      await post(address('upload', {name, batch}), file, stop.signal, bytes => tell(file, bytes));
      tell(file, file.size);
    }
  };
  try {
    await Promise.all(Array.from({length: Math.min(AT_ONCE, files.length)}, sendRest));
    return (await post(address('upload/done', {batch}), null, stop.signal)).path;
  } catch (error) {
    if (!stop.signal.aborted) {
      stop.abort();
      app.toasts.error(`Upload failed: ${/** @type {Error} */ (error).message}`);
    }
    return null;
  } finally {
    box.remove();
  }
}

/**
 * Sends with XMLHttpRequest, since `fetch` tells no progress.
 * @param {URL} url
 * @param {File | null} body
 * @param {AbortSignal} signal
 * @param {(bytes: number) => void} [progress]  Called with the number of bytes sent so far.
 * @returns {Promise<any>} the answer's JSON; {} if it has none
 * @throws {Error} with the server's sentence
 */
function post(url, body, signal, progress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', url);
    request.upload.onprogress = ({loaded}) => progress?.(loaded);
    request.onload = () => {
      const said = parsed(request.responseText);
      if (request.status >= 200 && request.status < 300) {
        resolve(said);
      } else {
        reject(new Error(said.error
          ?? `the server answered ${request.status} ${request.statusText}`));
      }
    };
    request.onerror = () => reject(new Error('the connection was lost'));
    request.onabort = () => reject(new Error('canceled'));
    signal.addEventListener('abort', () => request.abort());
    request.send(body);
  });
}

/**
 * @param {string} text
 * @returns {any} {} if the text is no JSON
 */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return {};
  }
}
