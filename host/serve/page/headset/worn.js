// A session of the headset: each of its frames shows the newest pair from the newest pose, and
// never waits for the machine.
import {inverse, multiply} from '../picture/camera.js';
import {WarpPainter} from '../picture/warp_painter.js';
import {say} from '../texts/say.js';
import {Hands} from './hands.js';
import {Pairs} from './pairs.js';
import {Placement} from './placement.js';
import {HeadTrack} from './prediction.js';
import {add, compose, inverted, length, minus, poseOf, rotated, times} from './rigid.js';
import {roomOf} from './room.js';
import {RoomPainter} from './room_painter.js';
import {lookAhead, sizeOf, windowsOf} from './windows.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../picture/metrics.js').HeadsetFigures} HeadsetFigures */
/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {import('./placement.js').Sphere} Sphere */

const NEAR_M = 0.05, FAR_M = 20;
const SHARPNESS = 1.2;               // Pixels of the window per pixel of the headset.
const SIZES = {least: 128, most: 1024, step: 64};
const MOVED_M = 0.0003;              // Less needs no new pair.
const FENCE_EVERY = 8;               // Frames; the time of drawing is measured for one of these.
const MIRROR_EVERY = 3;              // Frames of the headset per frame of the mirror.
const MIRROR_PX = 720;
const AHEAD_MM = 100;                // A point before the head moves when the head turns.
const EYES_ABOVE_FLOOR_M = 1.6;      // Where the headset does not know the floor.
const LONGEST_STEP_S = 0.1;          // After a pause, nothing jumps.
const KEPT = 256;

/** @param {number[]} list @param {number} value */
function keep(list, value) {
  list.push(value);
  if (list.length > KEPT) {
    list.shift();
  }
}

