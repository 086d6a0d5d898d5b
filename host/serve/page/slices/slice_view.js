// One slice on a canvas; pointer and keys.
import {contextOf, fitted, onceAFrame, watchSize} from '../elements/canvas.js';
import {h, update} from '../elements/dom.js';
import {isRegion} from '../panel/measures.js';
import {editNote} from '../panel/note_editor.js';
import {say} from '../texts/say.js';
import {paintMarks} from './mark_paint.js';
import {isOn, nearestEnd, pointsMoved} from './slice_ends.js';
import {SliceInput} from './slice_input.js';
import {paintSlice} from './slice_paint.js';
import {boxAt, depthOf, isInside, pixelAt, placedIn, sliceAtBox, valuesIn, voxelAt}
  from './slice_pixels.js';
import {USUAL} from './slice_settings.js';
import {placeText, sliceWord} from './slice_words.js';
import {WHOLE, limitedTimes, movedTo, revealed, zoomedAt} from './slice_zoom.js';
import {paintValues} from './windows.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_ends.js').End} End */
/** @typedef {import('./slice_input.js').Events} Events */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/** @typedef {import('./slice_settings.js').Look} Look */
/** @typedef {import('./slice_zoom.js').Zoom} Zoom */
/** @typedef {import('./windows.js').Window} Window */

/** @typedef {import('./slice_input.js').Under} Under */

const HALF = 0.5;   // Of a pixel.

export class SliceView {
  /**
   * @param {string} plane    'Axial', ...
   * @param {Events} events
   */
  constructor(plane, events) {
    /** @private */ this.plane_ = plane;
    /** @private @type {Slice | null} */ this.slice_ = null;
    /** @private @type {Vector} */ this.size_ = [1, 1, 1];
    /** @private @type {Vector | null} */ this.crosshair_ = null;
    /** @private Its pixel of the slice. */ this.crosshairPixel_ = '';
    /** @private @type {Zoom} */ this.zoom_ = WHOLE;
    /** @private */ this.look_ = USUAL;
    /** @private @type {(slice: Slice) => import('./slice_cuts.js').Cut[]} */
    this.cuts_ = () => [];
    /** @private @type {import('./slice_measure.js').Mark[]} */ this.marks_ = [];
    /** Boxes of the labels by name. @type {ReturnType<typeof paintMarks>} */
    this.labels = new Map();
    /** @private */ this.image_ = h('canvas');
    this.canvas = h('canvas', {
      class: 'slice-canvas', tabindex: 0, role: 'application',
      'aria-label': sliceWord(plane),
      'data-testid': `slice-${plane.toLowerCase()}`,
    });
    this.draw = onceAFrame(() => this.draw_());
    /** Whether the slice is of another volume than the open one. */ this.isOld = false;
    /** @private */ this.input_ = new SliceInput(this, events);
    watchSize(this.canvas, this.draw);
  }

  /** The volume has changed: until the next slice is shown, this one is of another volume. */
  outdate() {
    this.isOld = this.slice_ !== null;
  }

  /**
   * Shows a slice.
   * @param {Slice} slice
   * @param {Vector} size     Size of the volume, voxels.
   * @param {Window} through
   */
  show(slice, size, through) {
    this.slice_ = slice;
    this.isOld = false;
    this.size_ = size;
    this.repaint(through);
    const place = slice.oblique ? sliceWord(this.plane_)
      : placeText(this.plane_, slice.index + 1, size[slice.axes[2]]);
    update(this.canvas, {'aria-label': say`${place}: arrow keys move the crosshair, Page Up and
      Down step slices, plus and minus zoom, 0 shows the whole slice`});
  }

  /**
   * @param {Look} look
   * @param {Window} through
   */
  setLook(look, through) {
    this.look_ = look;
    this.repaint(through);
  }

  /** @param {(slice: Slice) => import('./slice_cuts.js').Cut[]} cuts  Where planes cut it. */
  setCuts(cuts) {
    this.cuts_ = cuts;
    this.draw();
  }

  /** @param {import('./slice_input.js').Tool} tool */
  setTool(tool) {
    this.input_.tool = tool;
    this.canvas.classList.toggle('picks', tool === 'tissue');
    this.canvas.classList.toggle('moves', tool === 'move');
  }

  /** Clears the view. */
  clear() {
    this.slice_ = null;
    this.isOld = false;
    this.crosshair_ = null;
    this.zoom_ = WHOLE;
    this.canvas.setAttribute('aria-label', sliceWord(this.plane_));
    this.draw();
  }

  /** @param {Window} through */
  repaint(through) {
    const slice = this.slice_;
    if (slice) {
      this.image_.width = slice.width;
      this.image_.height = slice.height;
      const pixels = new ImageData(slice.width, slice.height);
      paintValues(slice.values, through, pixels.data, this.look_.map);
      contextOf(this.image_).putImageData(pixels, 0, 0);
      this.draw();
    }
  }

