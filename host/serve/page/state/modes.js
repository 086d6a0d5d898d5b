// The current mode of a click on the picture, which a panel can set.

/**
 * @typedef {object} Mode
 * @property {string} name
 * @property {string} hint                One line, shown over the picture while the mode lasts.
 * @property {(x: number, y: number) => void} click  Pixel of the picture.
 * @property {(value: number) => void} [value]  A click on a slice, where the volume has `value`.
 * @property {string} [surface]          The surface that the mode changes.
 * @property {() => void} [leave]         Called whenever the mode ends.
 */

/** At most one mode is active. Dragging and zooming work in all modes. */
export class Modes {
  constructor() {
    /** @type {Mode | null} */
    this.current = null;
    /** @private @type {Set<(mode: Mode | null) => void>} */
    this.watchers_ = new Set();
  }

  /**
   * Ends the current mode, if any, and starts a new mode.
   * @param {Mode} mode
   */
  enter(mode) {
    this.end_();
    this.current = mode;
    this.tell_();
  }

  /**
   * Leaves the current mode.
   * @param {string} [name]  Leave only this mode.
   */
  leave(name) {
    if (this.current && (name === undefined || this.current.name === name)) {
      this.end_();
      this.tell_();
    }
  }

  /** @param {(mode: Mode | null) => void} act  Called now and at each change. */
  watch(act) {
    this.watchers_.add(act);
    act(this.current);
  }

  /** @private */
  end_() {
    const ended = this.current;
    this.current = null;
    ended?.leave?.();
  }

  /** @private */
  tell_() {
    for (const act of this.watchers_) {
      act(this.current);
    }
  }
}
