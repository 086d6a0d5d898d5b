// Command lines: how words are quoted, and which setting a line makes. Pure functions.

/**
 * A word as the command line takes it: quoted if it has blanks, quotes, '=' or '#'. There is no
 * escape; a double quote stands in single ones.
 * @param {string} text
 */
export function word(text) {
  if (/^[^\s"'=#]+$/.test(text)) {
    return text;
  }
  const parts = text.split(/("+)/).filter(part => part !== '');
  return parts.map(part => part.startsWith('"') ? `'${part}'` : `"${part}"`).join('') || '""';
}

/**
 * How many words say what is set, of each command that sets.
 * host/commands/command_tables.cpp has them.
 */
export const SUBJECT_WORDS = new Map([
  ['surface', 1], ['components', 1], ['view', 0], ['light', 1], ['material', 0], ['background', 0],
  ['clip', 1], ['tint', 0], ['antialias', 0], ['overlay', 0], ['size', 0],
]);

/**
 * What a line sets, as the server sees it (subject_of() in host/commands/commands.cpp).
 * If two lines have one subject, the later line replaces the earlier one. Returns '' if the
 * line is no setting.
 * @param {string} line
 */
export function subjectOf(line) {
  const bare = (/** @type {string} */ text) => text.replace(/"([^"]*)"|'([^']*)'/g, '$1$2');
  /** @type {string[]} */
  const words = [];
  /** @type {string[]} */
  const keys = [];
  for (const text of line.match(/(?:[^\s"']|"[^"]*"|'[^']*')+/g) ?? []) {
    if (text === '#') {
      break;  // A comment follows.
    }
    const key = bare(/^((?:[^"'=]|"[^"]*"|'[^']*')+)=/.exec(text)?.[1] ?? '');
    const isOption = words.length > 0 && key !== '';
    (isOption ? keys : words).push(isOption ? key : bare(text));
  }
  const [name = '', ...rest] = words;
  const named = SUBJECT_WORDS.get(name);
  // Taking away, and what depends on the picture, is done each time.
  if (named === undefined || rest.at(-1) === 'off' || keys.includes('at')) {
    return '';
  }
  return JSON.stringify([name, ...rest.map((each, k) => k < named ? each : '*'), keys.sort()]);
}

/**
 * A number as a command takes it: short, never in exponent notation.
 * @param {number} value
 * @param {number} digits  After the point, at most.
 */
export function plain(value, digits = 2) {
  const text = value.toFixed(digits);
  const short = text.includes('.') ? text.replace(/\.?0+$/, '') : text;
  return short === '-0' ? '0' : short;
}

const WHOLE_RANGE = 64;  // Values over a wider range are taken for whole numbers.

/**
 * An isovalue as a person would choose it: of whole numbers a half between two, so that no voxel
 * has it; else with as many digits as tell a thousandth of the range.
 * @param {number} value
 * @param {{minimum: number, maximum: number}} volume
 */
export function roundIso(value, {minimum, maximum}) {
  const range = maximum - minimum;
  if (range >= WHOLE_RANGE) {
    return Math.floor(value) + 0.5;
  }
  const digits = Math.max(0, Math.ceil(3 - Math.log10(range || 1)));
  return Number(value.toFixed(digits));
}

/**
 * @param {string} surface
 * @param {number} value
 */
export function isoLine(surface, value) {
  return `surface ${word(surface)} iso=${plain(value, 9)}`;
}
