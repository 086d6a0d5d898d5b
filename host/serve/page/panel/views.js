// Views beside the picture that can be saved as pictures: the slices.

/**
 * How a view is painted for a file.
 * @typedef {object} Painting
 * @property {number[]} size         Width and height, pixels.
 * @property {string} ground         A color of CSS, 'transparent', or '' for that of the screen.
 * @property {boolean} marks         With letters, crosshair and measurements.
 */

/**
 * @typedef {object} Painted
 * @property {HTMLCanvasElement} canvas
 * @property {number} scale          Pixels per unit of text and lines on the screen.
 * @property {string} caption        What the legend says of it.
 * @property {boolean} hasSurfaces   Whether contours of the surfaces are shown.
 */

/**
 * @typedef {object} View
 * @property {string} name    In names of files.
 * @property {string} title
 * @property {() => number[] | null} size  On the screen, pixels of the screen; null if not shown.
 * @property {(painting: Painting) => Painted} painted
 */

export class Views {
  constructor() {
    /** In the order of the page. @type {View[]} */
    this.list = [];
  }

  /** @param {View} view */
  add(view) {
    this.list.push(view);
  }
}
