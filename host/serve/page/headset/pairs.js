// The pairs of pictures: asks for the newest poses only, and keeps the newest pair.
import {bitmapOfFile, opacitiesOf} from '../picture/bitmaps.js';
import {unpack} from '../picture/lean_depths.js';
import {multiply} from '../picture/camera.js';
import {say} from '../texts/say.js';

/** @typedef {import('../link/connection.js').Frame} Frame */
/** @typedef {import('./windows.js').EyeWindow} EyeWindow */

const SILENT_MS = 1000;     // After a reply without its pair, the next poses go out.
const REFUSED_MS = 2000;    // The same after a refusal.
const PATIENCE_MS = 10000;  // The same without any reply.

/**
 * A pose that the machine was asked for.
 * @typedef {object} Asked
 * @property {number} pose          Counts from 1.
 * @property {EyeWindow[]} windows  Of the left eye and of the right eye.
 * @property {number} seenAt        When the head was there, performance.now().
 * @property {number} sentAt
 */

/**
 * The pair on the screen.
 * @typedef {object} Pair
 * @property {number} pose
 * @property {number} revision
 * @property {number} seenAt
 * @property {number} width        Of one picture, pixels.
 * @property {number} height
 * @property {number[]} opacities  Of the pictures of each eye, the first behind.
 * @property {number[][]} clips    Of each eye: patient to the clip coordinates of the picture.
 * @property {EyeWindow[]} windows
 */

let newestPose = 0;  // The same number is never sent twice, not even by a later session.

export class Pairs {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {import('../picture/warp_painter.js').WarpPainter} painter  Gets each pair.
   * @param {(text: string) => void} tell  Reports a refusal; '' when it is over.
   */
  constructor(connection, painter, tell) {
    /** @private */
    this.connection_ = connection;
    /** @private */
    this.painter_ = painter;
    /** @private */
    this.tell_ = tell;
    /** @type {Pair | null} */
    this.shown = null;
    /** Pairs that were taken. */
    this.count = 0;
    /** Whether the server knows the newest poses; false after a loss or a refusal. */
    this.isKnown = false;
    /** @private @type {Map<number, Asked>} The pose under way and those that may still be drawn. */
    this.asked_ = new Map();
    /** @private The pose under way; 0 if the next may go out. */
    this.underWay_ = 0;
    /** @private From this time the next pose may go out, although one is under way. */
    this.freeAt_ = 0;
    /** @private Nothing is sent before this time. */
    this.waitsUntil_ = 0;
    /** @private @type {Frame | null} */
    this.next_ = null;
    /** @private */
    this.isDecoding_ = false;
    /** @private Pairs before this revision show another volume. */
    this.leastRevision_ = 0;
    /** @private @type {((trip_ms: number) => void)[]} */
    this.tripActs_ = [];
    /** @private */
    this.ends_ = [connection.on('frame', frame => this.take_(frame)),
      connection.on('lost', () => this.lost_())];
  }

  /** @param {(trip_ms: number) => void} act  Called with the time from each pose to its pair. */
  onTrip(act) {
    this.tripActs_.push(act);
  }

  /** Whether the next poses may go out. */
  get isFree() {
    const now = performance.now();
    return this.connection_.connected && this.connection_.hello !== null
      && now >= this.waitsUntil_ && (this.underWay_ === 0 || now >= this.freeAt_);
  }

  /**
   * Asks for a pair.
   * @param {EyeWindow[]} windows
   * @param {[number, number]} size  Pixels of one picture.
   * @param {number} seenAt          See Asked.
   */
  ask(windows, size, seenAt) {
    const pose = ++newestPose;
    this.asked_.set(pose, {pose, windows, seenAt, sentAt: performance.now()});
    this.underWay_ = pose;
    this.isKnown = true;
    this.freeAt_ = performance.now() + PATIENCE_MS;
    void this.connection_.eyes({pose, size, left: windows[0], right: windows[1]}).then(reply => {
      if (this.underWay_ !== pose) {
        return;
      }
      if (reply.superseded) {
        this.underWay_ = 0;
      } else if (!reply.ok) {
        this.underWay_ = 0;
        this.isKnown = false;
        this.waitsUntil_ = performance.now() + REFUSED_MS;
        this.tell_(reply.error ?? '');
      } else {
        this.tell_('');
        // A newer frame may take the place of the pair.
        this.freeAt_ = performance.now() + SILENT_MS;
      }
    });
  }

