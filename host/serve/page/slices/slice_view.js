// One slice on a canvas: gray values, contours, crosshair, letters; pointer and keys.
import {contextOf, fitted, onceAFrame, styleColor, watchSize} from '../elements/canvas.js';
import {h} from '../elements/dom.js';
import {boxAt, paintGray, pixelAt, placedIn, sliceAtBox, voxelAt} from './slice_pixels.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_pixels.js').Placed} Placed */
/** @typedef {import('./slice_pixels.js').Slice} Slice */
/** @typedef {import('./slice_pixels.js').Window} Window */

/**
 * Callbacks of a slice view.
 * @typedef {object} Events
 * @property {(voxel: Vector) => void} point        The user chose this voxel.
 * @property {(voxel: Vector) => void} measure      The measuring tool picked this place.
 * @property {(value: number) => void} tissue       The tissue tool picked this value.
 * @property {(voxel: Vector | null, value: number | null) => void} hover
 * @property {(by: number) => void} step            To the next slices.
 * @property {(across: number, down: number) => void} window  Dragged so far, in CSS pixels.
 */

/** @typedef {'point' | 'measure' | 'window' | 'tissue'} Tool */

const CROSSHAIR_GAP = 6;    // Free space around the point, CSS pixels.
const LETTER_MARGIN = 4;
const LINE_WIDTH = 1.5;     // Contours, CSS pixels.
const EDGE_WIDTH = 1.25;    // Dark edge on either side of a contour.
const EDGE_COLOR = '#000c';
const TOUCHPAD_STEP = 40;   // deltaY per slice of a touchpad, which sends many small steps.
const LEAST_NOTCH = 50;     // A larger deltaY comes from a mouse wheel.
const NOTCH = 120;          // deltaY of one notch; browsers add up the notches of a fast turn.
const PAGE = 5;             // Slices per Page Up or Page Down.

export class SliceView {
  /**
   * @param {string} plane    'Axial', ...
   * @param {Events} events
   */
  constructor(plane, events) {
    /** @private */ this.plane_ = plane;
    /** @private */ this.events_ = events;
    /** @private @type {Tool} */ this.tool_ = 'point';
    /** @private @type {Slice | null} */ this.slice_ = null;
    /** @private @type {Vector} */ this.size_ = [1, 1, 1];
    /** @private @type {Vector | null} */ this.crosshair_ = null;
    /** @private */ this.wheel_ = 0;
    /** @private @type {{x: number, y: number, tool: Tool} | null} */ this.drag_ = null;
    /** @private */ this.gray_ = h('canvas');
    this.canvas = h('canvas', {
      class: 'slice-canvas', tabindex: 0, role: 'application',
      'aria-label': `${plane} slice`,
      'data-testid': `slice-${plane.toLowerCase()}`,
    });
    this.draw = onceAFrame(() => this.draw_());
    this.listen_();
    watchSize(this.canvas, this.draw);
  }

  /**
   * Shows a slice.
   * @param {Slice} slice
   * @param {Vector} size     Size of the volume, voxels.
   * @param {Window} through
   */
  show(slice, size, through) {
    this.slice_ = slice;
    this.size_ = size;
    this.repaint(through);
    this.canvas.setAttribute('aria-label', `${this.plane_} slice ${slice.index + 1} of ` +
      `${size[slice.axes[2]]}: arrow keys move the crosshair, Page Up and Down step slices`);
  }

  /** @param {Tool} tool */
  setTool(tool) {
    this.tool_ = tool;
    this.canvas.classList.toggle('picks', tool === 'tissue');
  }

  /** Clears the view. */
  clear() {
    this.slice_ = null;
    this.crosshair_ = null;
    this.canvas.setAttribute('aria-label', `${this.plane_} slice`);
    this.draw();
  }

  /** @param {Window} through */
  repaint(through) {
    const slice = this.slice_;
    if (slice) {
      this.gray_.width = slice.width;
      this.gray_.height = slice.height;
      const pixels = new ImageData(slice.width, slice.height);
      paintGray(slice.values, through, pixels.data);
      contextOf(this.gray_).putImageData(pixels, 0, 0);
      this.draw();
    }
  }

