// Parts of a session that only the page knows: window, crosshair, measurements.
import {say} from '../texts/say.js';

/**
 * A part of the page that a saved session keeps.
 * @typedef {object} Part
 * @property {() => unknown} save           What JSON can hold; null for nothing.
 * @property {(saved: any) => void} restore  Called after the volume is open.
 */

/** @typedef {import('../link/types.js').Session} Session */

/** @type {Record<string, string>}  The parts' names for the user. */
const SHOWN = {layout: say`layout`, window: say`window`, slices: say`slices`, slabs: say`slabs`,
  oblique: say`oblique`, crosshair: say`crosshair`, measurements: say`measurements`};

export class PageSession {
  constructor() {
    /** @private @type {Map<string, Part>} */
    this.parts_ = new Map();
    /** The session that waits for the files of its volume. @type {Session | null} */
    this.wanting = null;
    /**
     * Asks the user for the files. The dialog sets it.
     * @type {(session: Session, why: string) => void}
     */
    this.ask = () => {};
  }

  /**
   * @param {string} name
   * @param {Part} part
   */
  add(name, part) {
    this.parts_.set(name, part);
  }

  /** @returns {Record<string, unknown>} */
  saved() {
    return Object.fromEntries([...this.parts_].map(([name, {save}]) => [name, save()]));
  }

  /**
   * @param {Record<string, unknown>} saved
   * @returns {string[]} a sentence for each part that cannot be restored; the others are
   */
  restore(saved) {
    return [...this.parts_].flatMap(([name, part]) => {
      try {
        if (saved[name] !== undefined && saved[name] !== null) {
          part.restore(saved[name]);
        }
        return [];
      } catch (error) {
        const why = /** @type {Error} */ (error).message;
        return [say`The session's ${SHOWN[name] ?? name} was left out: ${why}`];
      }
    });
  }
}
