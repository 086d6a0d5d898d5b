// Projects patient positions into the picture. Pure functions; 4 x 4 matrices, column-major.

/** @typedef {import('../link/types.js').Triple} Triple */

/**
 * m . (p, 1)
 * @param {number[]} m
 * @param {Triple} p
 * @returns {[number, number, number, number]}
 */
export function transform(m, p) {
  const row = (/** @type {number} */ r) =>
    m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
  return [row(0), row(1), row(2), row(3)];
}

/**
 * @param {number[]} patientToClip
 * @param {Triple} p_mm
 * @param {number} width   Width of the displayed picture, any unit; x and y have the same.
 * @param {number} height
 * @returns {{x: number, y: number, visible: boolean}} y down; visible: inside the picture
 */
export function projectToPicture(patientToClip, p_mm, width, height) {
  const [x, y, , w] = transform(patientToClip, p_mm);
  if (w <= 0) {
    return {x: 0, y: 0, visible: false};
  }
  return {
    x: (x / w + 1) / 2 * width,
    y: (1 - y / w) / 2 * height,
    visible: Math.abs(x) <= w && Math.abs(y) <= w,
  };
}

/**
 * A direction of the patient as the viewer sees it: right, up, towards the viewer.
 * @param {number[]} patientToEye
 * @param {Triple} direction
 * @returns {Triple}
 */
export function toEye(patientToEye, direction) {
  const row = (/** @type {number} */ r) => patientToEye[r] * direction[0]
    + patientToEye[4 + r] * direction[1] + patientToEye[8 + r] * direction[2];
  return [row(0), row(1), row(2)];
}

/** The patient's sides: letter, direction (LPS), the named view from there. */
export const SIDES = /** @type {{letter: string, towards: Triple, view: string}[]} */ ([
  {letter: 'A', towards: [0, -1, 0], view: 'anterior'},
  {letter: 'P', towards: [0, 1, 0], view: 'posterior'},
  {letter: 'L', towards: [1, 0, 0], view: 'left'},
  {letter: 'R', towards: [-1, 0, 0], view: 'right'},
  {letter: 'S', towards: [0, 0, 1], view: 'superior'},
  {letter: 'I', towards: [0, 0, -1], view: 'inferior'},
]);

const NEGLIGIBLE = 0.25;  // Share of a unit vector: 14 degrees off an axis.

/**
 * Letters for a direction on the screen, the nearest axis first, as radiologists write: 'L', 'LA'.
 * @param {number[]} patientToEye
 * @param {[number, number]} onScreen  Right, up; a unit vector.
 */
export function lettersTowards(patientToEye, onScreen) {
  return SIDES
    .map(({letter, towards}) => {
      const [right, up] = toEye(patientToEye, towards);
      return {letter, share: right * onScreen[0] + up * onScreen[1]};
    })
    .filter(({share}) => share > NEGLIGIBLE)
    .sort((a, b) => b.share - a.share)
    .slice(0, 2)
    .map(({letter}) => letter)
    .join('');
}

/**
 * The longest of 1, 2, 5, 10, ... millimeters that is at most `most_mm`.
 * @param {number} most_mm  > 0.
 */
export function roundLength(most_mm) {
  const power = 10 ** Math.floor(Math.log10(most_mm));
  return [5, 2].map(each => each * power).find(each => each <= most_mm) ?? power;
}

/**
 * Millimeters per place of the picture, at the distance of a point.
 * @param {number[]} patientToEye
 * @param {number[]} patientToClip
 * @param {number} height  Height of the picture, places.
 * @param {Triple} p_mm
 */
export function mmPerPlace(patientToEye, patientToClip, height, p_mm) {
  const magnification = Math.hypot(patientToClip[1], patientToClip[5], patientToClip[9]);
  const depth = -transform(patientToEye, p_mm)[2];
  return 2 * depth / (magnification * height);
}
