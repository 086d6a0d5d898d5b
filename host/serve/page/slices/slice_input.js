// Pointer, wheel, fingers and keys on a slice.

/** @typedef {import('./slice_view.js').SliceView} SliceView */
/** @typedef {import('./slice_view.js').Events} Events */
/** @typedef {'point' | 'move' | 'measure' | 'window' | 'tissue'} Tool */

const TOUCHPAD_STEP = 40;   // deltaY per slice of a touchpad, which sends many small steps.
const LEAST_NOTCH = 50;     // A larger deltaY comes from a mouse wheel.
const NOTCH = 120;          // deltaY of one notch; browsers add up the notches of a fast turn.
const MIDDLE = 1, RIGHT = 2;  // Buttons of a mouse.
const PAGE = 5;             // Slices per Page Up or Page Down.
const ZOOM_STEP = 1.25;     // Of one key, or one notch with Ctrl.

const STEPS = new Map([['PageUp', PAGE], ['PageDown', -PAGE], [']', 1], ['[', -1]]);
const MOVES = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]], ['ArrowUp', [0, -1]],
  ['ArrowDown', [0, 1]]]);
const ZOOMS = new Map([['+', ZOOM_STEP], ['=', ZOOM_STEP], ['-', 1 / ZOOM_STEP], ['0', 0]]);

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
    /** @private @type {{x: number, y: number, tool: Tool} | null} */ this.drag_ = null;
    /** The last move of a pointer that is still here. @private @type {MouseEvent | null} */
    this.pointer_ = null;
    /** @private Pressed fingers and buttons. @type {Map<number, [number, number]>} */
    this.fingers_ = new Map();
    this.listen_();
  }

  /** Reports what is under the pointer now, if there is one. */
  hover() {
    const under = this.pointer_ && this.view_.under(this.pointer_);
    if (this.pointer_) {
      this.events_.hover(under?.voxel ?? null, under?.value ?? null);
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
    const release = (/** @type {PointerEvent} */ event) => {
      const measures = this.drag_?.tool === 'measure';
      this.fingers_.delete(event.pointerId);
      this.drag_ = null;
      if (measures) {
        const isEnd = event.type === 'pointerup';
        this.events_.measure(isEnd ? 'release' : 'cancel', this.view_.under(event)?.voxel ?? null);
      }
    };
    canvas.addEventListener('pointerdown', event => this.press_(event));
    canvas.addEventListener('pointermove', event => this.move_(event));
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('mousedown', event => {
      if (event.button === MIDDLE) {
        event.preventDefault();  // Else the browser scrolls the page.
      }
    });
    canvas.addEventListener('dblclick', event => {
      if (this.tool === 'move') {
        this.events_.zoom(0, this.view_.inView(event));
      }
    });
    canvas.addEventListener('pointerleave', () => {
      this.pointer_ = null;
      this.events_.hover(null, null);
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
      if (this.drag_?.tool === 'measure') {
        this.events_.measure('cancel', null);
      }
      this.drag_ = null;  // Two fingers move and zoom.
      return;
    }
    const tool = event.button === MIDDLE ? 'move'
      : event.button === RIGHT || event.shiftKey ? 'window' : this.tool;
    this.drag_ = {x: event.clientX, y: event.clientY, tool};
    const under = this.view_.under(event);
    if (under && tool === 'point') {
      this.events_.point(under.voxel);
    } else if (under && tool === 'measure') {
      this.events_.measure('press', under.voxel);
    } else if (under && tool === 'tissue') {
      this.events_.tissue(under.value);
    }
  }

  /**
   * @private
   * @param {PointerEvent} event
   */
  move_(event) {
    this.pointer_ = event;
    const under = this.hover();
    if (this.fingers_.size === 2 && this.fingers_.has(event.pointerId)) {
      this.pinch_(event);
      return;
    }
    const drag = this.drag_;
    if (drag?.tool === 'window' || drag?.tool === 'move') {
      const across = event.clientX - drag.x, down = event.clientY - drag.y;
      this.drag_ = {x: event.clientX, y: event.clientY, tool: drag.tool};
      if (drag.tool === 'window') {
        this.events_.window(across, down);
      } else {
        this.view_.moveBy(across, down);
      }
    } else if (drag?.tool === 'point' && under) {
      this.events_.point(under.voxel);
    } else if (drag?.tool === 'measure' && under) {
      this.events_.measure('move', under.voxel);
    }
  }

  /**
   * The place between two fingers moves with them, and the zoom is in proportion to their distance.
   * @private
   * @param {PointerEvent} event
   */
  pinch_(event) {
    const spread = () => {
      const [[x0, y0], [x1, y1]] = [...this.fingers_.values()];
      return {distance: Math.max(Math.hypot(x1 - x0, y1 - y0), 1),
        middle: /** @type {[number, number]} */ ([(x0 + x1) / 2, (y0 + y1) / 2])};
    };
    const before = spread();
    this.fingers_.set(event.pointerId, this.view_.inView(event));
    const now = spread();
    this.view_.moveBy(now.middle[0] - before.middle[0], now.middle[1] - before.middle[1]);
    this.events_.zoom(now.distance / before.distance, now.middle);
  }

  /**
   * @private
   * @param {WheelEvent} event
   */
  turn_(event) {
    event.preventDefault();
    if (event.ctrlKey || event.metaKey) {  // Also two fingers on a touchpad.
      this.events_.zoom(ZOOM_STEP ** (-event.deltaY / NOTCH), this.view_.inView(event));
      return;
    }
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
    const step = STEPS.get(event.key), move = MOVES.get(event.key), zoom = ZOOMS.get(event.key);
    const next = move && this.view_.besideCrosshair(move[0], move[1]);
    if (step !== undefined) {
      this.events_.step(step);
    } else if (zoom !== undefined && !event.ctrlKey && !event.metaKey) {
      this.events_.zoom(zoom, null);
    } else if (next) {
      this.events_.point(next);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}
