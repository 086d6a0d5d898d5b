// The picture: frames on a canvas, and the layer over the frames.
import {byId, update} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {bitmapOf, paintFrame} from './bitmaps.js';
import {cameraAt} from './camera.js';
import {Cameras} from './cameras.js';
import {eyesOf} from './eyes.js';
import {inShapeOf, placed} from './layout.js';
import {marked} from './marked.js';
import {Refresh} from './refresh.js';
import {composedSize, partsOf} from './stereo.js';

/** @typedef {import('../link/connection.js').Frame} Frame */
/** @typedef {import('../link/types.js').FrameHeader} FrameHeader */
/** @typedef {import('../link/vocabulary.js').CameraState} CameraState */
/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('../link/types.js').LegendLine} LegendLine */
/**
 * A frame, and its picture if it is a video frame.
 * @typedef {{frame: Frame, video: Promise<VideoFrame | null> | null}} Waiting
 */

/**
 * Shows the newest frame only. One frame is being decoded and the newest frame waits. Other frames
 * are dropped and acknowledged, because the server counts the frames in flight. Video frames are
 * decoded when they arrive, each of them, and acknowledged after that.
 *
 * Coordinates: *pixels* are pixels of the picture, as in commands (`size`). *Places* are CSS pixels
 * from the upper left corner of the picture, the units of `overlay`. A picture of both eyes side by
 * side is twice as wide as `state.size`.
 */
export class PictureView {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {import('../state/store.js').Store} store
   * @param {(text: string) => void} tell  Reports an error to the user.
   */
  constructor(connection, store, tell) {
    /** @private */
    this.tell_ = tell;
    /** @private */ this.store_ = store;
    /** Around the picture; receives pointer events. */
    this.stage = byId('stage');
    /** @private */ this.canvas_ = /** @type {HTMLCanvasElement} */ (byId('frame'));
    /** @private */
    this.context_ = /** @type {CanvasRenderingContext2D} */ (
      this.canvas_.getContext('2d', {alpha: false}));
    /** Above the picture: append groups here, in places. */
    this.overlay = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (byId('overlay')));
    /** Size of the picture in places. */
    this.width = 0;
    this.height = 0;
    /** Whether the panel hides edges of the picture, which must not be scaled. */
    this.isCut = false;
    /**
     * Camera of the displayed frame, null before the first; in stereo, between the eyes. While the
     * frame is shown from a newer viewpoint, the camera is that of the viewpoint.
     * @type {CameraState | null}
     */
    this.camera = null;
    /** @private Camera that the displayed frame was drawn with. @type {CameraState | null} */
    this.drawn_ = null;
    /** Shows frames from newer viewpoints, if set. @type {import('./warp.js').Warp | null} */
    this.warp = null;
    /** Decodes video frames, if set. @type {import('./video.js').Video | null} */
    this.video = null;
    /** @type {FrameHeader | null} */
    this.header = null;
    /** @private */ this.cameras_ = new Cameras();
    /** @private @type {Waiting | null} */ this.next_ = null;
    /** @private */ this.decoding_ = false;
    this.refresh = new Refresh();
    /** @private The size that is laid out, if not the state's. @type {number[] | null} */
    this.asIf_ = null;
    /** @private @type {((header: FrameHeader, at: number) => void)[]} */
    this.shownActs_ = [];
    /** @private @type {(() => void)[]} */ this.clearedActs_ = [];
    /** @private @type {(() => void)[]} */ this.changeActs_ = [];
    /** @private Frames before this revision show another volume. */
    this.leastRevision_ = 0;

