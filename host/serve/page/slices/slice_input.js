// Pointer, wheel, fingers and keys on a slice.
import {notchesOf, timesOf} from '../elements/wheel.js';
import {ZOOM_STEP} from './slice_zoom.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_ends.js').End} End */
/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {'point' | 'move' | 'measure' | 'window' | 'tissue'} Tool */
/** @typedef {[number, number]} Place  CSS pixels of the view. */

/**
 * Callbacks of a slice view.
 * @typedef {object} Events
 * @property {(voxel: Vector) => void} point        The user chose this voxel.
 * @property {(phase: Phase, voxel: Vector | null) => void} measure  The measuring tool was used at
 *     this place; null outside of the slice.
 * @property {(phase: Phase, end: End, voxel: Vector | null) => void} end  A pointer drags an end of
 *     a measurement to this place; null if it stops.
 * @property {(value: number) => void} tissue       The tissue tool picked this value.
 * @property {(under: Under | null) => void} hover
 * @property {(by: number) => void} step            To the next slices.
 * @property {(across: number, down: number) => void} window  Dragged so far, in CSS pixels.
 * @property {(by: number, at: [number, number] | null) => void} zoom  `by` times larger, around a
 *     place of this view, in CSS pixels, or the crosshair; 0: the whole slice.
 */

/** @typedef {'press' | 'move' | 'release' | 'cancel' | 'end'} Phase  'end': of a path. */
/**
 * The voxel, not rounded, the value that is shown there, and the voxel's own.
 * @typedef {{voxel: Vector, value: number, own: number}} Under
 */

const TOUCHPAD_STEP = 40;   // deltaY per slice of a touchpad, which sends many small steps.
const MIDDLE = 1, RIGHT = 2;  // Buttons of a mouse.
const PAGE = 5;             // Slices per Page Up or Page Down.
const TAP_PX = 6;           // A finger that moves less taps.
const CLICK_PX = 3;         // A mouse on an end that moves less clicks.
const MOUSE_REACH = 12, FINGER_REACH = 22;  // From an end that is grabbed, CSS pixels.

const STEPS = new Map([['PageUp', PAGE], ['PageDown', -PAGE], [']', 1], ['[', -1]]);
const MOVES = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]], ['ArrowUp', [0, -1]],
  ['ArrowDown', [0, 1]]]);
const ZOOMS = new Map([['+', ZOOM_STEP], ['=', ZOOM_STEP], ['-', 1 / ZOOM_STEP], ['0', 0]]);

/**
 * A pressed button or finger.
 * @typedef {object} Drag
 * @property {Tool} tool
 * @property {Place} last
 * @property {Under | null} from    What was under it at first.
 * @property {boolean} isUsed       False of a finger that may become one of two.
 * @property {import('./slice_ends.js').End | null} end  The end of a measurement that it grabs.
 * @property {boolean} isMoved      Whether it drags the end.
 */

export class SliceInput {
  /**
   * @param {SliceView} view
   * @param {Events} events
   */
  constructor(view, events) {
    /** @private */ this.view_ = view;
    /** @private */ this.events_ = events;
    /** @type {Tool} */ this.tool = 'point';
    /** @private */ this.wheel_ = 0;
    /** @private @type {Drag | null} */ this.drag_ = null;
    /** The last move of a pointer that is still here. @private @type {MouseEvent | null} */
    this.pointer_ = null;
    /** Pressed fingers and buttons. @private @type {Map<number, Place>} */
    this.fingers_ = new Map();
    this.listen_();
  }

  /** Reports what is under the pointer now, if there is one. */
  hover() {
    const under = this.pointer_ && this.view_.under(this.pointer_);
    if (this.pointer_) {
      this.events_.hover(under);
    }
    return under;
  }

  /** Whether a button or a finger is down. */
  get drags() {
    return this.fingers_.size > 0;
  }

