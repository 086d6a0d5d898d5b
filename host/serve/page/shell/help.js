// A short sheet: what can be done, and with which keys.
import {h} from '../elements/dom.js';

const SHEET = /** @type {const} */ ([
  ['Picture', [
    ['Drag', 'turn'], ['Right button, shift', 'move'], ['Wheel, pinch', 'zoom'],
    ['Double click', 'reset the view'], ['Click', 'point at a place, in all views'],
    ['Two fingers', 'move, zoom and roll'],
  ]],
  ['Keys', [
    ['← ↑ → ↓', 'turn; with shift move'], ['+  −', 'zoom'], ['1 … 6', 'from A, P, L, R, S, I'],
    ['R', 'reset the view'], ['U, Ctrl Z', 'undo'], ['Shift U, Ctrl shift Z', 'redo'],
    ['O', 'open a volume'], ['S', 'save'], ['Esc', 'end a mode'], ['?', 'this sheet'],
  ]],
  ['Panels', [
    ['Slices, Window', 'drag: across for contrast, down for brightness'],
    ['Measure', 'click two points: how far they are apart'],
    ['Inspect', 'click a pixel: why it has its colour'],
  ]],
  ['Surfaces', [
    ['Drag a handle of the histogram', 'move a surface\'s isovalue; with shift finely'],
    ['Arrow keys on a handle', 'the same, finely; shift: in tens'],
    ['Click on tissue', 'take the value from the picture or a slice'],
    ['Parts', 'draw only the largest piece, or the one that you click on'],
    ['Cut', 'takes away what lies before a plane: see inside'],
  ]],
]);

/** @returns {() => void} shows the sheet */
export function createHelp() {
  const dialog = h('dialog', {id: 'help', 'aria-labelledby': 'help-title',
    'data-testid': 'help-sheet'},
    h('div', {class: 'row spread'}, h('h2', {id: 'help-title'}, 'What you can do here'),
      h('button', {class: 'quiet icon', 'aria-label': 'Close',
        onclick: () => dialog.close()}, '×')),
    h('p', {class: 'muted'}, 'Every picture comes from the emulated Pixel-Planes 5: its Graphics '
      + 'Processors find the surfaces, its Renderers draw them. While something moves, the '
      + 'picture is compressed; at rest it is exact, and refined.'),
    h('div', {class: 'sheet'}, ...SHEET.map(([title, rows]) => h('section', {}, h('h3', {}, title),
      h('dl', {}, ...rows.flatMap(([key, what]) => [h('dt', {}, key), h('dd', {}, what)]))))));
  dialog.addEventListener('click', event => {
    if (event.target === dialog) {
      dialog.close();
    }
  });
  document.body.append(dialog);
  return () => dialog.showModal();
}
