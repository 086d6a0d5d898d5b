// Saves files in the browser's folder for downloads.
import {h} from './dom.js';

/**
 * Lets the browser save the file at an address.
 * @param {string} href
 * @param {string} name
 */
export function saveAs(href, name) {
  const link = h('a', {href, download: name});
  document.body.append(link);
  link.click();
  link.remove();
}

/**
 * @param {Blob} blob
 * @param {string} name
 */
export function saveBlob(blob, name) {
  const href = URL.createObjectURL(blob);
  saveAs(href, name);
  URL.revokeObjectURL(href);
}
