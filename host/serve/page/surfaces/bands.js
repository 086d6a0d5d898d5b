// Bands of usual CT values over the histogram.
import {s} from '../elements/dom.js';
import {short} from '../elements/numbers.js';

/**
 * Usual values of healthy tissue without contrast medium, in Hounsfield units: Buzug, Computed
 * Tomography (Springer, 2008), p. 475. Soft tissue goes from the kidney to the liver. No end is
 * stated for compact bone.
 * @type {{name: string, what: string, low: number, high: number}[]}
 */
export const TISSUES = [
  {name: 'Lung', what: 'lung', low: -950, high: -550},
  {name: 'Fat', what: 'fat', low: -100, high: -50},
  {name: 'Soft tissue', what: 'soft tissue', low: 20, high: 70},
  {name: 'Bone', what: 'compact bone', low: 250, high: Infinity},
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
 * @param {SVGGElement} group
 * @param {import('./axis.js').Scale} scale
 * @param {number} top     Pixels.
 * @param {number} base    Pixels.
 * @param {number} letter  Width of a usual letter, pixels.
 * @param {boolean} isCt    Whether the file says that the values are of CT.
 */
export function drawBands(group, scale, top, base, letter, isCt) {
  group.replaceChildren(...TISSUES.filter(({low, high}) => high > scale.low && low < scale.high)
    .map(({name, what, low, high}) => {
      const left = scale.at(Math.max(low, scale.low));
      const width = scale.at(Math.min(high, scale.high)) - left;
      const range = high === Infinity ? `${short(low)} HU or more`
        : `${short(low)} to ${short(high)} HU`;
      const band = s('g', {class: 'band', 'data-testid': `band-${name}`},
        s('title', {}, `Usual values of ${what} without contrast medium: ${range}`
          + (isCt ? '' : '. The file does not say that its values are of CT.')),
        s('rect', {x: left, y: top, width, height: base - top}));
      if (width > letter * name.length) {
        band.append(s('text', {x: left + width / 2, y: base - letter / 2,
          'text-anchor': 'middle'}, name));
      }
      return band;
    }));
}
