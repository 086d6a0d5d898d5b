// Finds texts that are not translated. With ?lang=marked, brackets stand around each text of the
// page, but not around its parts: names, numbers, and texts that have brackets of their own.

/**
 * Names that are the same in every language: of files, programs, colors, built-in volumes, nodes,
 * topologies and tables. Abbreviations and instructions are, too: they begin with three capitals.
 */
const NAMES = ['NIfTI', 'Wavefront', 'binary', 'default', 'fetus', 'framebuffer', 'glTF', 'glb',
  'head', 'host', 'letters', 'obj', 'paper', 'pelvis', 'ply', 'renderer', 'sphere', 'stl', 'torus',
  'viridis', 'vtp', 'watertight'];

/** Runs in the page before its own code: keeps what is written into canvases. */
export function keepWriting() {
  globalThis.written = new Set();
  for (const { prototype } of [CanvasRenderingContext2D, OffscreenCanvasRenderingContext2D]) {
    const plain = prototype.fillText;
    prototype.fillText = function (text, ...rest) {
      globalThis.written.add(String(text));
      plain.call(this, text, ...rest);
    };
  }
}

/**
 * Words outside of brackets, each with the element that shows it. Data have translate="no", as in
 * HTML, and English texts of the machine have a language of their own.
 * @param {string[]} [names]  Further words that need no translation.
 * @returns {Promise<[string, string][]>} words with their places, and the texts
 */
export function unmarked(page, names = []) {
  return page.evaluate(unmarkedWords, [...NAMES, ...names]);
}

/**
 * Runs in the page.
 * @param {string[]} names  Words that need no translation.
 */
function unmarkedWords(names) {
  const { volume, surfaces, undo, redo } = globalThis.pxpl5.state;
  const lines = [undo, redo].filter(Boolean);  // Command lines.
  const data = [volume.name, volume.source, ...surfaces.map(({ name }) => name)].join(' ');
  const known = new Set([...names, ...data.match(/\p{L}{3,}/gu)]);
  const found = new Map();
  const look = (text, place) => {
    const rest = lines.reduce((all, line) => all.replace(`⟧${line}⟦`, '⟧⟦'), text);
    const outside = rest.replace(/⟦[^⟦⟧]*⟧/g, ' ').match(/\p{L}{3,}/gu) ?? [];
    for (const word of outside.filter(each => !known.has(each) && !/^\p{Lu}{3}/u.test(each))) {
      found.set(`${word} (${place})`, text.slice(0, 120));
    }
  };
  const placeOf = element => {
    const named = element.closest('[data-testid], [id]');
    return named?.getAttribute('data-testid') ?? named?.id ?? element.tagName;
  };
  for (const element of document.body.querySelectorAll('*')) {
    if (element.closest('[translate=no], body [lang], code, pre, script, style')) continue;
    for (const name of ['aria-label', 'title', 'alt', 'aria-valuetext']) {
      const text = element.getAttribute(name);
      if (text) look(text, `${placeOf(element)} ${name}`);
    }
    for (const node of element.childNodes) {
      if (node.nodeType === Node.TEXT_NODE) look(node.textContent, placeOf(element));
    }
  }
  for (const text of globalThis.written ?? []) look(text, 'canvas');
  return [...found];
}

/** Collects what is found in several looks at a page, once each. */
export class Findings {
  /** @param {string[]} [names]  Further words that need no translation. */
  constructor(names) {
    this.names = names;
    this.found = new Map();
  }

  async look(page, where) {
    for (const [word, text] of await unmarked(page, this.names)) {
      if (!this.found.has(word)) this.found.set(word, `${where}: ${word}: '${text}'`);
    }
  }

  get all() {
    return [...this.found.values()];
  }
}
