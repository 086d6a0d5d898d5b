// The help sheet: gestures, keys, panels and surfaces.
import {h} from '../elements/dom.js';

const SHEET = /** @type {const} */ ([
  ['Picture', [
    ['Drag', 'rotate'], ['Right button, Shift', 'move'], ['Wheel, pinch', 'zoom'],
    ['Double click', 'reset the view'], ['Click', 'move the crosshair in all views'],
    ['Two fingers', 'move, zoom and roll'],
  ]],
  ['Keys', [
    ['← ↑ → ↓', 'rotate; with Shift: move'], ['+  −', 'zoom'],
    ['1 … 6', 'view from A, P, L, R, S, I'], ['R', 'reset the view'], ['U, Ctrl Z', 'undo'],
    ['Shift U, Ctrl Shift Z', 'redo'], ['O', 'open a volume'], ['S', 'save'],
    ['7 8 9 0', 'picture; picture and slices; two by two; slices'],
    [', .', 'hide or show the left or right side'], ['F', 'full screen'],
    ['Esc', 'leave a mode'], ['?', 'show this help'],
  ]],
  ['Panels', [
    ['Slices', 'click to move the crosshair; the wheel steps, with Ctrl it zooms'],
    ['+  −  0 on a slice', 'zoom; 0 shows the whole slice'],
    ['Middle button, two fingers', 'move a zoomed slice'],
    ['Slices, Window', 'drag across for contrast, down for brightness'],
    ['Measure', 'click points: distance, angle, path; in slices also regions'],
    ['Inspect', 'click a pixel to explain its color'],
  ]],
  ['Surfaces', [
    ['Drag a handle of the histogram', 'change the isovalue; slower with Shift'],
    ['Arrow keys on a handle', 'change the isovalue; ten times faster with Shift'],
    ['Pick tissue', 'take the value from the picture or a slice'],
    ['Parts', 'draw only the largest part, or the part that you click'],
    ['Clip planes', 'remove one side of a plane to see inside'],
  ]],
]);

/**
 * @param {HTMLElement} headset  What there is to say about a headset.
 * @returns {() => void} shows the sheet
 */
export function createHelp(headset) {
  const dialog = h('dialog', {id: 'help', 'aria-labeledby': 'help-title',
    'data-testid': 'help-sheet'},
    h('div', {class: 'row spread'}, h('h2', {id: 'help-title'}, 'Help'),
      h('button', {class: 'quiet icon', 'aria-label': 'Close',
        onclick: () => dialog.close()}, '×')),
    h('p', {class: 'muted'}, 'The emulated Pixel-Planes 5 draws every picture. Its Graphics '
      + 'Processors extract the surfaces, and its Renderers draw them. Pictures are compressed '
      + 'during interaction, and lossless and refined at rest.'),
    h('div', {class: 'sheet'}, ...SHEET.map(([title, rows]) => h('section', {}, h('h3', {}, title),
      h('dl', {}, ...rows.flatMap(([key, what]) => [h('dt', {}, key), h('dd', {}, what)]))))));
  dialog.querySelector('.sheet section:last-child')?.before(headset);  // Beside the panels.
  dialog.addEventListener('click', event => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  document.body.append(dialog);
  return () => dialog.showModal();
}
