// Waits for refreshes of the screen.

export class Refresh {
  constructor() {
    /** @private */
    this.isWorn_ = false;
    /** @private Ends the wait. */
    this.wake_ = () => {};
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
}
