// The one way to write numbers on the page: commas between groups of three digits, a point before
// the fraction. Command lines have none of this; they use plain() of link/lines.js.

/**
 * @param {number | bigint} value
 * @param {Intl.NumberFormatOptions} options
 */
function written(value, options) {
  const text = new Intl.NumberFormat('en', options).format(value);
  return /[1-9∞N]/.test(text) ? text : text.replace('-', '');  // No "-0".
}

/**
 * "48,884", "1,213.3": with exactly so many digits after the point.
 * @param {number | bigint} value
 * @param {number} [digits]
 */
export function grouped(value, digits = 0) {
  return written(value, {minimumFractionDigits: digits, maximumFractionDigits: digits});
}

/**
 * "250.5", "1,000": with at most so many digits after the point.
 * @param {number} value
 * @param {number} [digits]
 */
export function short(value, digits = 2) {
  return written(value, {maximumFractionDigits: digits});
}

/**
 * "0.0125", "1,230": rounded to so many significant digits.
 * @param {number} value
 * @param {number} digits
 */
export function significant(value, digits) {
  return written(Number(value.toPrecision(digits)), {maximumFractionDigits: 20});
}

/**
 * A text of the command line as the page writes it: "42900 triangles, 12 mm2" becomes
 * "42,900 triangles, 12 mm²". Words and paths with digits stay.
 * @param {string} text
 */
export function rewritten(text) {
  return text.replace(/(?<![\w.,/-])(-?)(\d{4,})(?=[.,;:)]?(\s|$)|\.\d)/g,
    (_, sign, digits) => sign + grouped(BigInt(digits)))
    .replace(/(?<=\d [mck]?m)([23])\b/g, (_, power) => power === '2' ? '²' : '³');
}

/**
 * A duration: "0.42 ms", "125 ms", "1.84 s".
 * @param {number} ms
 */
export function duration(ms) {
  // Rounds first, so that 999.9 ms becomes 1 s.
  const rounded = Number(ms.toPrecision(3));
  return rounded < 1000 ? `${significant(ms, 3)} ms` : `${significant(ms / 1000, 3)} s`;
}

/** @param {number} share  0..1 */
export function percent(share) {
  return `${grouped(100 * share)} %`;
}
