// Files of sessions: a script of the scene, and a comment with the page's own part.
import {ENGLISH} from '../elements/dom.js';
import {OPENING} from '../elements/toasts.js';
import {word} from '../link/lines.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/types.js').Session} Session */

const PAGE = '# page ';
/** An error of the line that opens the volume, or that finds another one there. */
const WHERE = /^.*?, line \d+, '.*?': /s;
const IS_OF_DATA = /, line \d+, '(load|info) /;

/**
 * The file of the present scene, '' after an error, which is shown.
 * @param {App} app
 */
export async function sessionText({connection, session}) {
  const {ok, result} = await connection.do('history form=scene');
  return ok ? `# A session of pxpl5: open it in the page, or with pxpl5 run.\n${result?.script}`
    + `${PAGE}${JSON.stringify(session.saved())}\n` : '';
}

/**
 * Plays a session. Asks for the files of a volume that is missing.
 * @param {App} app
 * @param {Session} session
 * @param {(script: string) => Promise<string | null>} upload  Returns the path on the server.
 */
export async function playSession(app, session, upload) {
  const {connection, store, toasts} = app;
  const path = await upload(withoutFiles(app, session.script));
  if (path === null) {
    return;
  }
  const {ok, error = '', isOwn, revision = 0} =
    await connection.do(`play ${word(path)}`, {quiet: true});
  const hasOneVolume = session.script.match(/^load\s/gm)?.length === 1;
  if (!ok && hasOneVolume && IS_OF_DATA.test(error)) {
    app.session.wanting = session;
    app.session.ask(session, error.replace(WHERE, ''));
    return;
  }
  if (!ok) {
    toasts.error(error, OPENING, isOwn ? {} : ENGLISH);
    return;
  }
  const line = session.script.split('\n').find(each => each.startsWith(PAGE));
  // The state comes after the reply, and a new volume resets the page's part.
  await store.until(['revision'], state => state.revision >= revision);
  const errors = app.session.restore(line ? parsed(line.slice(PAGE.length)) : {});
  errors.forEach(each => toasts.error(each));
}

/**
 * The volume that a script loads.
 * @param {string} script
 */
export function sourceOf(script) {
  return /^load\s+("[^"]*"|'[^']*'|\S+)/m.exec(script)?.[1].replace(/^["']|["']$/g, '') ?? '';
}

/**
 * The script with another volume.
 * @param {string} script
 * @param {string} path
 */
export function withVolume(script, path) {
  return script.replace(/^load\s+("[^"]*"|'[^']*'|\S+)/m, () => `load ${word(path)}`);
}

/**
 * The script without commands that write files: opening a session must not write on the server.
 * @param {App} app
 * @param {string} script
 */
function withoutFiles({connection, toasts}, script) {
  const writers = (connection.hello?.commands ?? [])
    .filter(({name, words}) => name === 'trace' || words.some(({type}) => type === 'output'))
    .map(({name}) => name);
  const lines = script.split('\n');
  const kept = lines.filter(line => !writers.includes(line.trim().split(/\s/)[0]));
  if (kept.length < lines.length) {
    toasts.info(say`${lines.length - kept.length} commands of the session write files.
      They were left out.`);
  }
  return kept.join('\n');
}

/** @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text) ?? {};
  } catch {
    return {};
  }
}
