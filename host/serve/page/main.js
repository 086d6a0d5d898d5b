// Starts the page: makes its parts and connects them.
import {byId, ENGLISH} from './elements/dom.js';
import {OPENING, Toasts} from './elements/toasts.js';
import {Headset} from './headset/headset.js';
import {Connection} from './link/connection.js';
import {address} from './link/token.js';
import {watchPointers} from './picture/gestures.js';
import {Grabs} from './picture/grabs.js';
import {measure} from './picture/metrics.js';
import {PictureView} from './picture/picture.js';
import {Video} from './picture/video.js';
import {Viewpoint} from './picture/viewpoint.js';
import {Warp} from './picture/warp.js';
import {createBadge} from './shell/badge.js';
import {createBar} from './shell/bar.js';
import {createCine} from './shell/cine.js';
import {createEdges} from './shell/edges.js';
import {createHelp} from './shell/help.js';
import {watchKeys} from './shell/keyboard.js';
import {createOverlay} from './shell/overlay.js';
import {createPointing} from './shell/pointing.js';
import {createPrint} from './shell/print.js';
import {createTabs, showTab} from './shell/tabs.js';
import {toggleFullScreen} from './shell/view_tools.js';
import {createEnding, createHints, createStall, createVeil, createWork} from './shell/work.js';
import {Measures} from './panel/measures.js';
import {OneHistory} from './panel/one_history.js';
import {Views} from './panel/views.js';
import {Layout} from './state/layout.js';
import {Modes} from './state/modes.js';
import {PageSession} from './state/page_session.js';
import {Selection} from './state/selection.js';
import {Store} from './state/store.js';
import {createLeft} from './surfaces/left.js';
import {translatePage} from './texts/say.js';
import {createTour} from './tour/tour.js';
import {createOpenDialog} from './volume/open_volume.js';
import {createSaveDialog} from './volume/saving.js';

/** The WebSocket's URL, relative to the page, with the token of the page. */
function socketUrl() {
  const url = address('socket');
  url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  return url;
}

function start() {
  translatePage();
  const connection = new Connection(socketUrl());
  const store = new Store();
  const toasts = new Toasts(byId('toasts'));
  const picture = new PictureView(connection, store, text => toasts.error(text));
  const viewpoint = new Viewpoint(connection, store, picture);
  picture.warp = new Warp(connection, store, picture, viewpoint);
  picture.video = new Video(connection, text => toasts.info(text));
  const measures = new Measures();
  /** @type {import('./panel/app.js').App} */
  const app = {connection, store, picture, modes: new Modes(), toasts,
    selection: new Selection(), session: new PageSession(), measures, grabs: new Grabs(),
    history: new OneHistory(connection, store, measures), layout: new Layout(),
    views: new Views(), lagging: new Set()};
  app.session.add('layout', {save: () => app.layout.now,
    restore: saved => app.layout.restore(saved)});
  window.pxpl5 = measure(connection, store, picture);

  connection.on('state', state => store.take(state));
  const isOpening = (/** @type {string} */ line) => /^(load|play) /.test(line);
  connection.on('failed', ({line, error, isOwn}) =>
    app.toasts.error(error, isOpening(line) ? OPENING : '', isOwn ? {} : ENGLISH));
  // Only a success takes the error away: a session that fails half-way changes the volume, too.
  connection.on('reply', ({line, reply}) => {
    if (reply.ok && isOpening(line)) {
      app.toasts.forget(OPENING);
    }
  });
  connection.on('note', ({level, text}) => level === 'error'
    ? app.toasts.error(text, '', ENGLISH) : app.toasts.info(text, [], ENGLISH));
  connection.on('hello', ({role}) => document.body.classList.toggle('watcher', role === 'watcher'));

  const headset = new Headset(app, window.pxpl5.headset);
  const tour = createTour(app, showTab);
  const actions = {
    undo: () => app.history.go('undo'), redo: () => app.history.go('redo'),
    open: createOpenDialog(app), save: createSaveDialog(app),
    help: createHelp(app, headset.help, tour.open), fullScreen: toggleFullScreen, tour: tour.open,
    leave: tour.close,
  };
  createBar(app, actions, headset.button);
  createLeft(app);
  createOverlay(app, viewpoint);
  createBadge(app);
  createCine(app);
  createWork(app);
  createVeil(app);
  createStall(app);
  createEnding(app);
  createHints(app);
  createTabs(app);
  createEdges(app);
  createPrint(app);
  watchPointers(picture, viewpoint, createPointing(app, () => viewpoint.reset()),
    app.grabs);
  watchKeys(app, viewpoint, actions);
  connection.open();
}

start();
