// The contract for panels and controls, as types.
//
// A panel is a module with `create(root, app)`. It fills `root`, a <section>, and keeps the section
// up to date. The panels on the right are the rows of TABS in shell/tabs.js. The section receives
// the events `panelshow` and `panelhide`. panels.css has the styles of the panels.
// A view sends a patient position to the other views as the event `place` on `document`, with
// {p_mm, from} as `detail`. The histogram sends its counts as the event `counts`, with {identity,
// counts}: of the volume, and {first, width, counts}. The event `pauseseries` ends the play of a
// time series, because something needs one volume.
// Each control has a data-testid for the tests. The page's policy (CSP) forbids styles and scripts
// in markup.

/** @typedef {import('../picture/eyes.js').Eye} Eye */
/** @typedef {import('../picture/grabs.js').Grab} Grab */

/**
 * The parts that every panel and control receives.
 * @typedef {object} App
 * @property {import('../link/connection.js').Connection} connection
 * @property {import('../state/store.js').Store} store
 * @property {import('../picture/picture.js').PictureView} picture
 * @property {import('../state/modes.js').Modes} modes
 * @property {import('../elements/toasts.js').Toasts} toasts
 * @property {import('../state/selection.js').Selection} selection
 * @property {import('../state/page_session.js').PageSession} session
 * @property {import('./measures.js').Measures} measures
 * @property {import('../picture/grabs.js').Grabs} grabs
 * @property {import('../state/layout.js').Layout} layout
 * @property {import('./one_history.js').OneHistory} history
 * @property {import('./views.js').Views} views
 * @property {Set<() => boolean>} lagging  Whether a part still shows another volume of the time
 *     series than the state's. The event `sliceshown` on `document` says that this may have
 *     changed.
 */

export {};