export class Worn {
  /**
   * @param {App} app
   * @param {HTMLCanvasElement} canvas      Of this session alone; shows the mirror.
   * @param {HeadsetFigures} figures
   */
  constructor(app, canvas, figures) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.canvas_ = canvas;
    /** @private */
    this.figures_ = figures;
    /** @private */
    this.painter_ = new WarpPainter(canvas, {xrCompatible: true});
    /** @private */
    this.room_ = new RoomPainter(this.painter_.gl);
    /** @private */
    this.placement_ = new Placement();
    /** @private */
    this.track_ = new HeadTrack();
    /** @private Why the machine draws no pairs; '' if it does. */
    this.refusal_ = '';
    /** @private */
    this.pairs_ = new Pairs(app.connection, this.painter_, text => { this.refusal_ = text; });
    /** @private */
    this.hands_ = new Hands(app, this.placement_, () => { this.isPlaced_ = false; });
    /** @private Whether the patient stands before the viewer. */
    this.isPlaced_ = false;
    /** @private Identity of the volume in the room. */
    this.identity_ = '';
    /** @private The newest request. @type {{points: Vector[], about: string} | null} */
    this.asked_ = null;
    /** @private Predictions whose time has not come. @type {{at: number, pose: Pose,
     *  without: Pose}[]} */
    this.predicted_ = [];
    /** @private Mean time from a pose to its pair. */
    this.trip_ms_ = 0;
    /** @private */
    this.before_ = 0;
    /** @private Signals the end of the timed drawing. @type {WebGLSync | null} */
    this.fence_ = null;
    this.pairs_.onTrip(ms => {
      this.trip_ms_ = this.trip_ms_ === 0 ? ms : this.trip_ms_ + (ms - this.trip_ms_) / 8;
      keep(figures.round_trip_ms, ms);
    });
  }

  /**
   * Shows the room in a headset until the session ends.
   * @param {XRSession} session
   */
  async start(session) {
    const {gl} = this.painter_;
    await gl.makeXRCompatible();
    const layer = new XRWebGLLayer(session, gl, {antialias: true});
    session.updateRenderState({baseLayer: layer, depthNear: NEAR_M, depthFar: FAR_M});
    const space = await session.requestReferenceSpace('local-floor').catch(async () => {
      const local = await session.requestReferenceSpace('local');
      return local.getOffsetReferenceSpace(new XRRigidTransform({y: -EYES_ABOVE_FLOOR_M}));
    });
    space.addEventListener('reset', () => { this.isPlaced_ = false; });
    this.hands_.attach(session);
    const draw = (/** @type {number} */ _, /** @type {XRFrame} */ frame) => {
      session.requestAnimationFrame(draw);
      this.draw_(frame, layer, space);
    };
    session.requestAnimationFrame(draw);
  }

  /** Frees everything. */
  end() {
    this.pairs_.end();
    this.painter_.gl.getExtension('WEBGL_lose_context')?.loseContext();
  }

  /**
   * @private
   * @param {XRFrame} frame
   * @param {XRWebGLLayer} layer
   * @param {XRReferenceSpace} space
   */
  draw_(frame, layer, space) {
    const now = performance.now(), {gl} = this.painter_, {state} = this.app_.store;
    const viewer = frame.getViewerPose(space);
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    this.painter_.clear(state?.background ?? '#000000');
    if (!viewer || !state || gl.isContextLost()) {
      return;  // The headset is not tracked.
    }
    const head = poseOf(viewer.transform);
    const sphere = state.volume || state.archive ? state.camera : null;
    this.place_(sphere, head, state.volume?.series_identity ?? state.archive ?? '');
    this.hands_.update(frame, space, Math.min(LONGEST_STEP_S, (now - this.before_) / 1000));
    this.before_ = now;
    const eyes = viewer.views.map(each => poseOf(each.transform));
    this.follow_(now, head);
    if (sphere) {
      const [view] = viewer.views, {width} = layer.getViewport(view);
      this.ask_(head, eyes, sphere, view.projectionMatrix[0] * width / 2);
    }
    this.drawViews_(viewer.views, view => layer.getViewport(view), head, sphere);
    this.measure_(now);
    if (layer.framebuffer && this.figures_.frames % MIRROR_EVERY === 0) {
      this.mirror_(viewer.views[0], layer.getViewport(viewer.views[0]), head, sphere);
      gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    }
  }

  /**
   * @private
   * @param {Sphere | null} sphere
   * @param {Pose} head
   * @param {string} identity
   */
  place_(sphere, head, identity) {
    if (identity !== this.identity_) {
      this.identity_ = identity;
      this.isPlaced_ = false;
      this.hands_.forget();
      this.pairs_.forget(this.app_.store.state?.revision ?? 0);
    }
    if (!this.isPlaced_ && sphere) {
      this.placement_.home(sphere, head);
      this.track_.forget();
      this.predicted_ = [];
      this.isPlaced_ = true;
    }
  }

  /**
   * Keeps the pose of the head, and compares it with what was predicted.
   * @private
   * @param {number} now
   * @param {Pose} head
   */
  follow_(now, head) {
    this.track_.add(now, this.placement_.toPatient(head));
    this.predicted_ = this.predicted_.filter(({at, pose, without}) => {
      const found = this.track_.at(at);
      if (found) {
        const scale = this.placement_.magnification;
        keep(this.figures_.prediction_error_mm,
          length(minus(pose.position, found.position)) * scale);
        keep(this.figures_.unpredicted_error_mm,
          length(minus(without.position, found.position)) * scale);
      }
      return !found && at >= now;
    });
  }

  /**
   * Asks for a pair if the eyes have moved.
   * @private
   * @param {Pose} head    In the room, as `eyes`.
   * @param {Pose[]} eyes
   * @param {Sphere} sphere
   * @param {number} focal_px
   */
  ask_(head, eyes, sphere, focal_px) {
    const ahead = this.pairs_.isFree ? this.track_.predict(this.trip_ms_ / 2) : null;
    if (!ahead) {
      return;
    }
    const {scale} = this.placement_;
    const seen = eyes.map(each => compose(inverted(head), each).position)
      .map(offset => add(ahead.pose.position, rotated(ahead.pose.turn, times(offset, 1 / scale))));
    const up = this.placement_.directionToPatient([0, 1, 0]);
    const windows = windowsOf(seen, ahead.pose, up, sphere);
    const size = sizeOf(windows, focal_px * SHARPNESS, SIZES);
    const about = JSON.stringify([sphere.center_mm, sphere.radius_mm, size]);
    const asked = this.pairs_.isKnown ? this.asked_ : null;
    const points = lookAhead(seen, sphere)
      ? [...seen, add(ahead.pose.position, rotated(ahead.pose.turn, [0, 0, -AHEAD_MM]))] : seen;
    const moved = asked?.points.length === points.length
      ? Math.max(...points.map((each, at) => length(minus(each, asked.points[at])))) * scale
      : Infinity;
    if (moved > MOVED_M || about !== asked?.about) {
      this.asked_ = {points, about};
      const seenAt = this.track_.newestAt, without = this.track_.predict(0)?.pose ?? ahead.pose;
      if (ahead.at > seenAt) {
        this.predicted_.push({at: ahead.at, pose: ahead.pose, without});
      }
      this.pairs_.ask(windows, size, seenAt);
    }
  }

  /**
   * @private
   * @param {readonly XRView[]} views
   * @param {(view: XRView) => {x: number, y: number, width: number, height: number}} viewportOf
   * @param {Pose} head
   * @param {Sphere | null} sphere
   */
  drawViews_(views, viewportOf, head, sphere) {
    const {gl} = this.painter_, {state} = this.app_.store;
    const {lines, labels} = roomOf({placement: this.placement_, sphere, head,
      background: state?.background ?? '#000000', hands: this.hands_.all, cut: this.hands_.cut,
      lengths: this.hands_.shownLengths, value: this.hands_.value, sentence: this.sentence_()});
    this.room_.take(lines);
    const right = rotated(head.turn, [1, 0, 0]), up = rotated(head.turn, [0, 1, 0]);
    for (const view of views) {
      const {x, y, width, height} = viewportOf(view);
      const clip = multiply([...view.projectionMatrix], [...view.transform.inverse.matrix]);
      gl.viewport(x, y, width, height);
      this.drawPatient_(view, {left: x, bottom: y, width, height}, clip);
      this.room_.draw(clip, head.position, labels, {right, up, position: head.position});
    }
  }

  /**
   * @private
   * @param {XRView} view
   * @param {import('../picture/warp_painter.js').Viewport} viewport
   * @param {number[]} clip  From the room.
   */
  drawPatient_(view, viewport, clip) {
    const pair = this.pairs_.shown, eye = view.eye === 'right' ? 1 : 0;
    if (pair) {
      const magnification = view.projectionMatrix[0] / pair.windows[eye].projection[0];
      const warp = multiply(multiply(clip, this.placement_.patientToWorld),
        inverse(pair.clips[eye]));
      pair.opacities.forEach((opacity, layer) =>
        this.painter_.draw(eye * pair.opacities.length + layer, warp, magnification, opacity,
          viewport));
    }
  }

  /**
   * The left eye's view on the page.
   * @private
   * @param {XRView} view
   * @param {{width: number, height: number}} viewport
   * @param {Pose} head
   * @param {Sphere | null} sphere
   */
  mirror_(view, viewport, head, sphere) {
    const {gl} = this.painter_, scale = Math.min(1, MIRROR_PX / viewport.width);
    const [width, height] = [viewport.width, viewport.height].map(px => Math.round(px * scale));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    this.painter_.begin(width, height, this.app_.store.state?.background ?? '#000000');
    this.drawViews_([view], () => ({x: 0, y: 0, width, height}), head, sphere);
  }

  /** The sentence in the room, or ''. @private */
  sentence_() {
    const {connection, store} = this.app_;
    if (!connection.connected) {
      return `${say`The connection to the server is lost.`}\n${say`The page tries again.`}`;
    }
    if (!store.state?.volume && !store.state?.archive) {
      return say`No volume is open.`;
    }
    if (this.refusal_ !== '') {
      return wrapped(this.refusal_);
    }
    return this.pairs_.shown ? '' : say`Waiting for the first picture …`;
  }

  /**
   * @private
   * @param {number} now  When the pose was taken.
   */
  measure_(now) {
    const figures = this.figures_, pair = this.pairs_.shown, {gl} = this.painter_;
    figures.frames += 1;
    figures.pairs = this.pairs_.count;
    figures.refusal = this.refusal_;
    if (pair) {
      figures.pose = pair.pose;
      figures.size = [pair.width, pair.height];
      keep(figures.pose_age_ms, now - pair.seenAt);
    }
    if (!this.fence_ && figures.frames % FENCE_EVERY === 0) {
      const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      this.fence_ = fence;
      gl.flush();
      const look = () => {
        if (!fence || gl.isContextLost()) {
          return;
        }
        if (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) {
          setTimeout(look, 1);
          return;
        }
        keep(figures.pose_to_pixels_ms, performance.now() - now);
        gl.deleteSync(fence);
        this.fence_ = null;
      };
      setTimeout(look, 1);
    }
  }
}

/** @param {string} text  Gets lines of some 40 letters. */
function wrapped(text) {
  return text.replace(/(.{30,45}?)\s+/g, '$1\n').trim();
}
