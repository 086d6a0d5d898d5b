// One undo for the scene, whose changes the server keeps, and for the measurements of this page.

/** @typedef {'undo' | 'redo'} Way */
/** @typedef {{by: number, revision: number}} Sent  Infinity: without a reply so far. */

/**
 * Each change of a measurement has the number of the scene's step before it. The scene goes first
 * if it has changed since then.
 */
export class OneHistory {
  /**
   * @param {import('../link/connection.js').Connection} connection
   * @param {import('../state/store.js').Store} store
   * @param {import('./measures.js').Measures} measures
   */
  constructor(connection, store, measures) {
    /** @private */ this.connection_ = connection;
    /** @private */ this.store_ = store;
    /** @private */ this.measures_ = measures;
    /** Commands whose effect is not in the newest state. @private @type {Sent[]} */
    this.sent_ = [];
    /** The step of the newest state. @private */
    this.newest_ = 0;
    measures.clock = () => {
      if (!connection.watches) {
        connection.mark();  // A gesture must not join the one before the measurement.
      }
      return this.step_();
    };
    connection.on('lost', () => { this.sent_ = []; });
    store.subscribe(['revision', 'step'], ({revision, step}) => {
      const isRedo = this.sent_.some(({by}) => by > 0);
      this.sent_ = this.sent_.filter(each => each.revision > revision);
      if (step > this.newest_ && !isRedo) {
        measures.forgetUndone();
      }
      this.newest_ = step;
    });
  }

  /** @param {() => void} act  Called now and when undo or redo would do something else. */
  watch(act) {
    this.store_.subscribe(['undo', 'redo', 'step'], () => act());
    this.connection_.on('hello', () => act());
    this.measures_.watch(act);
  }

  /**
   * What a way would change, in words; null for nothing.
   * @param {Way} way
   */
  title(way) {
    const step = this.next_(way);
    return step?.measure?.title ?? step?.line ?? null;
  }

  /**
   * Pressing the key with nothing to undo is not an error.
   * @param {Way} way
   */
  go(way) {
    this.measures_.drop();
    const step = this.next_(way);
    if (step?.measure) {
      this.measures_[way]();
    } else if (step) {
      /** @type {Sent} */
      const sent = {by: way === 'undo' ? -1 : 1, revision: Infinity};
      this.sent_.push(sent);
      void this.connection_.do(way).then(({ok, revision = 0}) => {
        sent.revision = ok ? revision : 0;
        const now = this.store_.state?.revision ?? 0;
        this.sent_ = this.sent_.filter(each => each.revision > now);
      });
    }
  }

  /**
   * @private
   * @param {Way} way
   */
  next_(way) {
    const measure = this.measures_.changed[way].at(-1) ?? null;
    const line = this.connection_.watches ? null : this.store_.state?.[way] ?? null;
    const step = this.step_();
    const isSceneFirst = line !== null && (!measure
      || (way === 'undo' ? step > measure.step : step < measure.step));
    return isSceneFirst ? {line, measure: null} : measure ? {line: null, measure} : null;
  }

  /** The number of the scene's step, after all commands that were sent. @private */
  step_() {
    return this.sent_.reduce((step, {by}) => step + by, this.store_.state?.step ?? 0);
  }
}
