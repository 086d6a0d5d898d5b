// Shows the newest picture from the newest viewpoint until the next picture arrives.
import {byId} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {opacitiesOf} from './bitmaps.js';
import {cameraAt, camerasAt, inverse, isSameView, multiply} from './camera.js';
import {sizeOf} from './compose.js';
import {canUnpack, unpack} from './lean_depths.js';
import {painterOf} from './painters.js';
import {Parallax} from './parallax.js';
import {partsOf} from './stereo.js';

/** @typedef {import('../link/types.js').FrameHeader} FrameHeader */
/** @typedef {import('../link/vocabulary.js').CameraState} CameraState */
/** @typedef {import('./compose.js').Bitmap} Bitmap */
/** @typedef {import('./camera.js').View} View */
/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */
/** @typedef {import('./painters.js').Painter} Painter */
/** @typedef {import('./stereo.js').Stereo} Stereo */

/**
 * A picture that the painter has: of one camera, or of both eyes.
 * @typedef {object} Source
 * @property {CameraState} camera
 * @property {Stereo} stereo       Off for the picture of one camera.
 * @property {number} width        Of one eye's picture, pixels.
 * @property {number} height
 * @property {number} revision
 * @property {number[]} opacities  Of the layers of each eye, the first behind.
 * @property {number} seenAt       Time of the input that asked for the viewpoint; 0: none did.
 * @property {boolean} isBelow     Whether the canvas below shows the picture.
 */

/**
 * How a picture is drawn: the arguments of Painter.draw().
 * @typedef {object} Pass
 * @property {number} picture
 * @property {number} eye
 * @property {number} opacity
 * @property {number[]} warp
 * @property {import('./warp_painter.js').Viewport} viewport
 * @property {import('./stereo.js').Part} part
 */

const KEPT = 256;  // Length of each list; older values are dropped.

/**
 * Figures for the tests and the machine panel. Times are those of performance.now().
 * @typedef {object} WarpFigures
 * @property {number} draws              Warped pictures since the page was opened.
 * @property {number} uploads            Pictures that the painter has got since then.
 * @property {boolean} ready             Whether the newest picture can be warped.
 * @property {boolean} warped            Whether a warped picture is on the screen.
 * @property {View | null} view          The view on the screen.
 * @property {number[]} pointer_ms       From an input to the picture of its viewpoint.
 * @property {number[]} picture_age_ms   Of each picture on the screen: time since the input that
 *                                       asked for the viewpoint that the machine drew.
 */

/** @param {any[]} list @param {any} value */
function keep(list, value) {
  list.push(value);
  if (list.length > KEPT) {
    list.shift();
  }
}

/**
 * A canvas over the picture's canvas. It is visible while the newest picture has depths and the
 * user has turned, moved or zoomed further, or looks around. The picture's own canvas below has the
 * newest picture itself, except for moving pairs, which this canvas shows in any case.
 */
export class Warp {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {import('../state/store.js').Store} store
   * @param {import('./picture.js').PictureView} picture
   * @param {import('./viewpoint.js').Viewpoint} viewpoint
   */
  constructor(connection, store, picture, viewpoint) {
    /** @private */
    this.connection_ = connection;
    /** @private */
    this.store_ = store;
    /** @private */
    this.picture_ = picture;
    /** @private */
    this.viewpoint_ = viewpoint;
    /** @private */
    this.canvas_ = /** @type {HTMLCanvasElement} */ (byId('warp'));
    /** @private @type {Painter | null} */
    this.painter_ = null;
    this.parallax = new Parallax(picture);
    this.parallax.onMoved = () => void this.draw_();
    /** @private The arguments of the last drawing. */
    this.drawn_ = {passes: /** @type {Pass[]} */ ([]), magnification: 1};
    /** The reason why nothing can be warped; '' if something can. */
    this.refusal = canUnpack() ? '' : say`the browser cannot decode depths (deflate-raw)`;
    /** @private @type {(() => void)[]} */
    this.switched_ = [];
    /** @private */
    this.isOn_ = new URL(location.href).searchParams.get('warp') !== 'off';
    /** @private @type {Source | null} */
    this.source_ = null;
    /** @private The picture of the source, if the painter does not need it yet.
     * @type {{bitmap: Bitmap, leans: LeanDepths[], isShared: boolean} | null} */
    this.pending_ = null;
    /** @private Camera of the picture below. @type {CameraState | null} */
    this.shown_ = null;
    /** @private */
    this.requested_ = 0;
    /** @private Time of the newest input. */
    this.inputAt_ = 0;
    /** @private @type {{view: View, at: number}[]} */
    this.views_ = [];
    /** @type {WarpFigures} */
    this.figures = {draws: 0, uploads: 0, ready: false, warped: false, view: null, pointer_ms: [],
      picture_age_ms: []};

    connection.on('hello', () => this.ask_());
    connection.on('lost', () => this.forget());
    picture.onCleared(() => this.forget());
    viewpoint.onMoved(() => this.moved_());
    this.canvas_.addEventListener('webglcontextlost', event => {
      event.preventDefault();  // Else the browser does not give it back.
      this.painter_ = null;
      this.refuse_(say`the browser has taken WebGL back. It may return it; if not, load the page
        again`);
    });
    this.canvas_.addEventListener('webglcontextrestored', () => {
      this.refusal = '';
      this.ask_();
    });
    for (const name of ['pointermove', 'wheel', 'keydown']) {
      addEventListener(name, event => { this.inputAt_ = event.timeStamp; },
        {capture: true, passive: true});
    }
  }

