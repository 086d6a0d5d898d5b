// Waits for refreshes of the screen.

export class Refresh {
  constructor() {
    /** @private */
    this.isWorn_ = false;
    /** @private Ends the wait. */
    this.wake_ = () => {};
    /** @private Is kept at the first refresh after the last picture. @type {Promise<unknown>} */
    this.shown_ = Promise.resolve();
  }

  /**
   * Whether a headset is worn: the window may have no screen refresh then.
   * @param {boolean} isWorn
   */
  set isWorn(isWorn) {
    this.isWorn_ = isWorn;
    this.wake_();
  }

  /** Waits for the next screen refresh, if there may be one. */
  next() {
    return this.isWorn_ ? Promise.resolve() : new Promise(wake => {
      this.wake_ = () => wake(0);
      requestAnimationFrame(this.wake_);
    });
  }

  /**
   * Waits until the screen has been refreshed since the last call was answered: what is drawn then
   * is seen at the next refresh, as after next(), and the time until then is free for other work.
   */
  room() {
    const shown = this.shown_;
    this.shown_ = shown.then(() => this.next());
    return shown;
  }
}
