// Uploads files and opens them.
import {byId, h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {address} from '../link/token.js';
import {plural, say} from '../texts/say.js';
import {playSession, withVolume} from './session_file.js';
import {isArchive, unzipped} from './unzip.js';

/** @typedef {import('../panel/app.js').App} App */

const MOST_FILES = 100000;          // The server's limits: host/serve/README.md.
const MOST_BYTES = 4 * 2 ** 30;
const AT_ONCE = 4;                  // Requests of an upload.
const REQUEST_BYTES = 8 * 2 ** 20;  // Files share a request up to this size.
/** File name ending of a session. */
export const SESSION_ENDING = '.pxpl5';

/** @typedef {{file: File, name: string}} Named  The name may hold folders: "a/b.dcm". */

/**
 * Uploads files and opens them: a session, the volume of a session that waits for it, or a volume.
 * @param {App} app
 * @param {Named[]} files
 * @param {(path: string) => void} load  Opens a volume on the server.
 */
export async function openFiles(app, files, load) {
  const {wanting} = app.session;
  if (!canUpload(app)) {
    return;
  }
  if (files.length === 1 && files[0].name.endsWith(SESSION_ENDING)) {
    await openSession(app, files[0].file);
    return;
  }
  const plain = await withoutArchives(app, files);
  const path = plain && await upload(app, plain);
  if (path !== null && wanting && app.session.wanting === wanting) {
    await continueSession(app, path);
  } else if (path !== null) {
    load(path);
  }
}

/** @param {App} app */
function canUpload({connection: {hello, watches}}) {
  return hello !== null && !watches;
}

/**
 * Opens the session that waits for its volume.
 * @param {App} app
 * @param {string} path  Of the volume, on the server.
 */
export async function continueSession(app, path) {
  const {wanting} = app.session;
  app.session.wanting = null;
  if (wanting) {
    await play(app, {...wanting, script: withVolume(wanting.script, path)});
  }
}

/**
 * @param {App} app
 * @param {File} file
 */
export async function openSession(app, file) {
  app.session.wanting = null;
  await play(app, {name: file.name, script: await file.text()});
}

/**
 * @param {App} app
 * @param {import('../link/types.js').Session} session
 */
function play(app, session) {
  return playSession(app, session, script =>
    upload(app, [{file: new File([script], session.name), name: session.name}]));
}

/**
 * The files, and instead of each ZIP archive the files in it. An archive inside of a folder stays
 * as it is.
 * @param {App} app
 * @param {Named[]} files
 * @returns {Promise<Named[] | null>} null after an error, which is shown
 */
async function withoutArchives(app, files) {
  const isDropped = (/** @type {Named} */ {name}) => isArchive(name) && !name.includes('/');
  const found = files.filter(named => !isDropped(named));
  for (const named of files.filter(isDropped)) {
    const most = {files: MOST_FILES - found.length, bytes: MOST_BYTES - bytesOf(found)};
    const work = showWork(say`Unpacking ${named.file.name} …`, say`Progress of unpacking`);
    try {
      found.push(...await unzipped(named.file, most, work.stop.signal, work.show));
    } catch (error) {
      const {message} = /** @type {Error} */ (error), {wanting} = app.session;
      if (!work.stop.signal.aborted && wanting) {
        app.session.ask(wanting, message);
      } else if (!work.stop.signal.aborted) {
        app.toasts.error(message);
      }
      return null;
    } finally {
      work.end();
    }
  }
  return found;
}

/**
 * Shows the progress of some work, with a button that cancels it.
 * @param {string} text
 * @param {string} label  Name of the progress bar.
 */
function showWork(text, label) {
  const stop = new AbortController();
  const bar = h('progress', {max: 1, value: 0, 'aria-label': label});
  const percent = h('span', {class: 'number muted'}, '0 %');
  const box = h('div', {class: 'toast info upload', 'data-testid': 'uploading'}, h('p', {}, text),
    percent, h('button', {onclick: () => stop.abort()}, say`Cancel`), bar);
  byId('toasts').append(box);
  return {
    stop,
    show: (/** @type {number} */ share) => {
      bar.value = share;
      percent.textContent = `${Math.floor(bar.value * 100)} %`;
    },
    end: () => box.remove(),
  };
}

/**
 * @param {App} app
 * @param {Named[]} files
 * @returns {Promise<string | null>} path on the server; null after an error, which is shown
 */
async function upload(app, files) {
  if (files.length === 0 || !canUpload(app)) {
    return null;
  }
  const total = bytesOf(files);
  if (files.length > MOST_FILES || total > MOST_BYTES) {
    app.toasts.error(say`Cannot upload ${grouped(files.length)} files with
      ${grouped(total)} bytes: the limits are ${grouped(MOST_FILES)}
      files and ${grouped(MOST_BYTES)} bytes. Enter their path instead.`);
    return null;
  }
  const batch = crypto.getRandomValues(new Uint32Array(1))[0].toString(16);
  const what = plural(files.length, files[0].name, say`${grouped(files.length)} files`);
  const {stop, show, end} = showWork(say`Uploading ${what} …`, say`Upload progress`);
  /** @type {number[]} bytes sent of each request */
  const sent = [];
  const requests = requestsOf(files);
  const sendRest = async () => {
    for (let n = sent.length; n < requests.length; n = sent.length) {
      sent.push(0);
      await post(address('upload/files', {batch}), bodyOf(requests[n]), stop.signal, bytes => {
        sent[n] = bytes;
        show(sent.reduce((sum, each) => sum + each, 0) / (total || 1));
      });
    }
  };
  try {
    // Several at once: on a slow link each request waits mostly for its answer.
    await Promise.all(Array.from({length: AT_ONCE}, sendRest));
    return (await post(address('upload/done', {batch}), null, stop.signal)).path;
  } catch (error) {
    if (!stop.signal.aborted) {
      stop.abort();
      app.toasts.error(say`Upload failed: ${/** @type {Error} */ (error).message}`);
    }
    return null;
  } finally {
    end();
  }
}

/** @param {Named[]} files */
function bytesOf(files) {
  return files.reduce((sum, {file}) => sum + file.size, 0);
}

/**
 * Files by request: small files travel together, since each request waits for its answer.
 * @param {Named[]} files
 */
function requestsOf(files) {
  /** @type {Named[][]} */
  const requests = [];
  let bytes = Infinity;
  for (const named of files) {
    bytes += named.file.size;
    if (bytes > REQUEST_BYTES) {
      requests.push([]);
      bytes = named.file.size;
    }
    requests[requests.length - 1].push(named);
  }
  return requests;
}

/**
 * Before each file: the length of its name, its size, its name.
 * @param {Named[]} files
 */
function bodyOf(files) {
  return new Blob(files.flatMap(({file, name}) => {
    const text = new TextEncoder().encode(name);
    const lengths = new DataView(new ArrayBuffer(12));
    lengths.setUint32(0, text.length, true);
    lengths.setBigUint64(4, BigInt(file.size), true);
    return [lengths.buffer, text, file];
  }));
}

/**
 * Sends with XMLHttpRequest, since `fetch` tells no progress.
 * @param {URL} url
 * @param {Blob | null} body
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
          ?? say`the server answered ${request.status} ${request.statusText}`));
      }
    };
    request.onerror = () => reject(new Error(say`the connection was lost`));
    request.onabort = () => reject(new DOMException('', 'AbortError'));
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
