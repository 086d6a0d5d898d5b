// The page's texts in the language of the reader. The code has the English text, which is also the
// key of the translation: say`Nothing to undo`, say`Undo: ${what} (key U)`. What stands behind | is
// not shown: it tells two meanings of one word apart, as in say`note|finding`.

/** Languages of the page, as their speakers write them. */
export const LANGUAGES = Object.freeze({en: 'English', de: 'Deutsch'});
/** @typedef {keyof typeof LANGUAGES} Language */
/** @typedef {string | number | bigint} Part  What may stand inside of a text. */

/**
 * The languages' texts. A part has its number in braces: {'Undo: {0} (key U)': '...'}.
 * @type {Partial<Record<Language, () => Promise<{default: Record<string, string>}>>>}
 */
export const CATALOGS = {de: () => import('./de.js')};
const KEPT = 'pxpl5-language';
/**
 * With ?lang=marked, brackets stand around each text, but not around its parts. A test finds what
 * has no brackets.
 */
const MARKED = 'marked';
const isMarked = asked() === MARKED;

/** @returns {string | null} the language that the address asks for */
function asked() {
  return typeof location === 'undefined' ? null
    : new URLSearchParams(location.search).get('lang');
}

/** @returns {string | null} the language that the user chose */
function kept() {
  try {
    return typeof localStorage === 'undefined' ? null : localStorage.getItem(KEPT);
  } catch {
    return null;  // Without storage each visit begins with the browser's language.
  }
}

/** As the address says, as the user chose, or as the browser prefers. */
const wanted = (() => {
  const preferred = typeof document === 'undefined' ? [] : navigator.languages;
  const known = [asked(), kept(), ...preferred].map(code => code?.toLowerCase().split('-')[0])
    .find(code => code !== undefined && Object.hasOwn(LANGUAGES, code));
  return /** @type {Language} */ (isMarked ? 'en' : known ?? 'en');
})();

/** Null for English, and if the texts cannot be loaded. */
const loaded = await CATALOGS[wanted]?.().catch(() => null) ?? null;
/** @type {Record<string, string>} */
const catalog = loaded?.default ?? {};

/** The language of the page. @type {Language} */
export const language = loaded ? wanted : 'en';

/**
 * The key of a template: parts are numbered, and a line break with the spaces around it is one
 * space.
 * @param {readonly string[]} strings
 */
export function keyOf(strings) {
  return strings.map((text, index) => index === 0 ? text : `{${index - 1}}${text}`).join('')
    .replace(/\s*\n\s*/g, ' ');
}

/** @type {WeakMap<TemplateStringsArray, string>} */
const texts = new WeakMap();

/**
 * A text of the page. Not for command lines, names and other data.
 * @param {TemplateStringsArray} strings
 * @param {...Part} parts  Shown as they are. One full stop is enough behind a part that is itself a
 *     sentence, as most errors.
 */
export function say(strings, ...parts) {
  let text = texts.get(strings);
  if (text === undefined) {
    const key = keyOf(strings);
    text = translated(key);
    texts.set(strings, text);
  }
  return parts.length === 0 ? text
    : text.replace(/\{(\d+)\}(\.?)/g, (_, index, stop) => {
      const part = String(parts[Number(index)]);
      return part.endsWith('.') ? part : part + stop;
    });
}

/** @param {string} key */
function translated(key) {
  const text = Object.hasOwn(catalog, key) ? catalog[key] : key.replace(/\|.*$/, '');
  return isMarked ? `⟦${text.replace(/\{\d+\}/g, '⟧$&⟦')}⟧` : text;
}

/**
 * The text for one, or for another number: plural(n, say`1 node`, say`${n} nodes`).
 * @param {number} count
 * @param {string} one
 * @param {string} other
 */
export function plural(count, one, other) {
  return count === 1 ? one : other;
}

/** Attributes of index.html that people read or hear. */
const READ = ['aria-label', 'title', 'alt'];

/** Translates what index.html contains, and names the language. */
export function translatePage() {
  document.documentElement.lang = language;
  for (const element of document.body.querySelectorAll('*')) {
    for (const name of READ) {
      const text = element.getAttribute(name);
      if (text) {
        element.setAttribute(name, translated(text));
      }
    }
    for (const node of element.childNodes) {
      const text = node.nodeType === Node.TEXT_NODE ? node.textContent?.trim() : '';
      if (text) {
        node.textContent = translated(text);
      }
    }
  }
}

/**
 * Opens the page again in another language. The server keeps the scene; what only the page has,
 * as measurements, is lost.
 * @param {Language} code
 */
export function changeLanguage(code) {
  const url = new URL(location.href);
  try {
    localStorage.setItem(KEPT, code);
    url.searchParams.delete('lang');  // Else the address would decide at each visit.
  } catch {
    url.searchParams.set('lang', code);
  }
  history.replaceState(history.state, '', url);
  location.reload();
}
