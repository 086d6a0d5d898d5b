// Bands of usual CT values behind the histogram, with their names.
import {s} from '../elements/dom.js';
import {short} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/**
 * Usual values of healthy tissue without contrast medium, in Hounsfield units: Buzug, Computed
 * Tomography (Springer, 2008), p. 475. Soft tissue goes from the kidney to the liver. No end is
 * stated for compact bone.
 * @type {{name: string, label: string, what: string, low: number, high: number}[]}
 */
export const TISSUES = [
  {name: 'Lung', label: say`Lung`, what: say`lung`, low: -950, high: -550},
  {name: 'Fat', label: say`Fat`, what: say`fat`, low: -100, high: -50},
  {name: 'Soft tissue', label: say`Soft tissue`, what: say`soft tissue`, low: 20, high: 70},
  {name: 'Bone', label: say`Bone`, what: say`compact bone`, low: 250, high: Infinity},
];

/**
 * Whether the values are or may be Hounsfield units: CT, or a file without a modality and with
 * values from well below water to well above.
 * @param {{modality: string, minimum: number, maximum: number}} volume
 */
export function mayBeHounsfield({modality, minimum, maximum}) {
  return modality === 'CT' || modality === '' && minimum <= -200 && maximum >= 200;
}

/**
 * Draws a band for each tissue whose values are shown. A name that does not fit into its band is
 * only in the tooltip.
 * @param {SVGGElement} group  For the bands.
 * @param {SVGGElement} names  For their names, over the outline.
 * @param {import('./axis.js').Scale} scale
 * @param {number} top     Pixels.
 * @param {number} base    Pixels.
 * @param {number} letter  Width of a usual letter, pixels.
 * @param {boolean} isCt   Whether the file says that the values are of CT.
 */
export function drawBands(group, names, scale, top, base, letter, isCt) {
  const bands = TISSUES.filter(({low, high}) => high > scale.low && low < scale.high)
    .map(tissue => {
      const x = scale.at(Math.max(tissue.low, scale.low));
      return {...tissue, x, width: scale.at(Math.min(tissue.high, scale.high)) - x};
    });
  group.replaceChildren(...bands.map(({name, what, low, high, x, width}) => {
    const range = high === Infinity ? say`${short(low)} HU or more`
      : say`${short(low)} to ${short(high)} HU`;
    return s('g', {class: 'band', 'data-testid': `band-${name}`},
      s('title', {}, isCt ? say`Usual values of ${what} without contrast medium: ${range}`
        : say`Usual values of ${what} without contrast medium: ${range}. The file does not say
          that its values are of CT.`),
      s('rect', {x, y: top, width, height: base - top}));
  }));
  names.replaceChildren(...bands.filter(({label, width}) => width > letter * label.length)
    .map(({name, label, x, width}) => s('text', {class: 'band-name',
      'data-testid': `band-name-${name}`, x: x + width / 2, y: top + 2 * letter,
      'text-anchor': 'middle'}, label)));
}