    connection.on('frame', frame => this.take_(frame));
    // A lost connection drops its frames.
    connection.on('lost', () => {
      this.drop_(this.next_);
      this.next_ = null;
      this.cameras_.forget();
      this.leastRevision_ = 0;  // A restarted server begins again at 1.
    });
    store.subscribe(['camera', 'size', 'volume', 'stereo', 'stereo_separation_mm',
      'stereo_convergence_mm'], state => {
      this.cameras_.add(state);
      this.layOut_();
      this.changed_();
    });
    // Frames of another volume must never stand under the new volume's name.
    /** @type {string | null} The series, the volume or the archive. */
    let shown = null;
    store.subscribe(['volume', 'archive'], ({volume, archive, revision}) => {
      const now = volume?.series_identity ?? archive ?? '';
      if (now !== shown) {
        shown = now;
        this.clear_(revision);
      }
    });
    new ResizeObserver(() => {
      this.layOut_();
      this.changed_();
    }).observe(this.stage);
  }

  /**
   * Calls `act` after each displayed frame.
   * @param {(header: FrameHeader, at: number) => void} act  `at`: performance.now().
   */
  onShown(act) {
    this.shownActs_.push(act);
  }

  /**
   * Calls `act` when the picture is cleared, because another volume or none is open.
   * @param {() => void} act
   */
  onCleared(act) {
    this.clearedActs_.push(act);
  }

  /**
   * Calls `act` when results of `project` may have changed: camera, size, layout.
   * @param {() => void} act
   */
  onChange(act) {
    this.changeActs_.push(act);
  }

  /**
   * The size of the whole picture if one eye's picture has this size.
   * @param {number[]} eye
   */
  wholeSize(eye) {
    return composedSize(eye, this.store_.state?.stereo ?? 'off');
  }

  /** Width and height in pixels. @private */
  pixels_() {
    return this.wholeSize(this.asIf_ ?? this.store_.state?.size ?? [1, 1]);
  }

  /**
   * The place in the picture that is on the screen under a pointer, as shares of the width and
   * height, which stay right if the size changes. While the picture is shown from another
   * viewpoint, this is the place that the pixel on the screen comes from.
   * @param {{clientX: number, clientY: number}} event
   * @returns {{x: number, y: number} | null} null outside, and where nothing of the picture is seen
   */
  placeAt({clientX, clientY}) {
    const box = this.canvas_.getBoundingClientRect();
    const place = {x: (clientX - box.left) / box.width, y: (clientY - box.top) / box.height};
    const isInside = place.x >= 0 && place.y >= 0 && place.x < 1 && place.y < 1;
    return isInside && this.warp ? this.warp.placeBelow(place) : isInside ? place : null;
  }

  /**
   * The pixel at a place.
   * @param {{x: number, y: number}} place
   */
  pixelOf({x, y}) {
    const [width, height] = this.pixels_();
    return {x: Math.floor(x * width), y: Math.floor(y * height)};
  }

  /**
   * The circle in the part of the picture under a pointer that the part's shorter side bounds, in
   * client coordinates.
   * @param {{clientX: number}} event
   */
  circleAt({clientX}) {
    const box = this.canvas_.getBoundingClientRect();
    const parts = partsOf(this.store_.state?.stereo ?? 'off');
    const share = (clientX - box.left) / box.width;
    const {left, width} = parts.find(each => share < each.left + each.width) ?? parts[0];
    return {x: box.left + (left + width / 2) * box.width, y: box.top + box.height / 2,
      radius: Math.min(width * box.width, box.height) / 2 || 1};
  }

  /**
   * The place of a pixel's center; null while the screen shows another picture.
   * @param {number} x
   * @param {number} y
   */
  placeOfPixel(x, y) {
    if (this.warp?.figures.warped || this.asIf_) {
      return null;
    }
    const [width, height] = this.pixels_();
    return {x: (x + 0.5) / width * this.width, y: (y + 0.5) / height * this.height};
  }

  /**
   * The color of a pixel of the displayed frame, as "#rrggbb".
   * @param {{x: number, y: number}} pixel
   */
  colorAt({x, y}) {
    const [width, height] = this.pixels_();
    const {width: columns, height: rows} = this.canvas_;
    const [r, g, b] = this.context_.getImageData(Math.floor(x / width * columns),
      Math.floor(y / height * rows), 1, 1).data;
    return '#' + [r, g, b].map(part => part.toString(16).padStart(2, '0')).join('');
  }

  /**
   * The eyes for which marks on patient positions are drawn, from left to right.
   * @returns {import('./eyes.js').Eye[]}
   */
  eyes() {
    const state = this.store_.state;
    return this.camera && state
      ? eyesOf(this.camera, this.asIf_ ?? state.size, state, this.width, this.height) : [];
  }

  /**
   * Lays out what is over the picture as for a picture of another size, of the view of the state,
   * while `act` runs. The screen does not change.
   * @param {number[]} eye  Size of one eye's picture.
   * @param {() => void} act
   */
  layOutAs(eye, act) {
    const {state} = this.store_, before = this.camera;
    const show = (/** @type {number[] | null} */ asIf,
      /** @type {CameraState | null} */ camera) => {
      this.asIf_ = asIf;
      this.layOut_();
      this.camera = camera;
      this.changed_();
    };
    inShapeOf(this.wholeSize(eye), this.stage, this.pixels_(), () => {
      show(eye, state && cameraAt(state.camera, state.camera, eye[0] / eye[1]));
      act();
    }, () => show(null, before));
  }

  /**
   * The picture of a file with the marks that are on the screen, see marked().
   * @param {Blob} file
   * @param {import('./marked.js').Wish} wish
   */
  marked(file, wish) {
    return marked(file, wish, this, this.canvas_, this.pixels_());
  }

  /**
   * @private
   * @param {Frame} frame
   */
  take_(frame) {
    if (frame.header.pose > 0) {
      return;  // A headset shows it.
    }
    this.drop_(this.next_);
    const video = frame.header.kind === 'vp8' ? this.video?.decode(frame) ?? null : null;
    this.next_ = {frame, video};
    if (!this.decoding_) {
      void this.show_();
    }
  }

  /**
   * @private
   * @param {Waiting | null} waiting
   */
  drop_(waiting) {
    if (waiting?.video) {
      void waiting.video.then(picture => picture?.close()).finally(() => waiting.frame.shown());
    } else {
      waiting?.frame.shown();
    }
  }

  /** @private */
  async show_() {
    this.decoding_ = true;
    while (this.next_) {
      const {frame, video} = this.next_;
      this.next_ = null;
      try {
        await this.decode_(frame, video);
      } catch (error) {
        // The next frame may be intact, so the loop continues.
        const why = error instanceof Error ? error.message : String(error);
        this.tell_(say`A picture could not be shown: ${why}`);
      } finally {
        frame.shown();
      }
    }
    this.decoding_ = false;
  }

  /**
   * @private
   * @param {Frame} frame
   * @param {Waiting['video']} video
   */
  async decode_(frame, video) {
    const {header} = frame;
    const [bitmap, leans] = await Promise.all([bitmapOf(frame, video),
      this.warp?.unpack(frame) ?? null]);
    if (!bitmap) {
      return;
    }
    try {
      await this.refresh.room();
      await (leans && this.refresh.next());  // A warped picture is drawn at refreshes.
      if (header.revision >= this.leastRevision_) {
        this.draw_(header, bitmap, leans);
      }
    } finally {
      void (this.warp ? this.warp.release(bitmap) : bitmap.close());
    }
  }

  /**
   * @private
   * @param {FrameHeader} header
   * @param {import('./compose.js').Bitmap} bitmap
   * @param {import('./lean_depths.js').LeanDepths[] | null} leans
   */
  draw_(header, bitmap, leans) {
    const {camera, stereo} = this.cameras_.of(header.revision, this.store_.state);
    // Layers of the picture at rest are for warped pictures only.
    if (!header.rests && this.header?.rests && header.revision === this.header.revision) {
      this.warp?.take(header, camera, stereo, bitmap, leans);
      return;
    }
    this.header = header;
    this.drawn_ = camera;
    if (this.warp?.take(header, camera, stereo, bitmap, leans) ?? true) {
      paintFrame(this.context_, header, stereo.mode, bitmap);
    }
    const at = performance.now();
    for (const act of this.shownActs_) {
      act(header, at);
    }
    if (!this.warp?.figures.warped) {
      this.lookFrom(null);
    }
  }

  /**
   * Says which camera the screen shows.
   * @param {CameraState | null} camera  Null: the camera that the frame was drawn with.
   */
  lookFrom(camera) {
    const now = camera ?? this.drawn_;
    if (now !== this.camera) {
      this.camera = now;
      this.changed_();
    }
  }

  /**
   * Clears the picture until a frame of the open volume arrives.
   * @private
   * @param {number} revision  Revision of the first state with this volume.
   */
  clear_(revision) {
    this.leastRevision_ = revision;
    this.context_.clearRect(0, 0, this.canvas_.width, this.canvas_.height);
    this.header = null;
    this.drawn_ = null;
    this.camera = null;
    for (const act of this.clearedActs_) {
      act();
    }
    this.changed_();
  }

  /**
   * Fits the picture into its panel, whole. Alternate rows are shown pixel by pixel in any case.
   * @private
   */
  layOut_() {
    const areRows = this.store_.state?.stereo === 'rows';
    const {width, height, left, top, isCut} = placed(this.stage.getBoundingClientRect(),
      this.pixels_(), areRows);
    [this.width, this.height, this.isCut] = [width, height, isCut];
    for (const {style} of [this.canvas_, byId('warp'), this.overlay]) {
      Object.assign(style, {width: `${width}px`, height: `${height}px`, left, top});
    }
    this.stage.classList.toggle('rows', areRows);
    update(this.overlay, {viewBox: `0 0 ${width || 1} ${height || 1}`});
  }

  /** @private */
  changed_() {
    for (const act of this.changeActs_) {
      act();
    }
  }
}