  /** @param {Vector | null} voxel  A zoomed view moves to show this voxel. */
  setCrosshair(voxel) {
    this.crosshair_ = voxel;
    const pixel = voxel && this.slice_ ? pixelAt(this.slice_, this.size_, voxel).join() : '';
    // The user may have moved the slice away from it.
    const isElsewhere = pixel !== this.crosshairPixel_;
    this.crosshairPixel_ = pixel;
    if (voxel && this.slice_ && isElsewhere && !this.input_.drags) {
      const {shown, shareOf} = this.placed_(this.slice_);
      const place = shareOf(this.voxelPlace_(this.slice_, voxel));
      const [across, down] = this.zoom_.center;
      this.zoom_ = movedTo(this.zoom_,
        [revealed(across, shown[0], place[0]), revealed(down, shown[1], place[1])]);
    }
    this.draw();
  }

  /**
   * What is shown at a voxel of the slice; null for voxels of other slices.
   * @param {Vector} voxel
   * @returns {Under | null}
   */
  valueAt(voxel) {
    const slice = this.slice_;
    if (!slice || Math.abs(depthOf(slice, voxel)) > HALF) {
      return null;
    }
    const [x, y] = pixelAt(slice, this.size_, voxel);
    const at = Math.round(y) * slice.width + Math.round(x);
    return at in slice.values ? {voxel, value: slice.values[at], own: slice.own[at]} : null;
  }

  /** The slab that is shown, if any. */
  get slab() {
    return this.slice_?.slab ?? null;
  }

  /** Tells again what is under the pointer. Returns whether it is over a voxel. */
  hover() {
    return Boolean(this.input_.hover());
  }

  /** @param {import('./slice_measure.js').Mark[]} marks */
  setMarks(marks) {
    this.marks_ = marks;
    this.draw();
  }

  /**
   * The end of a measurement that a pointer grabs, if any.
   * @param {[number, number]} place  CSS pixels of the view.
   * @param {number} reach            Likewise.
   * @returns {End | null}
   */
  endAt(place, reach) {
    const slice = this.slice_;
    return slice && nearestEnd(slice, this.marks_, voxel => this.voxelPlace_(slice, voxel), place,
      reach);
  }

  /**
   * Whether the shown slice is the nearest one to a voxel.
   * @param {Vector} voxel
   */
  shows(voxel) {
    const slice = this.slice_;
    return slice !== null && isOn(slice, {voxels: [voxel]});
  }

  /**
   * Whether a place is in the rectangle of the shown slice.
   * @param {Vector} voxel
   */
  isInside(voxel) {
    const slice = this.slice_;
    return slice !== null && isInside(slice, pixelAt(slice, this.size_, voxel));
  }

  /**
   * The points of a measurement on this slice after an end has moved.
   * @param {Vector[]} voxels
   * @param {number} end
   * @param {Vector} to
   */
  pointsMoved(voxels, end, to) {
    return this.slice_ ? pointsMoved(this.slice_, voxels, end, to) : voxels;
  }

  /** Which slice is shown; null if none is, or an oblique one. */
  get shown() {
    const slice = this.slice_, slab = slice?.slab;
    return slice && slice.axis !== 'oblique' ? {axis: slice.axis, index: slice.index,
      ...slab && {slab_mm: slab.thickness_mm, slab_kind: slab.kind}} : null;
  }

  /**
   * The values of the shown slice in a region between two corners, and its area.
   * @param {import('../panel/measures.js').Kind} kind  Ellipse or rectangle.
   * @param {Vector} a
   * @param {Vector} b
   */
  valuesIn(kind, a, b) {
    const slice = this.slice_;
    return slice && isRegion(kind)
      ? valuesIn(slice, kind, pixelAt(slice, this.size_, a), pixelAt(slice, this.size_, b))
      : {values: [], area_mm2: 0};
  }

  /**
   * Zooms around a place of the view, or around the crosshair.
   * @param {number} times                    1: the whole slice.
   * @param {[number, number] | null} [at]    CSS pixels.
   */
  zoomTo(times, at) {
    const slice = this.slice_;
    if (!slice) {
      this.zoom_ = {...WHOLE, times};
      return;
    }
    const {shareOf} = this.placed_(slice);
    const place = at ?? (this.crosshair_ && this.voxelPlace_(slice, this.crosshair_));
    this.zoom_ = zoomedAt(this.zoom_, limitedTimes(times),
      place ? shareOf(place) : this.zoom_.center);
    this.draw();
  }

