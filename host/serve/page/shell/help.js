// The help sheet: gestures, keys, panels and surfaces.
import {closeBeside} from '../elements/dialog.js';
import {h} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {createLanguage} from './language.js';

/**
 * What is pressed or moved, what it does, and, for keys, their names as in KeyboardEvent.key. A
 * test presses all keys and compares the ones that do something with these names.
 * @typedef {[shown: string, what: string, keys?: string]} Row
 */

/** @type {[title: string, rows: Row[]][]} */
const SHEET = [
  [say`Picture`, [
    [say`Drag`, say`rotate`], [say`Right or middle button, Shift`, say`drag to move`],
    [say`Wheel, pinch`, say`zoom`], [say`Two fingers`, say`move, zoom and roll`],
    [say`Click`, say`move the crosshair in all views; in a mode: set a point`],
    [say`Double click`, say`reset the view, outside of a mode`],
  ]],
  [say`Keys`, [
    ['← ↑ → ↓', say`rotate; with Shift: move`, 'ArrowLeft ArrowUp ArrowRight ArrowDown '
      + 'Shift+ArrowLeft Shift+ArrowUp Shift+ArrowRight Shift+ArrowDown'],
    ['+  =  −', say`zoom`, '+ = -'], ['1 … 6', say`view from A, P, L, R, S, I`, '1 2 3 4 5 6'],
    ['R', say`reset the view`, 'r'], [say`U, Ctrl Z`, say`undo`, 'u Control+z'],
    [say`Shift U, Ctrl Shift Z, Ctrl Y`, say`redo`,
      'Shift+U Control+Shift+Z Control+y Control+Shift+Y'],
    ['O', say`open a volume`, 'o'], ['S', say`save`, 's'], ['T', say`start the tour`, 't'],
    ['7 8 9 0', say`picture; picture and slices; two by two; slices`, '7 8 9 0'],
    [', .', say`hide or show the left or right side`, ', .'], ['F', say`full screen`, 'f'],
    [say`Esc`, say`leave a mode, or close the tour`, 'Escape Shift+Escape'],
    ['?', say`show this help`, '?'],
  ]],
  [say`Panels`, [
    [say`Slices`, say`click or drag to move the crosshair; the wheel steps, with Ctrl it zooms`],
    [say`Middle button, two fingers`, say`move a zoomed slice`],
    [say`Right button, Shift`,
      say`drag across for contrast, down for brightness, as the tool Window`],
    [say`Measure`, say`click points: distance, angle, path, part, note; in slices also regions.
      Enter or Esc ends a path`],
    [say`Inspect`, say`click a pixel to explain its color`],
    [say`Machine`, say`click a node to see its load, or to kill it`],
  ]],
  [say`Keys on a slice`, [
    ['← ↑ → ↓', say`move the crosshair`, 'ArrowLeft ArrowUp ArrowRight ArrowDown'],
    ['[  ]', say`one slice back, one on`, '[ ]'],
    [say`Page Up, Page Down`, say`five slices`, 'PageUp PageDown'],
    ['+  =  −  0', say`zoom; 0 shows the whole slice`, '+ = - 0'],
    [say`Enter`, say`with the tool Measure: set a point at the crosshair`],
  ]],
  [say`Surfaces`, [
    [say`Drag a handle of the histogram`, say`change the isovalue; slower with Shift`],
    [say`+ − at the histogram, the wheel with Ctrl`,
      say`show fewer or more values; drag an empty place to others`],
    [say`Pick tissue`, say`take the value from the picture or a slice`],
    [say`Parts`, say`draw only the largest part, or the part that you click`],
    [say`Clip planes`, say`remove one side of a plane to see inside`],
    [say`Light and material`, say`drag a light, or move it with the arrow keys`],
  ]],
  [say`Keys on a handle of the histogram`, [
    ['← → ↑ ↓', say`change the isovalue; ten times faster with Shift`,
      'ArrowLeft ArrowRight ArrowUp ArrowDown'],
    [say`Page Up, Page Down`, say`ten times faster`, 'PageUp PageDown'],
    [say`Home, End`, say`least and largest value`, 'Home End'],
  ]],
  [say`Keys on the instructions of a region`, [
    ['← →', say`one instruction back, one on`, 'ArrowLeft ArrowRight'],
    [say`Page Up, Page Down`, say`256 instructions`, 'PageUp PageDown'],
  ]],
];

/**
 * @param {import('../panel/app.js').App} app
 * @param {HTMLElement} headset  What there is to say about a headset.
 * @param {() => void} tour
 * @returns {() => void} shows the sheet
 */
export function createHelp(app, headset, tour) {
  const dialog = h('dialog', {id: 'help', 'aria-labelledby': 'help-title',
    'data-testid': 'help-sheet'},
    h('div', {class: 'row spread'}, h('h2', {id: 'help-title'}, say`Help`),
      h('button', {class: 'quiet icon', 'aria-label': say`Close`,
        onclick: () => dialog.close()}, '×')),
    h('p', {class: 'muted'}, `${say`The emulated Pixel-Planes 5 draws every picture. Its Graphics
      Processors extract the surfaces, and its Renderers draw them. Pictures are compressed during
      interaction, and lossless and refined at rest.`} `,
    h('button', {'data-testid': 'help-tour', onclick: () => {
      dialog.close();
      tour();
    }}, say`Tour of the machine`)),
    createLanguage(app),
    h('div', {class: 'sheet'}, ...SHEET.map(([title, rows]) => h('section', {}, h('h3', {}, title),
      h('dl', {}, ...rows.flatMap(([key, what, keys]) => [h('dt', {'data-keys': keys}, key),
        h('dd', {}, what)]))))));
  dialog.querySelector('.sheet')?.append(headset);
  closeBeside(dialog);
  document.body.append(dialog);
  return () => dialog.showModal();
}