  get isOn() {
    return this.isOn_ && this.refusal === '';
  }

  set isOn(on) {
    this.isOn_ = on;
    this.ask_();
    if (!this.isOn) {
      this.parallax.stop();
      this.forget();
    }
  }

  /**
   * Decodes the depths of a frame's pictures; null if there are none.
   * @param {import('../link/connection.js').Frame} frame
   * @returns {Promise<LeanDepths[] | null>}
   */
  async unpack({header, depths}) {
    if (!this.painter_ || !this.isOn || depths.length === 0) {
      return null;
    }
    try {
      return await Promise.all(depths.map(each => unpack(each, header.width, header.height)));
    } catch (error) {  // The picture itself is shown all the same.
      this.refuse_(say`depths cannot be read: ${/** @type {Error} */ (error).message}`);
      return null;
    }
  }

  /**
   * Takes the newest picture, or layers of the state in the picture that is on the canvas below.
   * The caller may use the bitmap until release().
   * @param {FrameHeader} header
   * @param {CameraState | null} camera
   * @param {Stereo} stereo
   * @param {Bitmap} bitmap
   * @param {LeanDepths[] | null} leans
   * @returns {boolean} whether the canvas below must show the picture: moving pairs are composed
   *     here, which is faster
   */
  take({width, height, revision, views, rests, layers, opacity}, camera, stereo, bitmap, leans) {
    this.shown_ = camera;
    const size = sizeOf(bitmap);
    if (this.painter_ && Math.max(size.width, size.height) > this.painter_.most_px) {
      leans = null;  // The canvas below has no such limit.
    }
    const asked = camera && this.views_.filter(({view}) => isSameView(view, camera)).at(-1);
    const seenAt = asked?.at ?? 0;
    const isBelow = views === 1 || rests || !leans || !camera || !this.painter_;
    const before = this.source_;
    this.source_ = null;
    if (leans && camera && this.painter_) {
      this.drop_();
      this.pending_ = {bitmap, leans, isShared: true};
      const opacities = opacitiesOf({layers, opacity});
      this.source_ = {camera, stereo: views === 1 ? {...stereo, mode: 'off'} : stereo, width,
        height, revision, opacities, seenAt, isBelow};
    } else if (rests && before?.revision === revision) {
      this.source_ = {...before, seenAt, isBelow};  // The moving picture had depths: it had layers.
    } else {
      this.drop_();
    }
    if (this.picture_.header?.rests) {
      this.upload_();  // The first move of a turn finds it there.
    }
    if (!this.draw_() && seenAt > 0) {
      const age = performance.now() - seenAt;
      keep(this.figures.pointer_ms, age);
      keep(this.figures.picture_age_ms, age);
      this.views_ = [];  // The screen shows the newest view: no input waits for a picture.
    }
    return isBelow;
  }

  /** Ends the use of the bitmap by the caller of take(). @param {Bitmap} bitmap */
  release(bitmap) {
    if (this.pending_?.bitmap === bitmap) {
      this.pending_.isShared = false;
    } else {
      bitmap.close();
    }
  }

  /** Gives the painter the picture of the source. @private @returns {boolean} if it has it */
  upload_() {
    const {pending_: pending, painter_: painter} = this;
    try {
      if (pending && painter) {
        painter.take(pending.bitmap, pending.leans);
        this.figures.uploads += 1;
      }
      return true;
    } catch (error) {  // The canvas below shows the picture.
      this.source_ = null;
      this.refusal = say`the picture cannot be warped: ${String(error)}`;
      return false;
    } finally {
      this.drop_();
    }
  }

  /** @private */
  drop_() {
    if (this.pending_ && !this.pending_.isShared) {
      this.pending_.bitmap.close();
    }
    this.pending_ = null;
  }

  /** Shows the picture below until a frame with depths arrives. */
  forget() {
    this.drop_();
    this.source_ = null;
    this.shown_ = null;
    this.views_ = [];
    this.draw_();
  }

  /** @param {() => void} listener  Called when `isOn` or `refusal` may have changed. */
  onSwitched(listener) {
    this.switched_.push(listener);
  }

  /** @private @param {string} reason */
  refuse_(reason) {
    this.refusal = reason;
    this.ask_();
    this.forget();
  }

  /** Asks the server for depths, or for none. @private */
  ask_() {
    const {watches} = this.connection_;
    if (this.isOn && !watches && !this.painter_) {
      try {
        this.painter_ = painterOf(this.canvas_);
      } catch (error) {
        this.refusal = error instanceof Error ? error.message : String(error);
      }
    }
    this.connection_.wantDepths(this.isOn && !watches);
    this.switched_.forEach(listener => listener());
  }

