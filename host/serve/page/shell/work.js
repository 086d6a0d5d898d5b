// The progress of long work, the notice of a lost connection, and hints.
import {byId, ENGLISH, h} from '../elements/dom.js';
import {ofPort} from '../link/ports.js';
import {address, hasToken} from '../link/token.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/types.js').Hello} Hello */
/** @typedef {import('../link/types.js').Progress} Progress */

const SHOW_AFTER_MS = 300;      // Shorter work is not shown.
/** Long work that the server does not cancel, by the name in `progress`. */
const UNCANCELABLE = ['scale', 'computers', 'starting the machine again'];
const HINTS_SEEN = 'pxpl5-hints-seen';
const VEIL_AFTER_MS = 400;
const STALL_MS = 2500;          // A silence of this length is shown.
const LOOK_MS = 500;
const PING_MS = 2000;           // So that a silence is found while nothing is asked, too.
const FORBIDDEN = 403;
const RECONNECTING = say`Reconnecting. The session is kept as long as pxpl5 serve runs.`;
const OF_CLASS = say`Reconnecting. If your session has ended, the page of the class says why and
  begins a new one.`;
const NEW_ADDRESS = say`The server was started again and has a new address. Open the address that
  pxpl5 serve printed in its terminal. The former session has ended.`;
const NO_TOKEN = say`This tab was opened without the token of the session. Open the address that
  pxpl5 serve printed in its terminal.`;

/** @param {App} app */
export function createWork(app) {
  const root = byId('work');
  const what = h('p', {...ENGLISH, 'data-testid': 'work-what'});
  const bar = h('progress', {'aria-label': say`Progress`});
  const cancel = h('button', {'data-testid': 'cancel',
    onclick: () => app.connection.cancel()}, say`Cancel`);
  root.append(what, bar, cancel);
  let timer = 0;
  app.connection.on('progress', (/** @type {Progress | null} */ progress) => {
    if (!progress) {
      clearTimeout(timer);
      timer = 0;
      root.hidden = true;
      return;
    }
    cancel.hidden = UNCANCELABLE.includes(progress.what);
    const percent = Math.round(progress.done / progress.total * 100);
    what.textContent = progress.what + (progress.total > 0 ? ` ${percent} %` : '');
    if (progress.total > 0) {
      bar.max = progress.total;
      bar.value = progress.done;
    } else {
      bar.removeAttribute('value');
    }
    if (timer === 0) {
      timer = window.setTimeout(() => { root.hidden = false; }, SHOW_AFTER_MS);
    }
  });
  app.connection.on('lost', () => {
    clearTimeout(timer);
    timer = 0;
    root.hidden = true;
  });
}

/**
 * Shows that the server has stopped answering. Long work is no stall: it has its own notice.
 * @param {App} app
 */
export function createStall(app) {
  const root = byId('stalled');
  setInterval(() => app.connection.ping(), PING_MS);
  setInterval(() => {
    const {silent_ms} = app.connection;
    const isStalled = silent_ms >= STALL_MS && !app.store.state?.busy;
    root.hidden = !isStalled;
    if (isStalled) {
      root.textContent = say`No answer from the server for ${Math.round(silent_ms / 1000)} s.
        The picture may be old.`;
    }
  }, LOOK_MS);
}

/**
 * Shows that something outside of the program will end it, for example the time limit of a job.
 * @param {App} app
 */
export function createEnding(app) {
  const root = byId('ending');
  app.store.subscribe(['end'], ({end}) => {
    root.hidden = !end;
    if (end) {
      const ends = end.at
        ? say`This session ends at ${new Date(end.at).toLocaleTimeString()}: ${end.why}.`
        : say`This session ends soon: ${end.why}.`;
      root.textContent = `${ends} ${end.open
        ? say`It is saved. This command opens it again: ${end.open}` : ''}`;
    }
  });
}

/**
 * Whether the server refuses this page: another server with another token has its port.
 * @returns {Promise<boolean>}
 */
async function isRefused() {
  try {
    return (await fetch(address('icon.svg'), {cache: 'no-store'})).status === FORBIDDEN;
  } catch {
    return false;  // No server answers.
  }
}

/** @param {App} app */
export function createVeil(app) {
  let timer = 0;
  let classPort = 0;
  app.connection.on('lost', async (/** @type {string} */ why) => {
    byId('lost-why').textContent = why;
    byId('lost-next').textContent ||= RECONNECTING;
    if (timer === 0) {
      timer = window.setTimeout(() => { byId('lost').hidden = false; }, VEIL_AFTER_MS);
    }
    byId('lost-next').textContent = classPort ? OF_CLASS
      : !hasToken() ? NO_TOKEN : await isRefused() ? NEW_ADDRESS : RECONNECTING;
  });
  app.connection.on('hello', (/** @type {Hello} */ {class_port}) => {
    classPort = class_port;
    const link = /** @type {HTMLAnchorElement} */ (byId('class'));
    link.hidden = classPort === 0;
    link.href = ofPort(classPort, location.href);
    clearTimeout(timer);
    timer = 0;
    byId('lost').hidden = true;
  });
}

/**
 * The hint over the picture: the instruction of a mode, or a hint for a first visit. The first
 * input removes the hint for good.
 * @param {App} app
 */
export function createHints(app) {
  const root = byId('hint');
  const isTouch = matchMedia('(pointer: coarse)').matches;
  let isFirst = false;
  try {
    isFirst = localStorage.getItem(HINTS_SEEN) === null;
  } catch {
    // Without storage the hint appears at each visit.
    isFirst = true;
  }
  const done = () => {
    if (isFirst) {
      isFirst = false;
      root.hidden = app.modes.current === null;
      try {
        localStorage.setItem(HINTS_SEEN, 'yes');
      } catch {
        // Without storage the hint appears at each visit.
      }
    }
  };
  app.modes.watch(mode => {
    app.picture.stage.classList.toggle('mode', mode !== null);
    root.hidden = mode === null && !isFirst;
    root.replaceChildren(...(mode ? [mode.hint, leaveButton(app)]
      : firstHint(isTouch, app.connection.watches)));
  });
  // Any use of the page shows that the hint was read: it asks for a drag in the histogram, too.
  document.addEventListener('pointerup', event => {
    // A link that vanishes under the pointer is not clicked.
    if (!(event.target instanceof Element && event.target.closest('#hint a'))) {
      done();
    }
  });
  addEventListener('hashchange', done);
  app.picture.stage.addEventListener('wheel', done);
  document.addEventListener('keydown', done);
  app.connection.on('hello', hello => {
    if (hello.role === 'watcher' && isFirst) {
      root.replaceChildren(...firstHint(isTouch, true));
    }
  });
}

/** @param {App} app */
function leaveButton(app) {
  return h('button', {class: 'quiet', 'data-testid': 'leave-mode', title: say`Leave the mode (Esc)`,
    onclick: () => app.modes.leave()}, say`Done`);
}

/**
 * @param {boolean} isTouch
 * @param {boolean} watches
 */
function firstHint(isTouch, watches) {
  const tour = h('span', {class: 'more'}, ` ${say`New here?`} `,
    h('a', {href: '#tour=1', 'data-testid': 'hint-tour'}, say`Take the tour`));
  if (watches) {
    return [say`This page is view-only: it shows what another page does. Slices, machine and
      volume work here.`, tour];
  }
  return isTouch ? [say`One finger rotates the view. Two fingers move and zoom.`, tour]
    : [say`Drag to rotate, scroll to zoom, right-drag to move.`, h('span', {class: 'more'},
      ` ${say`Drag a handle in the histogram to change a surface. Press ? for help.`}`), tour];
}