  /** @private */
  listen_() {
    const {canvas} = this.view_;
    canvas.addEventListener('pointerdown', event => this.press_(event));
    canvas.addEventListener('pointermove', event => this.move_(event));
    canvas.addEventListener('pointerup', event => this.release_(event));
    canvas.addEventListener('pointercancel', event => this.lose_(event.pointerId));
    // Also if the canvas is moved or hidden under a finger.
    canvas.addEventListener('lostpointercapture', event => this.lose_(event.pointerId));
    canvas.addEventListener('mousedown', event => {
      // Else the browser scrolls the page, or takes the focus from a field that a press opened.
      if (event.button === MIDDLE || document.activeElement?.matches('.note-editor')) {
        event.preventDefault();
      }
    });
    canvas.addEventListener('dblclick', event => {
      if (this.tool === 'move') {
        this.events_.zoom(0, this.view_.inView(event));
      }
    });
    canvas.addEventListener('pointerleave', () => {
      this.pointer_ = null;
      this.events_.hover(null);
    });
    canvas.addEventListener('contextmenu', event => event.preventDefault());
    canvas.addEventListener('wheel', event => this.turn_(event), {passive: false});
    canvas.addEventListener('keydown', event => this.key_(event));
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  press_(event) {
    this.view_.canvas.focus();
    this.view_.canvas.setPointerCapture(event.pointerId);
    this.fingers_.set(event.pointerId, this.view_.inView(event));
    if (this.fingers_.size > 1) {
      this.drop_();  // Two fingers move and zoom.
      return;
    }
    const tool = event.button === MIDDLE ? 'move'
      : event.button === RIGHT || event.shiftKey ? 'window' : this.tool;
    const last = this.view_.inView(event), isFinger = event.pointerType === 'touch';
    const end = this.endAt_(event);
    this.drag_ = {tool, last, from: this.view_.under(event), isUsed: false, isMoved: false,
      end: tool === 'measure' ? end : null};
    if (!isFinger && !this.drag_.end) {
      this.use_(this.drag_);
    }
  }

  /**
   * The end of a measurement that a press would grab.
   * @private
   * @param {PointerEvent} event
   */
  endAt_(event) {
    return this.tool !== 'measure' ? null : this.view_.endAt(this.view_.inView(event),
      event.pointerType === 'touch' ? FINGER_REACH : MOUSE_REACH);
  }

  /**
   * The effect of a press. A finger has it when it moves or is lifted, because a second may come.
   * @private
   * @param {Drag} drag
   */
  use_(drag) {
    if (drag.isUsed) {
      return;
    }
    drag.isUsed = true;
    if (drag.from && drag.tool === 'point') {
      this.events_.point(drag.from.voxel);
    } else if (drag.from && drag.tool === 'measure') {
      this.events_.measure('press', drag.from.voxel);
    } else if (drag.from && drag.tool === 'tissue') {
      this.events_.tissue(drag.from.value);
    }
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  move_(event) {
    this.pointer_ = event;
    const under = this.hover();
    const before = [...this.fingers_.values()], place = this.view_.inView(event);
    if (this.fingers_.has(event.pointerId)) {
      this.fingers_.set(event.pointerId, place);
    }
    if (this.fingers_.size === 2 && this.fingers_.has(event.pointerId)) {
      this.pinch_(before, [...this.fingers_.values()]);
      return;
    }
    const drag = this.drag_;
    if (!drag) {
      this.view_.canvas.classList.toggle('grabs', this.endAt_(event) !== null);
    }
    const across = place[0] - (drag?.last[0] ?? 0), down = place[1] - (drag?.last[1] ?? 0);
    const least = event.pointerType === 'touch' ? TAP_PX : CLICK_PX;
    if (!drag || !drag.isUsed && !drag.isMoved && Math.hypot(across, down) < least) {
      return;
    }
    if (drag.end) {
      drag.isMoved = true;
      this.events_.end('move', drag.end, this.view_.nearest(event));
      return;
    }
    this.use_(drag);
    drag.last = place;
    if (drag.tool === 'window') {
      this.events_.window(across, down);
    } else if (drag.tool === 'move') {
      this.view_.moveBy(across, down);
    } else if (drag.tool === 'point' && under) {
      this.events_.point(under.voxel);
    } else if (drag.tool === 'measure') {
      this.events_.measure('move', this.view_.nearest(event));
    }
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  release_(event) {
    const drag = this.drag_;
    this.drag_ = null;
    this.fingers_.delete(event.pointerId);
    if (drag?.end && drag.isMoved) {
      this.events_.end('release', drag.end, this.view_.nearest(event));
    } else if (drag) {
      this.use_(drag);
      if (drag.tool === 'measure') {
        this.events_.measure('release', this.view_.nearest(event));
      }
    }
  }

  /**
   * @private
   * @param {number} finger
   */
  lose_(finger) {
    if (this.fingers_.delete(finger)) {
      this.drop_();
    }
  }

  /** @private */
  drop_() {
    const end = this.drag_?.isMoved ? this.drag_.end : null;
    if (end) {
      this.events_.end('cancel', end, null);
    } else if (this.drag_?.tool === 'measure') {
      this.events_.measure('cancel', null);
    }
    this.drag_ = null;
  }

  /**
   * The place between two fingers moves with them, and the zoom is in proportion to their distance.
   * @private
   * @param {Place[]} before
   * @param {Place[]} now
   */
  pinch_(before, now) {
    const spread = (/** @type {Place[]} */ [[x0, y0], [x1, y1]]) => ({
      distance: Math.max(Math.hypot(x1 - x0, y1 - y0), 1), x: (x0 + x1) / 2, y: (y0 + y1) / 2});
    const was = spread(before), is = spread(now);
    this.view_.moveBy(is.x - was.x, is.y - was.y);
    this.events_.zoom(is.distance / was.distance, [is.x, is.y]);
  }

  /**
   * @private
   * @param {WheelEvent} event
   */
  turn_(event) {
    event.preventDefault();
    const notches = notchesOf(event);
    if (event.ctrlKey || event.metaKey) {  // Also two fingers on a touchpad, in small steps.
      this.events_.zoom(timesOf(event, ZOOM_STEP), this.view_.inView(event));
    } else if (notches !== 0) {
      this.wheel_ = 0;
      this.events_.step(notches);
    } else {
      this.wheel_ += event.deltaY;
      const steps = Math.trunc(this.wheel_ / TOUCHPAD_STEP);
      if (steps !== 0) {
        this.wheel_ -= steps * TOUCHPAD_STEP;
        this.events_.step(steps);
      }
    }
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   */
  key_(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    const step = STEPS.get(event.key), move = MOVES.get(event.key), zoom = ZOOMS.get(event.key);
    const next = move && this.view_.besideCrosshair(move[0], move[1]);
    const measures = this.tool === 'measure';
    if (step !== undefined) {
      this.events_.step(step);
    } else if (zoom !== undefined) {
      this.events_.zoom(zoom, null);
    } else if (next) {
      this.events_.point(next);
    } else if (measures && event.key === 'Enter') {
      this.events_.measure('press', this.view_.besideCrosshair(0, 0));
    } else if (this.drag_?.isMoved && event.key === 'Escape') {
      this.drop_();
    } else if (measures && event.key === 'Escape') {
      this.events_.measure('end', null);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}