  /** @param {Vector | null} voxel */
  setCrosshair(voxel) {
    this.crosshair_ = voxel;
    this.draw();
  }

  /** @private */
  draw_() {
    const {context, width, height, unit} = fitted(this.canvas);
    const slice = this.slice_;
    if (!slice || width === 0) {
      return;
    }
    const place = placedIn(slice, width, height);
    this.drawGray_(context, slice, place);
    this.drawContours_(context, slice, place, unit);
    context.lineWidth = unit;
    if (this.crosshair_) {
      this.drawCrosshair_(context, slice, place, this.crosshair_);
    }
    this.drawLetters_(context, slice, width, height, unit);
  }

  /**
   * Draws evenly spaced rows at once, uneven rows one by one with their heights.
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {Slice} slice
   * @param {Placed} place
   */
  drawGray_(context, slice, place) {
    context.imageSmoothingQuality = 'high';
    if (!slice.places_mm?.[0] && !slice.places_mm?.[1]) {
      context.drawImage(this.gray_, place.left, place.top, place.width, place.height);
      return;
    }
    for (let y = 0; y < slice.height; ++y) {
      const top = boxAt(slice, place, 0, y - 0.5)[1], end = boxAt(slice, place, 0, y + 0.5)[1];
      context.drawImage(this.gray_, 0, y, slice.width, 1, place.left, top, place.width, end - top);
    }
  }