  /**
   * A voxel beside the crosshair; null without a crosshair.
   * @param {number} across   Pixels of the slice.
   * @param {number} down
   * @returns {Vector | null}
   */
  besideCrosshair(across, down) {
    return this.crosshair_ && this.beside(this.crosshair_, across, down);
  }

  /**
   * A place of the shown slice beside a voxel; null without a slice.
   * @param {Vector} voxel
   * @param {number} across   Pixels of the slice.
   * @param {number} down
   * @returns {Vector | null}
   */
  beside(voxel, across, down) {
    const slice = this.slice_;
    if (!slice) {
      return null;
    }
    const [x, y] = pixelAt(slice, this.size_, voxel);
    return voxelAt(slice, this.size_, x + across, y + down);
  }

  /**
   * Where the view shows a slice: CSS pixels, the share of the slice that the view shows, across
   * and down, and what turns a place of the view into a center of a zoom.
   * @private
   * @param {Slice} slice
   */
  placed_(slice) {
    const width = this.canvas.clientWidth || 1, height = this.canvas.clientHeight || 1;
    const place = placedIn(slice, width, height, this.zoom_);
    return {
      place, shown: [width / place.width, height / place.height],
      shareOf: (/** @type {[number, number]} */ [x, y]) => /** @type {[number, number]} */ (
        [(x - place.left) / place.width, (y - place.top) / place.height]),
    };
  }

  /**
   * Where the view shows a voxel, CSS pixels.
   * @param {Vector} voxel
   * @returns {[number, number]}
   */
  placeOf(voxel) {
    return this.slice_ ? this.voxelPlace_(this.slice_, voxel) : [0, 0];
  }

  /**
   * @private
   * @param {Slice} slice
   * @param {Vector} voxel
   */
  voxelPlace_(slice, voxel) {
    return boxAt(slice, this.placed_(slice).place, ...pixelAt(slice, this.size_, voxel));
  }

  /**
   * Moves a zoomed slice.
   * @param {number} across   CSS pixels.
   * @param {number} down
   */
  moveBy(across, down) {
    if (this.slice_) {
      const {place} = this.placed_(this.slice_), [x, y] = this.zoom_.center;
      this.zoom_ = movedTo(this.zoom_, [x - across / place.width, y - down / place.height]);
      this.draw();
    }
  }

  /**
   * Asks for the text of a note, see editNote().
   * @param {[number, number]} place  CSS pixels of the view.
   * @param {string} text
   * @param {(text: string | null) => void} done
   */
  edit([x, y], text, done) {
    const {offsetLeft, offsetTop} = this.canvas;
    editNote(this.canvas, [offsetLeft + x, offsetTop + y], text, done);
  }

  /** @private */
  draw_() {
    const where = fitted(this.canvas), {all} = this;
    if (all && where.width > 0) {
      this.labels = paintSlice(all, where, true);
    }
  }

  /** @returns {import('./slice_paint.js').Shown | null}  Null without a slice. */
  get all() {
    return this.slice_ && {isOld: this.isOld, canvas: this.canvas, plane: this.plane_,
      slice: this.slice_, size: this.size_, zoom: this.zoom_, image: this.image_, look: this.look_,
      crosshair: this.crosshair_, marks: this.marks_, cuts: this.cuts_(this.slice_)};
  }

  /**
   * The voxel under the pointer, and its value; null outside of the slice.
   * @param {MouseEvent} event
   * @returns {Under | null}
   */
  under(event) {
    const slice = this.slice_;
    if (!slice) {
      return null;
    }
    const {place} = this.placed_(slice);
    const [x, y] = sliceAtBox(slice, place, ...this.inView(event));
    const column = Math.round(x), row = Math.round(y);
    if (column < 0 || row < 0 || column >= slice.width || row >= slice.height) {
      return null;
    }
    const at = row * slice.width + column;
    // An oblique slice has no values beyond the volume.
    return Number.isNaN(slice.values[at]) && slice.oblique ? null
      : {voxel: voxelAt(slice, this.size_, x, y), value: slice.values[at], own: slice.own[at]};
  }

  /**
   * The place of the slice that is nearest to the pointer, as a voxel; null without a slice.
   * @param {MouseEvent} event
   * @returns {Vector | null}
   */
  nearest(event) {
    const slice = this.slice_;
    if (!slice) {
      return null;
    }
    const [x, y] = sliceAtBox(slice, this.placed_(slice).place, ...this.inView(event));
    const within = (/** @type {number} */ at, /** @type {number} */ count) =>
      Math.min(Math.max(at, -0.5), count - 0.5);
    return voxelAt(slice, this.size_, within(x, slice.width), within(y, slice.height));
  }

  /**
   * CSS pixels from the top left of the view.
   * @param {MouseEvent} event
   * @returns {[number, number]}
   */
  inView(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
}