  /** Draws at the next screen refresh. @private */
  moved_() {
    const view = this.viewpoint_.wanted;
    if (view) {
      keep(this.views_, {view, at: this.inputAt_});
    }
    if (this.requested_ === 0) {
      this.requested_ = requestAnimationFrame(() => void this.draw_());
    }
  }

  /**
   * The place in the picture below that a place on the screen shows.
   * @param {{x: number, y: number}} place  Shares of width and height, from the upper left corner.
   * @returns {{x: number, y: number} | null} null if it shows no place of the picture
   */
  placeBelow(place) {
    const {source_: source, painter_: painter, drawn_: {passes, magnification}} = this;
    const state = this.store_.state;
    if (!this.figures.warped || !source || !painter || !state) {
      return place;
    }
    const areRows = source.stereo.mode === 'rows';
    const found = passes.find(({part: {left, width}, eye, viewport: {height}}) =>
      place.x < left + width && (!areRows || (Math.floor(place.y * height) & 1) === eye));
    if (!found) {
      return null;
    }
    const {eye, viewport, part: {left, width}} = found;
    const at = {x: Math.floor((place.x - left) / width * viewport.width),
      y: Math.floor(place.y * viewport.height)};
    let pixel = null;
    for (const pass of passes) {  // The layer behind first, since a click means what is opaque.
      pixel ??= pass.eye !== eye ? null
        : painter.pixelAt(at, viewport, pass.picture, pass.warp, magnification);
    }
    if (!pixel) {
      return null;
    }
    const x = left + (pixel.x + 0.5) / source.width * width, y = (pixel.y + 0.5) / source.height;
    const row = Math.floor(y * state.size[1]);
    // The nearest row that shows what the same eye sees.
    return {x, y: areRows && (row & 1) !== eye ? ((row ^ 1) + 0.5) / state.size[1] : y};
  }

  /**
   * Shows the warped picture if the newest view is not that of the picture below.
   * @private
   * @returns {boolean} whether the picture below lags behind the newest view, and is warped
   */
  draw_() {
    const isAsked = this.requested_ !== 0;
    cancelAnimationFrame(this.requested_);  // This drawing shows the newest view.
    this.requested_ = 0;
    const {source_: source, painter_: painter, shown_: shown} = this;
    const {wanted} = this.viewpoint_, state = this.store_.state;
    const isAhead = Boolean(wanted && shown && !isSameView(wanted, shown));
    const base = isAhead ? wanted : shown, view = base && this.parallax.turned(base);
    const isAway = Boolean(source && painter && state && view && shown && !isSameView(view, shown));
    const isDrawn = (isAway || Boolean(source && !source.isBelow)) && this.upload_();
    const isWarped = isAway && isDrawn;
    this.figures.ready = this.source_ !== null;
    this.figures.warped = isWarped;
    this.figures.view = isWarped ? view : shown;
    this.canvas_.style.visibility = isDrawn ? 'visible' : 'hidden';
    if (source && painter && state && view && isDrawn) {
      this.paint_(source, painter, view, state);
    }
    if (!isWarped || !state || !source || !view) {
      this.picture_.lookFrom(null);
      return false;
    }
    this.picture_.lookFrom(cameraAt(view, source.camera, state.size[0] / state.size[1]));
    this.figures.draws += 1;
    if (isAhead && source.seenAt > 0) {
      keep(this.figures.picture_age_ms, performance.now() - source.seenAt);
    }
    if (isAhead && isAsked) {
      keep(this.figures.pointer_ms, performance.now() - this.inputAt_);
    }
    return isAhead;
  }

  /**
   * @private
   * @param {Source} source
   * @param {Painter} painter
   * @param {View} view
   * @param {import('../link/vocabulary.js').State} state
   */
  paint_({camera, stereo, width, height, opacities}, painter, view, {size, background}) {
    const {mode} = stereo, aspect = width / height, parts = partsOf(mode);
    const from = camerasAt(camera, camera, aspect, stereo);
    const to = camerasAt(view, camera, aspect, stereo);
    // Each row belongs to one of the monitor's, whatever size the picture has.
    const [across, down] = mode === 'rows' ? size : [width, height];
    const magnification = view.zoom / camera.zoom;
    const passes = parts.flatMap((part, place) => part.eyes.flatMap(eye => {
      const warp = multiply(to[eye].patient_to_clip, inverse(from[eye].patient_to_clip));
      const viewport = {left: across * (mode === 'anaglyph' ? eye : place), width: across,
        height: down, rows: mode === 'rows' ? eye : undefined};
      return opacities.map((opacity, layer) =>
        ({picture: eye * opacities.length + layer, eye, opacity, part, warp, viewport}));
    }));
    this.drawn_ = {passes, magnification};
    if (mode === 'anaglyph') {
      painter.beginAnaglyph(across, down, background);
    } else {
      painter.begin(across * parts.length, down, background);
    }
    for (const {picture, opacity, warp, viewport} of passes) {
      painter.draw(picture, warp, magnification, opacity, viewport);
    }
    painter.end();
  }
}
