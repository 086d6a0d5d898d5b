// How the picture and the slices share the window, and how wide the sides are.

const KEY = 'pxpl5-layout';
const NAMES = /** @type {const} */ (['picture', 'beside', 'four', 'slices']);
const EDGES = /** @type {const} */ (['left', 'right', 'sheet']);

/** @typedef {typeof NAMES[number]} LayoutName  Picture; picture and three slices; 2 x 2; slices. */
/** @typedef {typeof EDGES[number]} Edge  Side, or both sides below the picture. */

/**
 * @typedef {object} Arrangement
 * @property {LayoutName} name
 * @property {boolean} left      Whether the side is open.
 * @property {boolean} right
 * @property {Record<Edge, number | null>} sizes  Chosen widths or heights, in rem; null: the usual.
 */

/** @type {Arrangement} */
const USUAL = {name: 'picture', left: true, right: true,
  sizes: {left: null, right: null, sheet: null}};

/** The arrangement of this page. The browser keeps it for the next visit. */
export class Layout {
  constructor() {
    /** @private @type {Set<(now: Arrangement) => void>} */
    this.watchers_ = new Set();
    this.now = kept();
  }

  /** @param {Partial<Arrangement>} part */
  change(part) {
    this.now = {...this.now, ...part};
    try {
      localStorage.setItem(KEY, JSON.stringify(this.now));
    } catch {
      // Without storage each visit begins with the usual arrangement.
    }
    this.watchers_.forEach(act => act(this.now));
  }

  /**
   * @param {Edge} edge
   * @param {number | null} rem
   */
  resize(edge, rem) {
    this.change({sizes: {...this.now.sizes, [edge]: rem}});
  }

  /** @param {'left' | 'right'} side */
  toggle(side) {
    this.change({[side]: !this.now[side]});
  }

  /** @param {unknown} saved  `now` of another page. */
  restore(saved) {
    this.change(checked(saved));
  }

  /** @param {(now: Arrangement) => void} act  Called now and at each change. */
  watch(act) {
    this.watchers_.add(act);
    act(this.now);
  }
}

function kept() {
  try {
    return checked(JSON.parse(localStorage.getItem(KEY) ?? 'null'));
  } catch {
    return USUAL;  // No storage, or not ours.
  }
}

/**
 * The valid fields of an arrangement from a file or from the storage, and defaults for others.
 * @param {any} saved
 * @returns {Arrangement}
 */
function checked(saved) {
  const size = (/** @type {Edge} */ edge) => {
    const rem = saved?.sizes?.[edge];
    return Number.isFinite(rem) && rem > 0 ? Number(rem) : null;
  };
  return {
    name: NAMES.find(each => each === saved?.name) ?? USUAL.name,
    left: saved?.left !== false, right: saved?.right !== false,
    sizes: {left: size('left'), right: size('right'), sheet: size('sheet')},
  };
}
