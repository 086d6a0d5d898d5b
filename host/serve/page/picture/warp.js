// Shows the newest picture from the newest viewpoint until the next picture arrives.
import {byId} from '../elements/dom.js';
import {cameraAt, inverse, isSameView, multiply} from './camera.js';
import {canUnpack, unpack} from './lean_depths.js';
import {Parallax} from './parallax.js';
import {WarpPainter} from './warp_painter.js';

/** @typedef {import('../link/types.js').FrameHeader} FrameHeader */
/** @typedef {import('../link/vocabulary.js').CameraState} CameraState */
/** @typedef {import('./camera.js').View} View */
/** @typedef {import('./lean_depths.js').LeanDepths} LeanDepths */

const KEPT = 256;  // Length of each list; older values are dropped.

/**
 * Figures for the tests and the machine panel. Times are those of performance.now().
 * @typedef {object} WarpFigures
 * @property {number} draws              Warped pictures since the page was opened.
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
 * user has turned, moved or zoomed further, or looks around. The picture's own canvas below always has the newest
 * picture itself.
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
    /** @private @type {WarpPainter | null} */
    this.painter_ = null;
    this.parallax = new Parallax(picture);
    this.parallax.onMoved = () => void this.draw_();
    /** @private What is on the screen: the arguments of WarpPainter.draw(). */
    this.drawn_ = {warp: /** @type {number[]} */ ([]), magnification: 1};
    /** Why nothing can be warped; empty if something can. */
    this.refusal = canUnpack() ? '' : 'the browser cannot decode depths (deflate-raw)';
    /** @private @type {(() => void)[]} */
    this.switched_ = [];
    /** @private */
    this.isOn_ = new URL(location.href).searchParams.get('warp') !== 'off';
    /** @private The picture that the painter has. */
    this.source_ = /** @type {{camera: CameraState, width: number, height: number,
      seenAt: number} | null} */ (null);
    /** @private Camera of the picture below. @type {CameraState | null} */
    this.shown_ = null;
    /** @private */
    this.requested_ = 0;
    /** @private Time of the newest input. */
    this.inputAt_ = 0;
    /** @private @type {{view: View, at: number}[]} */
    this.views_ = [];
    /** @type {WarpFigures} */
    this.figures = {draws: 0, warped: false, view: null, pointer_ms: [], picture_age_ms: []};

    connection.on('hello', () => this.ask_());
    connection.on('lost', () => this.forget());
    picture.onCleared(() => this.forget());
    viewpoint.onMoved(() => this.moved_());
    this.canvas_.addEventListener('webglcontextlost', event => {
      event.preventDefault();  // Else the browser does not give it back.
      this.painter_ = null;
      this.refuse_('the browser has taken WebGL back');
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
      this.refuse_(`depths cannot be read: ${error instanceof Error ? error.message : error}`);
      return null;
    }
  }

  /**
   * Takes the picture that is now on the canvas below.
   * @param {FrameHeader} header
   * @param {CameraState | null} camera
   * @param {ImageBitmap} bitmap
   * @param {LeanDepths[] | null} leans
   */
  take({width, height}, camera, bitmap, leans) {
    this.shown_ = camera;
    const asked = camera && this.views_.filter(({view}) => isSameView(view, camera)).at(-1);
    const seenAt = asked?.at ?? 0;
    this.source_ = null;
    if (leans && camera && this.painter_) {
      this.painter_.take(bitmap, leans);
      this.source_ = {camera, width, height, seenAt};
    }
    if (!this.draw_() && seenAt > 0) {
      const age = performance.now() - seenAt;
      keep(this.figures.pointer_ms, age);
      keep(this.figures.picture_age_ms, age);
      this.views_ = [];  // The screen shows the newest view: no input waits for a picture.
    }
  }

  /** Shows the picture below until a frame with depths arrives. */
  forget() {
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
        this.painter_ = new WarpPainter(this.canvas_);
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
      this.requested_ = requestAnimationFrame(() => {
        this.requested_ = 0;
        if (this.draw_()) {
          keep(this.figures.pointer_ms, performance.now() - this.inputAt_);
        }
      });
    }
  }

  /**
   * The place in the picture below that a place on the screen shows.
   * @param {{x: number, y: number}} place  Shares of width and height, from the upper left corner.
   * @returns {{x: number, y: number} | null} null if it shows no place of the picture
   */
  placeBelow(place) {
    const {source_: source, painter_: painter, drawn_: {warp, magnification}} = this;
    if (!this.figures.warped || !source || !painter) {
      return place;
    }
    const {width, height} = source;
    const at = {x: Math.floor(place.x * width), y: Math.floor(place.y * height)};
    const pixel = painter.pixelAt(at, source, 0, warp, magnification);
    return pixel && {x: (pixel.x + 0.5) / width, y: (pixel.y + 0.5) / height};
  }

  /**
   * Shows the warped picture if the newest view is not that of the picture below.
   * @private
   * @returns {boolean} whether the picture below lags behind the newest view, and is warped
   */
  draw_() {
    const {source_: source, painter_: painter, shown_: shown} = this;
    const {wanted} = this.viewpoint_, state = this.store_.state;
    const isAhead = Boolean(wanted && shown && !isSameView(wanted, shown));
    const base = isAhead ? wanted : shown, view = base && this.parallax.turned(base);
    const isWarped = Boolean(source && painter && state && view && shown
      && !isSameView(view, shown));
    this.figures.warped = isWarped;
    this.figures.view = isWarped ? view : shown;
    this.canvas_.style.visibility = isWarped ? 'visible' : 'hidden';
    if (!source || !painter || !state || !view || !isWarped) {
      this.picture_.lookFrom(null);
      return false;
    }
    const aspect = source.width / source.height;
    const from = cameraAt(source.camera, source.camera, aspect);
    const to = cameraAt(view, source.camera, aspect);
    this.drawn_ = {warp: multiply(to.patient_to_clip, inverse(from.patient_to_clip)),
      magnification: view.zoom / source.camera.zoom};
    painter.begin(source.width, source.height, state.background);
    painter.draw(0, this.drawn_.warp, this.drawn_.magnification);
    this.picture_.lookFrom(cameraAt(view, source.camera, state.size[0] / state.size[1]));
    this.figures.draws += 1;
    if (isAhead && source.seenAt > 0) {
      keep(this.figures.picture_age_ms, performance.now() - source.seenAt);
    }
    return isAhead;
  }
}
