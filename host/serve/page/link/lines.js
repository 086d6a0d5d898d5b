// Command lines: quoting, and the subject of a setting. Pure functions.

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
 * A command as the page builds it: its name, its words and its options.
 * @typedef {object} Command
 * @property {string} name
 * @property {(string | number)[]} [words]
 * @property {Record<string, string | number>} [options]
 */

/** @param {Command} command */
export function toLine({name, words = [], options = {}}) {
  return [name, ...words.map(each => word(String(each))),
    ...Object.entries(options).map(([key, value]) => `${key}=${word(String(value))}`)].join(' ');
}

/**
 * The subject of a setting. If two commands have one subject, the later command replaces the
 * earlier command. Returns '' if the command is no setting.
 * @param {Command} command
 * @param {import('./types.js').CommandDescriptor[]} table  The server's table of commands.
 */
export function subjectOf({name, words = [], options = {}}, table) {
  const descriptor = table.find(each => each.name === name);
  const depends = words.at(-1) === 'off' || 'at' in options;
  if (descriptor?.kind !== 'setting' || depends) {
    return '';
  }
  const subject = words.map((each, k) => k < descriptor.subject_words ? String(each) : '*');
  return JSON.stringify([name, ...subject, Object.keys(options).sort()]);
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
 * Sets the isovalue of a surface.
 * @param {string} surface
 * @param {number} value
 * @returns {Command}
 */
export function isoCommand(surface, value) {
  return {name: 'surface', words: [surface], options: {iso: plain(value, 9)}};
}
