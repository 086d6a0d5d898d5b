// Waits for refreshes of the screen.

export class Refresh {
  constructor() {
    /** @private */
    this.isWorn_ = false;
    /** @private Each ends a wait. @type {Set<() => void>} */
    this.wakes_ = new Set();
    /** @private Resolves when the screen shows what was drawn last. @type {Promise<unknown>} */
    this.shown_ = Promise.resolve();
  }

  /**
   * Whether a headset is worn: the window may have no screen refresh then.
   * @param {boolean} isWorn
   */
  set isWorn(isWorn) {
    this.isWorn_ = isWorn;
    this.wakes_.forEach(wake => wake());
  }

  /**
   * Waits for the next screen refresh, if there may be one. What is drawn then is part of it.
   * @returns {Promise<void>}
   */
  next() {
    return this.isWorn_ ? Promise.resolve() : new Promise(done => {
      const wake = () => {
        this.wakes_.delete(wake);
        done();
      };
      this.wakes_.add(wake);
      requestAnimationFrame(wake);
    });
  }

  /**
   * Waits until the screen shows what was drawn after the last call. What is drawn then is seen at
   * the next refresh, and the time until the refresh is free for other work.
   */
  room() {
    const shown = this.shown_;
    this.shown_ = shown.then(() => this.next()).then(nextTask);
    return shown;
  }
}

/** After a refresh has begun, the next task runs when the refresh is done. */
function nextTask() {
  return new Promise(done => {
    const {port1, port2} = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      done(0);
    };
    port2.postMessage(0);
  });
}
