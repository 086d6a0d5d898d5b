// The help sheet: gestures, keys, panels and surfaces.
import {h} from '../elements/dom.js';

/**
 * What is pressed or moved, what it does, and, for keys, their names as in KeyboardEvent.key. A
 * test presses all keys and compares the ones that do something with these names.
 * @typedef {[shown: string, what: string, keys?: string]} Row
 */

/** @type {[title: string, rows: Row[]][]} */
const SHEET = [
  ['Picture', [
    ['Drag', 'rotate'], ['Right or middle button, Shift', 'drag to move'],
    ['Wheel, pinch', 'zoom'], ['Two fingers', 'move, zoom and roll'],
    ['Click', 'move the crosshair in all views; in a mode: set a point'],
    ['Double click', 'reset the view, outside of a mode'],
  ]],
  ['Keys', [
    ['← ↑ → ↓', 'rotate; with Shift: move', 'ArrowLeft ArrowUp ArrowRight ArrowDown '
      + 'Shift+ArrowLeft Shift+ArrowUp Shift+ArrowRight Shift+ArrowDown'],
    ['+  =  −', 'zoom', '+ = -'], ['1 … 6', 'view from A, P, L, R, S, I', '1 2 3 4 5 6'],
    ['R', 'reset the view', 'r'], ['U, Ctrl Z', 'undo', 'u Control+z'],
    ['Shift U, Ctrl Shift Z, Ctrl Y', 'redo', 'Shift+U Control+Shift+Z Control+y Control+Shift+Y'],
    ['O', 'open a volume', 'o'], ['S', 'save', 's'], ['T', 'start the tour', 't'],
    ['7 8 9 0', 'picture; picture and slices; two by two; slices', '7 8 9 0'],
    [', .', 'hide or show the left or right side', ', .'], ['F', 'full screen', 'f'],
    ['Esc', 'leave a mode, or close the tour', 'Escape Shift+Escape'], ['?', 'show this help', '?'],
  ]],
  ['Panels', [
    ['Slices', 'click or drag to move the crosshair; the wheel steps, with Ctrl it zooms'],
    ['Middle button, two fingers', 'move a zoomed slice'],
    ['Right button, Shift', 'drag across for contrast, down for brightness, as the tool Window'],
    ['Measure', 'click points: distance, angle, path, part, note; in slices also regions. Enter or '
      + 'Esc ends a path'],
    ['Inspect', 'click a pixel to explain its color'],
    ['Machine', 'click a node to see its load, or to kill it'],
  ]],
  ['Keys on a slice', [
    ['← ↑ → ↓', 'move the crosshair', 'ArrowLeft ArrowUp ArrowRight ArrowDown'],
    ['[  ]', 'one slice back, one on', '[ ]'],
    ['Page Up, Page Down', 'five slices', 'PageUp PageDown'],
    ['+  =  −  0', 'zoom; 0 shows the whole slice', '+ = - 0'],
    ['Enter', 'with the tool Measure: set a point at the crosshair'],
  ]],
  ['Surfaces', [
    ['Drag a handle of the histogram', 'change the isovalue; slower with Shift'],
    ['+ − at the histogram, the wheel with Ctrl', 'show fewer or more values; drag an empty place '
      + 'to others'],
    ['Pick tissue', 'take the value from the picture or a slice'],
    ['Parts', 'draw only the largest part, or the part that you click'],
    ['Clip planes', 'remove one side of a plane to see inside'],
    ['Light and material', 'drag a light, or move it with the arrow keys'],
  ]],
  ['Keys on a handle of the histogram', [
    ['← → ↑ ↓', 'change the isovalue; ten times faster with Shift',
      'ArrowLeft ArrowRight ArrowUp ArrowDown'],
    ['Page Up, Page Down', 'ten times faster', 'PageUp PageDown'],
    ['Home, End', 'least and largest value', 'Home End'],
  ]],
  ['Keys on the instructions of a region', [
    ['← →', 'one instruction back, one on', 'ArrowLeft ArrowRight'],
    ['Page Up, Page Down', '256 instructions', 'PageUp PageDown'],
  ]],
];

/**
 * @param {HTMLElement} headset  What there is to say about a headset.
 * @param {() => void} tour
 * @returns {() => void} shows the sheet
 */
export function createHelp(headset, tour) {
  const dialog = h('dialog', {id: 'help', 'aria-labelledby': 'help-title',
    'data-testid': 'help-sheet'},
    h('div', {class: 'row spread'}, h('h2', {id: 'help-title'}, 'Help'),
      h('button', {class: 'quiet icon', 'aria-label': 'Close',
        onclick: () => dialog.close()}, '×')),
    h('p', {class: 'muted'}, 'The emulated Pixel-Planes 5 draws every picture. Its Graphics '
      + 'Processors extract the surfaces, and its Renderers draw them. Pictures are compressed '
      + 'during interaction, and lossless and refined at rest. ',
    h('button', {'data-testid': 'help-tour', onclick: () => {
      dialog.close();
      tour();
    }}, 'Tour of the machine')),
    h('div', {class: 'sheet'}, ...SHEET.map(([title, rows]) => h('section', {}, h('h3', {}, title),
      h('dl', {}, ...rows.flatMap(([key, what, keys]) => [h('dt', {'data-keys': keys}, key),
        h('dd', {}, what)]))))));
  dialog.querySelector('.sheet')?.append(headset);
  dialog.addEventListener('click', event => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  document.body.append(dialog);
  return () => dialog.showModal();
}
