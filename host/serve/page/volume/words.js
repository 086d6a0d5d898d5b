// Sizes, dates and folders of files, as words.
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** The server's folder of dropped files, which tells nothing to a person. */
export const UPLOAD = /\/\S*\/uploads\/\d+-[\w-]+\//;

const UNITS = ['B', 'kB', 'MB', 'GB', 'TB'];

/**
 * "512 bytes", "3.4 MB": two significant digits below 10, else whole.
 * @param {number} bytes
 */
export function sizeText(bytes) {
  const power = bytes < 1 ? 0 : Math.min(UNITS.length - 1, Math.floor(Math.log10(bytes) / 3));
  const value = bytes / 1000 ** power;
  return power === 0 ? say`${grouped(value)} bytes`
    : `${grouped(value, value < 9.95 ? 1 : 0)} ${UNITS[power]}`;
}

/**
 * "2026-11-26", in the time zone of the browser.
 * @param {number} seconds  Since 1970.
 */
export function dateText(seconds) {
  const date = new Date(1000 * seconds);
  return [date.getFullYear(), date.getMonth() + 1, date.getDate()]
    .map(part => String(part).padStart(2, '0')).join('-');
}