  /**
   * Draws contours with a dark edge, so that light contours stay visible on bone.
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {Slice} slice
   * @param {Placed} place
   * @param {number} unit
   */
  drawContours_(context, slice, place, unit) {
    context.lineCap = 'round';
    const lines = slice.contours.map(({color, first, count}) => {
      const path = new Path2D();
      for (let i = 4 * first; i < 4 * (first + count); i += 4) {
        const [x0, y0, x1, y1] = slice.segments.subarray(i, i + 4);
        path.moveTo(...boxAt(slice, place, x0, y0));
        path.lineTo(...boxAt(slice, place, x1, y1));
      }
      return {color, path};
    });
    // Draws all edges first, so that no edge covers a line.
    context.strokeStyle = EDGE_COLOR;
    context.lineWidth = (LINE_WIDTH + 2 * EDGE_WIDTH) * unit;
    lines.forEach(({path}) => context.stroke(path));
    context.lineWidth = LINE_WIDTH * unit;
    for (const {color, path} of lines) {
      context.strokeStyle = color;
      context.stroke(path);
    }
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {Slice} slice
   * @param {Placed} place
   * @param {Vector} voxel
   */
  drawCrosshair_(context, slice, place, voxel) {
    const [x, y] = boxAt(slice, place, ...pixelAt(slice, this.size_, voxel));
    const right = place.left + place.width, bottom = place.top + place.height;
    context.strokeStyle = styleColor(this.canvas, '--accent');
    context.beginPath();
    context.moveTo(place.left, y);
    context.lineTo(x - CROSSHAIR_GAP, y);
    context.moveTo(x + CROSSHAIR_GAP, y);
    context.lineTo(right, y);
    context.moveTo(x, place.top);
    context.lineTo(x, y - CROSSHAIR_GAP);
    context.moveTo(x, y + CROSSHAIR_GAP);
    context.lineTo(x, bottom);
    context.stroke();
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {Slice} slice
   * @param {number} width
   * @param {number} height
   * @param {number} unit
   */
  drawLetters_(context, {letters}, width, height, unit) {
    context.font = `600 ${12 * unit}px system-ui, sans-serif`;
    context.textBaseline = 'middle';
    context.lineWidth = 3 * unit;
    context.strokeStyle = '#000c';
    context.fillStyle = '#fff';
    /** @type {[string, number, number, CanvasTextAlign][]} */
    const places = [[letters.left, LETTER_MARGIN, height / 2, 'left'],
      [letters.right, width - LETTER_MARGIN, height / 2, 'right'],
      [letters.top, width / 2, LETTER_MARGIN + 6 * unit, 'center'],
      [letters.bottom, width / 2, height - LETTER_MARGIN - 6 * unit, 'center']];
    for (const [letter, x, y, align] of places) {
      context.textAlign = align;
      context.strokeText(letter, x, y);
      context.fillText(letter, x, y);
    }
  }

  /**
   * The voxel under the pointer, and its value; null outside of the slice.
   * @private
   * @param {MouseEvent} event
   * @returns {{voxel: Vector, value: number} | null}
   */
  under_(event) {
    const slice = this.slice_;
    if (!slice) {
      return null;
    }
    const box = this.canvas.getBoundingClientRect();
    const place = placedIn(slice, box.width, box.height);
    const [x, y] = sliceAtBox(slice, place, event.clientX - box.left, event.clientY - box.top);
    const column = Math.round(x), row = Math.round(y);
    if (column < 0 || row < 0 || column >= slice.width || row >= slice.height) {
      return null;
    }
    const value = slice.values[row * slice.width + column];
    return {voxel: voxelAt(slice, this.size_, x, y), value};
  }

  /** @private */
  listen_() {
    const canvas = this.canvas;
    canvas.addEventListener('pointerdown', event => this.press_(event));
    canvas.addEventListener('pointermove', event => this.move_(event));
    canvas.addEventListener('pointerup', () => { this.drag_ = null; });
    canvas.addEventListener('pointercancel', () => { this.drag_ = null; });
    canvas.addEventListener('pointerleave', () => this.events_.hover(null, null));
    canvas.addEventListener('contextmenu', event => event.preventDefault());
    canvas.addEventListener('wheel', event => this.turn_(event), {passive: false});
    canvas.addEventListener('keydown', event => this.key_(event));
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  press_(event) {
    this.canvas.focus();
    this.canvas.setPointerCapture(event.pointerId);
    const tool = event.button === 2 || event.shiftKey ? 'window' : this.tool_;
    this.drag_ = {x: event.clientX, y: event.clientY, tool};
    const under = this.under_(event);
    if (under && tool === 'point') {
      this.events_.point(under.voxel);
    } else if (under && tool === 'measure') {
      this.events_.measure(under.voxel);
    } else if (under && tool === 'tissue') {
      this.events_.tissue(under.value);
    }
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  move_(event) {
    const under = this.under_(event);
    this.events_.hover(under?.voxel ?? null, under?.value ?? null);
    const drag = this.drag_;
    if (drag?.tool === 'window') {
      this.events_.window(event.clientX - drag.x, event.clientY - drag.y);
      this.drag_ = {x: event.clientX, y: event.clientY, tool: drag.tool};
    } else if (drag?.tool === 'point' && under) {
      this.events_.point(under.voxel);
    }
  }

  /**
   * @private
   * @param {WheelEvent} event
   */
  turn_(event) {
    event.preventDefault();
    const isPixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL;
    if (!isPixels || Math.abs(event.deltaY) >= LEAST_NOTCH) {
      const notches = isPixels ? Math.max(1, Math.round(Math.abs(event.deltaY) / NOTCH)) : 1;
      this.wheel_ = 0;
      this.events_.step(Math.sign(event.deltaY) * notches);
      return;
    }
    this.wheel_ += event.deltaY;
    const steps = Math.trunc(this.wheel_ / TOUCHPAD_STEP);
    if (steps !== 0) {
      this.wheel_ -= steps * TOUCHPAD_STEP;
      this.events_.step(steps);
    }
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   */
  key_(event) {
    const steps = new Map([['PageUp', PAGE], ['PageDown', -PAGE], [']', 1], ['[', -1]]);
    const moves = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]], ['ArrowUp', [0, -1]],
      ['ArrowDown', [0, 1]]]);
    const step = steps.get(event.key), move = moves.get(event.key);
    if (step !== undefined) {
      this.events_.step(step);
    } else if (move && this.slice_ && this.crosshair_) {
      const [x, y] = pixelAt(this.slice_, this.size_, this.crosshair_);
      const to = voxelAt(this.slice_, this.size_, x + move[0], y + move[1]);
      this.events_.point(to);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}
