// What a click on the picture means just now: nothing special, or what a panel asked for.

/**
 * @typedef {object} Mode
 * @property {string} name
 * @property {string} hint                One line, shown over the picture while the mode lasts.
 * @property {(x: number, y: number) => void} click  Pixel of the picture (`state.size`).
 * @property {(value: number) => void} [value]  A click on a slice, where the volume has `value`.
 * @property {string} [surface]          That it sets something of; the mode ends with it.
 * @property {() => void} [leave]         Called when the mode ends, however it ends.
 */

/** At most one mode at a time; dragging and zooming work in all of them. */
export class Modes {
  constructor() {
    /** @type {Mode | null} */
    this.current = null;
    /** @private @type {Set<(mode: Mode | null) => void>} */
    this.watchers_ = new Set();
  }

  /**
   * Ends the mode before, if there is one, and begins this.
   * @param {Mode} mode
   */
  enter(mode) {
    this.end_();
    this.current = mode;
    this.tell_();
  }

  /**
   * Back to no mode.
   * @param {string} [name]  Only if it is this one.
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
