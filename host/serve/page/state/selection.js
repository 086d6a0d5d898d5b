// The chosen surface, which the histogram's keys, the tissue mode and the details refer to.

export class Selection {
  constructor() {
    /** Name of the surface, '' if none exists. */
    this.name = '';
    /** @private @type {Set<(name: string) => void>} */
    this.watchers_ = new Set();
  }

  /** @param {string} name */
  choose(name) {
    if (name !== this.name) {
      this.name = name;
      for (const act of this.watchers_) {
        act(name);
      }
    }
  }

  /**
   * @param {(name: string) => void} act  Called now and at each change.
   * @returns {() => void} ends it
   */
  watch(act) {
    this.watchers_.add(act);
    act(this.name);
    return () => void this.watchers_.delete(act);
  }

  /**
   * Chooses the last surface if the chosen surface no longer exists.
   * @param {import('../link/vocabulary.js').SurfaceState[]} surfaces
   */
  keepTo(surfaces) {
    if (!surfaces.some(({name}) => name === this.name)) {
      this.choose(surfaces.at(-1)?.name ?? '');
    }
  }
}
