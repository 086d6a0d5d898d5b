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

/** Commands whose first word names what is set. */
const NAMED = new Set(['surface', 'light', 'components', 'clip']);

/**
 * What a line sets. Of two lines with one subject, the later makes the earlier needless: they set
 * the same options of the same thing.
 * @param {string} line
 */
export function subjectOf(line) {
  const words = line.match(/(?:[^\s"']|"[^"]*"|'[^']*')+/g) ?? [];
  const keys = words.filter(each => /^\w+=/.test(each)).map(each => each.split('=')[0]).sort();
  const named = NAMED.has(words[0] ?? '') ? words[1] ?? '' : '';
  return [words[0] ?? '', named, ...keys].join(' ');
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
