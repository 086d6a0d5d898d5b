// The view that the page requests. During a gesture it is ahead of the state.
import {anglesOf, rotationOf, turn, drag} from './arcball.js';
import {isSameView} from './camera.js';
import {plain} from '../link/lines.js';
import {mmPerPlace} from './projection.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('./camera.js').View} View */

const LEAST_ZOOM = 0.05;
const MOST_ZOOM = 100;
const ZOOM_DIGITS = 4;

/**
 * The view with the digits that a command has.
 * @param {View} view
 * @returns {View}
 */
function rounded({azimuth_deg, elevation_deg, roll_deg, zoom, pan_mm}) {
  const short = (/** @type {number} */ value) => Number(plain(value));
  return {azimuth_deg: short(azimuth_deg), elevation_deg: short(elevation_deg),
    roll_deg: short(roll_deg), zoom: Number(plain(zoom, ZOOM_DIGITS)),
    pan_mm: [short(pan_mm[0]), short(pan_mm[1])]};
}

/** Rotates, moves and zooms with `view`, newest only. Does nothing on a view-only page. */
export class Viewpoint {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {import('../state/store.js').Store} store
   * @param {import('./picture.js').PictureView} picture
   */
  constructor(connection, store, picture) {
    /** @private */
    this.connection_ = connection;
    /** @private */
    this.store_ = store;
    /** @private */
    this.picture_ = picture;
    /** @private Settings without a reply. */
    this.underWay_ = 0;
    /** @private */
    this.requested_ = 0;
    /** @private The revision of the last reply. The state arrives later. */
    this.answered_ = 0;
    /** @private */
    this.rotation_ = rotationOf({azimuth_deg: 0, elevation_deg: 0, roll_deg: 0});
    /** @private */
    this.zoom_ = 1;
    /** @private @type {[number, number]} */
    this.pan_mm_ = [0, 0];
    /** @private @type {(() => void)[]} */
    this.movedActs_ = [];
    /**
     * The view of the newest gesture, rounded as the server gets it. Null before the first gesture,
     * and after anything else has changed the view.
     * @type {View | null}
     */
    this.wanted = null;
    /** @private */
    this.follow_ = () => {
      if (store.state && this.underWay_ === 0 && this.requested_ === 0
          && store.state.revision >= this.answered_) {
        const {camera} = store.state;
        this.rotation_ = rotationOf(camera);
        this.zoom_ = camera.zoom;
        this.pan_mm_ = [camera.pan_mm[0], camera.pan_mm[1]];
        if (this.wanted && !isSameView(this.wanted, camera)) {
          this.want_(null);
        }
      }
    };
    store.subscribe(['camera', 'revision'], this.follow_);
    connection.on('lost', () => {
      this.answered_ = 0;  // A restarted server begins again at 1.
      this.want_(null);
    });
  }

  /** @param {() => void} act  Called when `wanted` has changed. */
  onMoved(act) {
    this.movedActs_.push(act);
  }

  /** Starts a gesture, which is one undo step. */
  begin() {
    this.connection_.mark();
  }

  /**
   * @param {Triple} from  On the ball.
   * @param {Triple} to
   */
  drag(from, to) {
    this.rotation_ = drag(this.rotation_, from, to);
    this.send_();
  }

  /**
   * @param {Triple} axis   Unit vector in the eye's axes.
   * @param {number} angle  Radians.
   */
  turn(axis, angle) {
    this.rotation_ = turn(this.rotation_, axis, angle);
    this.send_();
  }

  /**
   * Moves the scene.
   * @param {number} right  Places.
   * @param {number} down
   */
  pan(right, down) {
    const mm = this.mmPerPlace();
    this.pan_mm_ = [this.pan_mm_[0] + right * mm, this.pan_mm_[1] - down * mm];
    this.send_();
  }

  /** @param {number} factor */
  zoom(factor) {
    this.zoom_ = Math.max(LEAST_ZOOM, Math.min(MOST_ZOOM, this.zoom_ * factor));
    this.send_();
  }

  /** Restores the initial view. */
  reset() {
    this.named('anterior');
  }

  /**
   * Shows all visible surfaces whole. Resets roll, and drops a pending rotation, which would arrive
   * later.
   * @param {string} name  A named view of the command `view`.
   */
  named(name) {
    if (this.connection_.watches) {
      return;
    }
    cancelAnimationFrame(this.requested_);
    this.requested_ = 0;
    this.want_(null);
    this.connection_.mark();
    void this.connection_.do(`view ${name} fit=yes`);
  }

  /** Millimeters per place, at the center of the volume. */
  mmPerPlace() {
    const {camera, height} = this.picture_;
    const volume = this.store_.state?.volume;
    if (!camera || !volume || height === 0) {
      return 0;
    }
    return mmPerPlace(camera.patient_to_eye, camera.patient_to_clip, height, volume.center_mm);
  }

  /**
   * @private
   * @param {View | null} view
   */
  want_(view) {
    this.wanted = view;
    for (const act of this.movedActs_) {
      act();
    }
  }

  /** Sends at most once per screen refresh. @private */
  send_() {
    if (this.connection_.watches) {
      return;
    }
    this.want_(rounded({...anglesOf(this.rotation_), zoom: this.zoom_, pan_mm: this.pan_mm_}));
    if (this.requested_ === 0) {
      this.requested_ = requestAnimationFrame(() => {
        this.requested_ = 0;
        if (this.wanted) {
          this.set_(this.wanted);
        }
      });
    }
  }

  /**
   * Each line contains the whole view, so that it can replace a waiting line (`subjectOf`).
   * @private
   * @param {View} view  Rounded.
   */
  set_({azimuth_deg, elevation_deg, roll_deg, zoom, pan_mm}) {
    this.underWay_ += 1;
    const options = {zoom: plain(zoom, ZOOM_DIGITS), roll: plain(roll_deg),
      pan: pan_mm.map(each => plain(each)).join(',')};
    const command = {name: 'view', words: [plain(azimuth_deg), plain(elevation_deg)], options};
    void this.connection_.set(command).then(({revision = 0}) => {
      this.underWay_ -= 1;
      this.answered_ = Math.max(this.answered_, revision);
      this.follow_();
    });
  }
}