  /**
   * Forgets the pair, because another volume is open.
   * @param {number} revision  Of the first state with this volume: pairs before it are dropped.
   */
  forget(revision) {
    this.shown = null;
    this.isKnown = false;
    this.leastRevision_ = revision;
  }

  /** Ends it: the server draws no further pair. */
  end() {
    this.ends_.forEach(each => each());
    this.next_?.shown();
    this.next_ = null;
    this.asked_.clear();
    void this.connection_.eyes(null);
  }

  /** @private */
  lost_() {
    this.next_ = null;
    this.underWay_ = 0;
    this.isKnown = false;
    this.waitsUntil_ = 0;
    this.leastRevision_ = 0;  // A restarted server begins again at 1.
  }

  /**
   * @private
   * @param {Frame} frame
   */
  take_(frame) {
    if (frame.header.pose === 0) {
      return;
    }
    if (this.underWay_ !== 0 && frame.header.pose >= this.underWay_) {
      const asked = this.asked_.get(this.underWay_);
      this.underWay_ = 0;
      if (asked) {
        this.tripActs_.forEach(act => act(performance.now() - asked.sentAt));
      }
    }
    this.next_?.shown();
    this.next_ = frame;
    if (!this.isDecoding_) {
      void this.decode_();
    }
  }

  /** Decodes the newest frame, and those that arrive meanwhile. @private */
  async decode_() {
    this.isDecoding_ = true;
    while (this.next_) {
      const frame = this.next_;
      this.next_ = null;
      try {
        await this.show_(frame);
      } catch (error) {
        this.tell_(say`A pair of pictures could not be shown: ${
          error instanceof Error ? error.message : String(error)}`);
      } finally {
        frame.shown();
      }
    }
    this.isDecoding_ = false;
  }

  /**
   * @private
   * @param {Frame} frame
   */
  async show_(frame) {
    const {header, depths} = frame, {pose, revision, width, height, views, layers} = header;
    if (views !== 2) {
      throw new Error(say`pair ${pose}: ${views} views, but a headset needs 2. Load the page again;
        it may be older than the server.`);
    }
    if (depths.length !== views * layers) {
      throw new Error(say`pair ${pose}: the message has depths of ${depths.length} pictures, but
        ${views} views of ${layers} layers need ${views * layers}. The server reports why.`);
    }
    const decoding = bitmapOfFile(frame);
    const unpacking = Promise.all(depths.map(each => unpack(each, width, height)));
    unpacking.catch(() => {});  // It is awaited below, also if it fails first.
    const bitmap = await decoding;
    try {
      const leans = await unpacking, asked = this.asked_.get(pose);
      // Nothing goes back in time: poses before that of the pair on the screen are forgotten.
      if (asked && revision >= this.leastRevision_) {
        this.painter_.take(bitmap, leans);
        this.keep_(asked, header);
      }
    } finally {
      bitmap.close();
    }
  }

  /**
   * @private
   * @param {Asked} asked
   * @param {import('../link/types.js').FrameHeader} header
   */
  keep_({pose, windows, seenAt}, {revision, width, height, layers, opacity}) {
    this.shown = {pose, revision, seenAt, width, height, windows,
      opacities: opacitiesOf({layers, opacity}),
      clips: windows.map(each => multiply(each.projection, each.patient_to_eye))};
    this.count += 1;
    for (const older of this.asked_.keys()) {
      if (older < pose) {
        this.asked_.delete(older);
      }
    }
  }
}
