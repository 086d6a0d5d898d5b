// Icons: lines on a square of 16 x 16.
import {s} from './dom.js';

const PATHS = {
  undo: 'M6 3 2.5 6.5 6 10M2.5 6.5H10a3.5 3.5 0 0 1 0 7H6',
  redo: 'M10 3l3.5 3.5L10 10M13.5 6.5H6a3.5 3.5 0 0 0 0 7h4',
  open: 'M2 12.5v-9h4l1.5 2H14v7zM2 7.5h12',
  save: 'M8 2.5v7.5M5 7l3 3.2L11 7M2.5 10.5v3h11v-3',
  close: 'M4 4l8 8M12 4l-8 8',
  picture: 'M8 1.8l5.4 3.1v6.2L8 14.2l-5.4-3.1V4.9zM2.6 4.9 8 8l5.4-3.1M8 8v6.2',
  beside: 'M2 3h12v10H2zM10 3v10M10 6.3h4M10 9.7h4',
  four: 'M2 3h12v10H2zM8 3v10M2 8h12',
  slices: 'M8 2l6 3-6 3-6-3zM2 8l6 3 6-3M2 11l6 3 6-3',
  left: 'M2 3h12v10H2zM6 3v10M3.5 5.5h1M3.5 8h1',
  right: 'M2 3h12v10H2zM10 3v10M11.5 5.5h1M11.5 8h1',
  full: 'M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4',
  window: 'M6 2v4H2M10 2v4h4M14 10h-4v4M2 10h4v4',
  surfaces: 'M2 13.5h12M3 13.5v-4M5.5 13.5v-8M8 13.5v-5M10.5 13.5v-9M13 13.5v-3',
  planes: 'M2 2.5h12v11H2zM8 2.5v3.5M8 10v3.5M2 8h4M10 8h4',
  ruler: 'M1.5 10.5l9-9 4 4-9 9zM4 8l1.6 1.6M6.3 5.7l2.2 2.2M8.6 3.4l1.6 1.6',
  lens: 'M6.8 2.2a4.6 4.6 0 1 0 0 9.2 4.6 4.6 0 0 0 0-9.2zM10.1 10.1l4 4M5 6.8h3.6M6.8 5v3.6',
  ring: 'M8 3.2a4.8 4.8 0 1 0 0 9.6 4.8 4.8 0 0 0 0-9.6zM6.6 3.2a1.4 1.4 0 1 1 2.8 0 1.4 1.4 0 0 1'
    + '-2.8 0zM2.4 10.4a1.4 1.4 0 1 1 2.8 0 1.4 1.4 0 0 1-2.8 0zM10.8 10.4a1.4 1.4 0 1 1 2.8 0 1.4'
    + ' 1.4 0 0 1-2.8 0z',
  report: 'M3 1.8h6.8L13 5v9.2H3zM9.8 1.8V5H13M5.5 7.8h5M5.5 10.8h5',
  play: 'M4.5 2.8 13 8l-8.5 5.2z',
  pause: 'M5 3v10M11 3v10',
  back: 'M11.5 3 5 8l6.5 5zM3.8 3v10',
  on: 'M4.5 3 11 8l-6.5 5zM12.2 3v10',
  view: 'M2 4h6.5M12.5 4H14M2 8h1.5M7.5 8H14M2 12h6.5M12.5 12H14'
    + 'M10.5 2.4v3.2M5.5 6.4v3.2M10.5 10.4v3.2',
};

/** @typedef {keyof typeof PATHS} IconName */

/**
 * Decoration: the control around it has the name.
 * @param {IconName} name
 */
export function icon(name) {
  return s('svg', {class: 'glyph', viewBox: '0 0 16 16', 'aria-hidden': 'true'},
    s('path', {d: PATHS[name]}));
}

/**
 * Replaces the icon of a control.
 * @param {Element} control
 * @param {IconName} name
 */
export function setIcon(control, name) {
  control.querySelector('path')?.setAttribute('d', PATHS[name]);
}
