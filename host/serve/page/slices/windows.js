// Windows of gray values, and the colors that they are shown in. Pure functions.
import {say} from '../texts/say.js';

/** @typedef {{window: number, level: number}} Window  Values shown from level - window / 2 on. */
/** @typedef {{first: number, width: number, counts: number[]}} Counts  The histogram's bins. */
/** @typedef {'gray' | 'inverted' | 'hot' | 'viridis'} ColorMap */

/**
 * The usual CT windows, in Hounsfield units.
 * @type {{name: string, title: string, window: number, level: number}[]}
 */
export const CT_WINDOWS = [
  {name: 'Soft tissue', title: say`Soft tissue`, window: 400, level: 40},
  {name: 'Bone', title: say`Bone`, window: 1800, level: 400},
  {name: 'Lung', title: say`Lung`, window: 1500, level: -600},
  {name: 'Brain', title: say`Brain`, window: 80, level: 40},
  {name: 'Liver', title: say`Liver`, window: 150, level: 60},
  {name: 'Mediastinum', title: say`Mediastinum`, window: 350, level: 50},
];

const MOST_WINDOWS = 4;         // Of the file, as buttons.
const UPTAKES = [5, 10];        // Upper ends of windows of PET, in g/ml.

/**
 * Upper ends of windows in standardized uptake values, if these are known.
 * @param {{suv_per_value: number}} volume
 */
export function uptakesOf({suv_per_value: each}) {
  return each > 0 ? UPTAKES : [];
}

/**
 * The windows that belong to this scan: those of its file, and for PET with known standardized
 * uptake values (SUV) two of these.
 * @param {{windows: {name: string, window: number, level: number}[], suv_per_value: number}} volume
 * @returns {{name: string, window: number, level: number}[]}
 */
export function ownWindows({windows, suv_per_value: each}) {
  const uptakes = uptakesOf({suv_per_value: each}).map(most =>
    ({name: say`SUV 0 to ${most}`, window: most / each, level: most / 2 / each}));
  return [...uptakes, ...windows.slice(0, MOST_WINDOWS).map(({name, window, level}, k) =>
    ({name: name || (k > 0 ? say`File ${k + 1}` : say`File`), window, level}))];
}

/**
 * Whether values are Hounsfield units: as the file states, or, as many formats state no modality,
 * as air and bone suggest. This decides a first window and nothing else.
 * @param {{modality: string, minimum: number, maximum: number}} volume
 */
export function isHounsfield({modality, minimum, maximum}) {
  return modality === 'CT' || modality === '' && minimum <= -500 && minimum >= -4096 &&
    maximum >= 300 && maximum <= 32767;
}

/**
 * The initial window of a volume, as for pictures of slices at the prompt: SUV from 0 to 10, else
 * the first window of the file, else soft tissue for CT, else most values.
 * @param {{modality: string, minimum: number, maximum: number, suv_per_value: number,
 *   windows: {name: string, window: number, level: number}[]}} volume
 * @param {Counts | null} counts  The histogram; null if it is not known.
 * @returns {Window}
 */
export function firstWindow(volume, counts) {
  const own = ownWindows(volume), first = own[volume.suv_per_value > 0 ? 1 : 0];
  return first ? {window: first.window, level: first.level}
    : isHounsfield(volume) ? {window: CT_WINDOWS[0].window, level: CT_WINDOWS[0].level}
    : counts ? mostValues(counts) : allValues(volume);
}

/**
 * A window from the smallest value to the largest value.
 * @param {{minimum: number, maximum: number}} volume
 * @returns {Window}
 */
export function allValues({minimum, maximum}) {
  return {window: maximum - minimum || 1, level: (minimum + maximum) / 2};
}

const LOW = 0.02, HIGH = 0.98;  // Shares of the voxels below the ends of mostValues().

/**
 * A window that leaves out the lowest and the highest 2 % of the voxels: single bright vessels or
 * metal do not make the rest dark. Voxels of the lowest bin that hold more than half of the volume,
 * as the air around a patient does, are not counted.
 * @param {Counts} counts
 * @returns {Window}
 */
export function mostValues({first, width, counts}) {
  const all = counts.reduce((sum, count) => sum + count, 0);
  const [lowest = 0] = counts;
  const counted = lowest > all / 2 && lowest < all ? [0, ...counts.slice(1)] : counts;
  const low = valueAbove(counted, LOW), high = valueAbove(counted, HIGH);
  return {window: (high - low) * width || width || 1,
    level: first + (low + high) / 2 * width};
}

/**
 * Where the share of the counts is below, in bins, interpolated linearly within a bin.
 * @param {number[]} counts
 * @param {number} share
 */
function valueAbove(counts, share) {
  let left = share * counts.reduce((sum, count) => sum + count, 0);
  for (const [bin, count] of counts.entries()) {
    if (left <= count && count > 0) {
      return bin + left / count;
    }
    left -= count;
  }
  return counts.length;
}

/** Colors between which a map interpolates, evenly spaced from the lowest value on. */
const STOPS = {
  gray: [[0, 0, 0], [255, 255, 255]],
  inverted: [[255, 255, 255], [0, 0, 0]],
  // The palette "Hot Iron" of DICOM PS3.6, annex B: red, then green, then blue rise.
  hot: [[0, 0, 0], [128, 0, 0], [255, 0, 0], [255, 128, 0], [255, 255, 255]],
  // Viridis by van der Walt and Smith (CC0): rises evenly, also for color-blind eyes.
  viridis: [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]],
};

/**
 * The names of the maps, with their titles.
 * @type {Record<ColorMap, string>}
 */
export const COLOR_MAPS = {gray: say`gray`, inverted: say`gray, inverted`, hot: say`hot iron`,
  viridis: 'viridis'};

const LEVELS = 256;
/** @type {Map<ColorMap, Uint8Array>} */
const tables = new Map();

/**
 * Red, green and blue of each of 256 levels.
 * @param {ColorMap} map
 */
function tableOf(map) {
  let table = tables.get(map);
  if (!table) {
    const stops = STOPS[map];
    table = new Uint8Array(3 * LEVELS);
    for (let level = 0; level < LEVELS; ++level) {
      const at = level / (LEVELS - 1) * (stops.length - 1);
      const k = Math.min(Math.floor(at), stops.length - 2);
      for (let part = 0; part < 3; ++part) {
        table[3 * level + part] =
          Math.round(stops[k][part] + (at - k) * (stops[k + 1][part] - stops[k][part]));
      }
    }
    tables.set(map, table);
  }
  return table;
}

/**
 * Writes values into RGBA pixels.
 * @param {ArrayLike<number>} values
 * @param {Window} through
 * @param {Uint8ClampedArray} rgba  4 * values.length
 * @param {ColorMap} [map]
 */
export function paintValues(values, {window, level}, rgba, map = 'gray') {
  const table = tableOf(map);
  const slope = (LEVELS - 1) / Math.max(window, Number.MIN_VALUE);
  const first = level - window / 2;
  for (let i = 0, out = 0; i < values.length; ++i, out += 4) {
    const shown = Math.min(Math.max(Math.round((values[i] - first) * slope), 0), LEVELS - 1);
    rgba[out] = table[3 * shown];
    rgba[out + 1] = table[3 * shown + 1];
    rgba[out + 2] = table[3 * shown + 2];
    rgba[out + 3] = 255;
  }
}
