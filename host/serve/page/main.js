// The page's start: makes the parts and joins them.
//
// The contract for panels (types: types.js):
//   A panel is a module with `create(root, app)`; it fills `root`, a <section>, and keeps it right.
//   Panels on the right are rows of TABS in tabs.js; events `panelshow` and `panelhide` on the
//   section tell that it can be seen. Styles of theirs: panels.css.
//   app.connection  do(line) -> Reply, never rejected; failures show themselves as toasts
//                   set(line) -> Reply: newest only per subject, for drags
//                   ask({ask, ...}) -> {json, bytes}, rejected with a sentence
//                   on(event, act), wantMachine(bool), watches (this page may only watch)
//   app.store       state (null at first); subscribe(keys, act): now and when one has changed
//   app.picture     overlay (SVG, in places), project(p_mm), pixelAt(event), placeOfPixel(x, y),
//                   onChange(act): redraw what lies over the picture; onShown(act): a frame
//   app.modes       enter({name, hint, click(x, y), leave}): a click on the picture is yours
//   app.selection   name, choose(name), watch(act): the surface that the left side is about
//   app.toasts      info(text), error(text)
//   Between panels: events on `document` with a `detail`:
//     place   {p_mm, from}: the place that all views point at (a crosshair)
//   Elements: dom.js. Tests find things by data-testid. No styles or scripts in markup (CSP).
import {Connection} from './connection.js';
import {createBadge} from './badge.js';
import {createBar} from './bar.js';
import {byId} from './dom.js';
import {watchPointers} from './gestures.js';
import {createHelp} from './help.js';
import {watchKeys} from './keyboard.js';
import {createLeft} from './left.js';
import {measure} from './metrics.js';
import {Modes} from './modes.js';
import {createOpenDialog} from './open_volume.js';
import {createOverlay} from './overlay.js';
import {PictureView} from './picture.js';
import {createPointing} from './pointing.js';
import {createSaveDialog} from './saving.js';
import {Selection} from './selection.js';
import {Store} from './store.js';
import {createTabs} from './tabs.js';
import {OPENING, Toasts} from './toasts.js';
import {Viewpoint} from './viewpoint.js';
import {createHints, createVeil, createWork} from './work.js';

/** The WebSocket's address: beside the page, with the token that the page was opened with. */
function socketUrl() {
  const url = new URL('socket', location.href);
  url.search = location.search;
  url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  return url;
}

function start() {
  const connection = new Connection(socketUrl());
  const store = new Store();
  const toasts = new Toasts(byId('toasts'));
  const picture = new PictureView(connection, store, text => toasts.error(text));
  /** @type {import('./types.js').App} */
  const app = {connection, store, picture, modes: new Modes(), toasts,
    selection: new Selection()};
  window.pxpl5 = measure(connection, store, picture);

  connection.on('state', state => store.take(state));
  connection.on('failed', ({line, error}) =>
    app.toasts.error(error, /^(load|play) /.test(line) ? OPENING : ''));
  store.subscribe(['volume', 'archive'], () => app.toasts.forget(OPENING));
  connection.on('note', ({level, text}) => app.toasts[level === 'error' ? 'error' : 'info'](text));
  connection.on('hello', ({role}) => document.body.classList.toggle('watcher', role === 'watcher'));

  const viewpoint = new Viewpoint(connection, store, picture);
  const step = (/** @type {'undo' | 'redo'} */ way) => {
    // A key when there is nothing to take back is no error.
    if (store.state?.[way] && !connection.watches) {
      void connection.do(way);
    }
  };
  const actions = {
    undo: () => step('undo'), redo: () => step('redo'),
    open: createOpenDialog(app), save: createSaveDialog(app), help: createHelp(),
  };
  createBar(app, actions);
  createLeft(app);
  createOverlay(app, viewpoint);
  createBadge(app);
  createWork(app);
  createVeil(app);
  createHints(app);
  createTabs(app);
  watchPointers(picture, viewpoint, createPointing(app));
  watchKeys(app, viewpoint, actions);
  connection.open();
}

start();
