// The newest state of the server, and the subscribers to its keys.
import {paced} from './paced.js';

const READ_MS = 100;  // A person cannot read texts that change more often.

/** @typedef {import('../link/vocabulary.js').State} State */
/** @typedef {keyof State} Key */

/**
 * Calls each subscriber once per state in which one of its keys has changed. Values are compared
 * as JSON, because the server sends new objects each time. A state has a few kilobytes.
 */
export class Store {
  constructor() {
    /** @type {State | null} */
    this.state = null;
    /** @private @type {Map<Key, string>} */
    this.texts_ = new Map();
    /** @private @type {Set<{keys: Key[], act: (state: State) => void}>} */
    this.subscribers_ = new Set();
  }

  /**
   * Calls `act` now, if a state exists, and whenever one of `keys` has changed.
   * @param {Key[]} keys
   * @param {(state: State) => void} act
   * @returns {() => void} ends the subscription
   */
  subscribe(keys, act) {
    const subscriber = {keys, act};
    this.subscribers_.add(subscriber);
    if (this.state) {
      act(this.state);
    }
    return () => void this.subscribers_.delete(subscriber);
  }

  /**
   * Calls `act` like `subscribe`, but at most ten times a second, with the newest state. This is
   * for texts and lists that a person reads: during a drag the time goes to the picture.
   * @param {Key[]} keys
   * @param {(state: State) => void} act
   */
  follow(keys, act) {
    this.subscribe(keys, paced(() => {
      if (this.state) {
        act(this.state);
      }
    }, READ_MS));
  }

  /**
   * Waits for a state. `test` is called now, if a state exists, and when one of `keys` has changed.
   * @param {Key[]} keys
   * @param {(state: State) => boolean} test
   * @returns {Promise<State>}
   */
  until(keys, test) {
    return new Promise(take => {
      const stop = this.subscribe(keys, state => {
        if (test(state)) {
          take(state);
          queueMicrotask(() => stop());  // The first call precedes the end of subscribe().
        }
      });
    });
  }

  /** @param {State} state */
  take(state) {
    const changed = new Set();
    for (const key of /** @type {Key[]} */ (Object.keys(state))) {
      const text = JSON.stringify(state[key]);
      if (text !== this.texts_.get(key)) {
        this.texts_.set(key, text);
        changed.add(key);
      }
    }
    this.state = state;
    for (const {keys, act} of [...this.subscribers_]) {
      if (keys.some(key => changed.has(key))) {
        act(state);
      }
    }
  }
}
