// Sends files to the server, which opens them when all are there.
import {byId, h} from './dom.js';

/** @typedef {import('./types.js').App} App */

const MOST_FILES = 100000;          // The server's limits: host/serve/README.md.
const MOST_BYTES = 4 * 2 ** 30;

/**
 * An address beside the page, with the token that the page was opened with.
 * @param {string} path
 * @param {Record<string, string>} query
 */
export function address(path, query) {
  const url = new URL(path, location.href);
  const token = new URLSearchParams(location.search).get('token');
  url.search = new URLSearchParams({...query, ...(token ? {token} : {})}).toString();
  return url;
}

/**
 * @param {App} app
 * @param {{file: File, name: string}[]} files
 */
export async function upload(app, files) {
  if (files.length === 0 || app.connection.watches) {
    return;
  }
  const total = files.reduce((sum, {file}) => sum + file.size, 0);
  if (files.length > MOST_FILES || total > MOST_BYTES) {
    app.toasts.error(`${files.length} files with ${total} bytes are too many: at most `
      + `${MOST_FILES} files with ${MOST_BYTES} bytes can be sent. Give their path instead.`);
    return;
  }
  const batch = crypto.getRandomValues(new Uint32Array(1))[0].toString(16);
  const stop = new AbortController();
  const bar = h('progress', {max: total || 1, value: 0, 'aria-label': 'Sent'});
  const box = h('div', {class: 'toast info', 'data-testid': 'uploading'},
    h('p', {}, `Sending ${files.length === 1 ? files[0].name : `${files.length} files`} …`),
    bar, h('button', {onclick: () => stop.abort()}, 'Cancel'));
  byId('toasts').append(box);
  try {
    let sent = 0;
    for (const {file, name} of files) {
      await post(address('upload', {name, batch}), file, stop.signal);
      sent += file.size;
      bar.value = sent;
    }
    await post(address('upload/done', {batch}), null, stop.signal);
  } catch (error) {
    if (!stop.signal.aborted) {
      app.toasts.error(`The files were not opened: ${/** @type {Error} */ (error).message}`);
    }
  } finally {
    box.remove();
  }
}

/**
 * @param {URL} url
 * @param {File | null} body
 * @param {AbortSignal} signal
 */
async function post(url, body, signal) {
  const response = await fetch(url, {method: 'POST', body, signal});
  if (!response.ok) {
    // The server says why in JSON; anything between it and us may say what it likes.
    const said = await response.json().catch(() => ({}));
    throw new Error(said.error
      ?? `the server answered ${response.status} ${response.statusText}`);
  }
}
