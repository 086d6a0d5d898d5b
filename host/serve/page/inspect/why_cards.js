// The result of `why` as cards: pixel, instructions, triangle, cell.
import {CellView} from './cell_view.js';
import {ENGLISH, h} from '../elements/dom.js';
import {grouped, short} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {import('./cell_view.js').Cell} Cell */
/** @typedef {{surface_field: number, z: number, normal: number[], rgb: number}} PixelState */
/** @typedef {{at: number, instruction: string, before: PixelState, after: PixelState}} Write */

/**
 * @typedef {object} Visit              A primitive that covers the pixel.
 * @property {string} address
 * @property {number} gp
 * @property {number} surface
 * @property {number} slab
 * @property {boolean} stored
 * @property {boolean} shut_out
 * @property {number} [z]
 * @property {PixelState} before
 * @property {Write[]} writes
 * @property {Cell} [cell]
 */

/**
 * @typedef {object} Why                The fields of `why`.
 * @property {string} sentence
 * @property {number} x
 * @property {number} y
 * @property {number} region
 * @property {number} renderer
 * @property {{isovalue?: number, color: number[], table?: string}[]} surfaces
 * @property {number} primitives_in_region
 * @property {Visit[]} visits
 * @property {number} [shown]           Index of the visit that the pixel shows.
 * @property {Write[]} prologue
 * @property {Write[]} doors            Writes of stipple masks that hide the pixel.
 * @property {Write[]} end_of_region
 * @property {number} color            Red in the low byte.
 */

const MOST_WRITES = 12;
const MOST_VISITS = 16;

/**
 * @param {number} rgb  Red in the low byte.
 */
function colorText(rgb) {
  return '#' + [0, 8, 16].map(shift =>
    (rgb >> shift & 255).toString(16).padStart(2, '0')).join('');
}

/** @param {number[]} parts  0..255 */
function colorOf(parts) {
  return `rgb(${parts.join(',')})`;
}

/**
 * The fields that an instruction changed, as text.
 * @param {Write} write
 */
function changeText({before, after}) {
  /** @type {[string, string, string][]} */
  const fields = [[say`surface`, String(before.surface_field), String(after.surface_field)],
    [say`depth`, grouped(before.z), grouped(after.z)],
    [say`normal`, `(${before.normal.join(', ')})`, `(${after.normal.join(', ')})`],
    [say`color`, colorText(before.rgb), colorText(after.rgb)]];
  return fields.filter(([, a, b]) => a !== b).map(([name, a, b]) => `${name} ${a} → ${b}`)
    .join(', ') || say`no change`;
}

/**
 * @param {string} title
 * @param {string} testid
 * @param {...import('../elements/dom.js').Child} children
 */
function card(title, testid, ...children) {
  return h('section', {class: 'why-card', 'data-testid': testid}, h('h3', {}, title), ...children);
}

/**
 * @param {Write[]} writes
 */
function writeList(writes) {
  return h('ol', {class: 'writes'}, ...writes.slice(0, MOST_WRITES).map(write => h('li', {},
    h('code', {}, write.instruction), h('span', {class: 'muted'}, changeText(write)))),
  writes.length > MOST_WRITES ? h('li', {class: 'muted'},
    say`and ${grouped(writes.length - MOST_WRITES)} more`) : '');
}

/** @param {Why} why */
function pixelCard(why) {
  const swatch = h('span', {class: 'swatch'});
  swatch.style.background = colorText(why.color);
  return card(say`Pixel`, 'why-pixel',
    h('div', {class: 'row'}, swatch, h('code', {}, colorText(why.color)),
      h('span', {class: 'muted'}, say`region ${why.region} on renderer-${why.renderer}`)),
    h('p', {...ENGLISH, 'data-testid': 'why-sentence'}, why.sentence));
}

/**
 * Instructions that wrote the pixel. The list is folded to keep the cell on the screen.
 * @param {string} testid
 * @param {string} title
 * @param {Write[]} writes
 */
function foldedWrites(testid, title, writes) {
  return h('details', {'data-testid': testid}, h('summary', {}, `${title}: ${writes.length}`),
    writeList(writes));
}

/**
 * @param {Why} why
 * @param {Visit | undefined} shown
 */
function instructionCard(why, shown) {
  return card(say`Instructions`, 'why-instructions',
    shown ? foldedWrites('why-stores', say`Stores by the triangle`, shown.writes) : h('p', {},
      say`No triangle was stored in this pixel. The prologue wrote the background.`),
    foldedWrites('why-end-stores', say`Stores at the end of the region`, why.end_of_region));
}

/**
 * @param {Visit} visit
 * @param {boolean} isShown
 */
function visitRow(visit, isShown) {
  const what = visit.cell
    ? say`triangle ${visit.cell.triangle ?? '?'} of cell ${visit.cell.cell.join(', ')}`
    : visit.address;
  const result = isShown ? say`shown` : visit.shut_out ? say`masked`
    : visit.stored ? say`overwritten` : say`behind`;
  return h('tr', {class: isShown ? 'shown' : ''}, h('td', {}, what),
    h('td', {class: 'number'}, visit.z === undefined ? '–' : grouped(visit.z)),
    h('td', {}, result));
}

/** @param {Why} why */
function coverText({visits, primitives_in_region}) {
  const all = grouped(primitives_in_region);
  return visits.length === 0 ? say`None of the region’s ${all} primitives covers this pixel.`
    : say`${grouped(visits.length)} of the region’s ${all} primitives cover this pixel.
      The smallest depth is in front.`;
}

/**
 * @param {Visit} visit
 * @param {number} [isovalue]
 */
function originText({gp, slab, surface}, isovalue) {
  return isovalue === undefined ? say`From gp-${gp}, slab ${slab}, surface ${surface}.`
    : say`From gp-${gp}, slab ${slab}, surface ${surface}, isovalue ${short(isovalue, 3)}.`;
}

/**
 * @param {Why} why
 * @param {Visit | undefined} shown
 */
function triangleCard(why, shown) {
  const surface = shown && why.surfaces[shown.surface];
  return card(say`Triangle`, 'why-triangle',
    shown ? h('p', {}, originText(shown, surface?.isovalue)) : '',
    h('p', {class: 'muted'}, coverText(why)),
    why.visits.length > 0 ? h('table', {class: 'visits'},
      h('thead', {}, h('tr', {}, h('th', {}, say`primitive`), h('th', {}, say`depth`),
        h('th', {}, ''))),
      h('tbody', {}, ...why.visits.slice(0, MOST_VISITS).map(visit =>
        visitRow(visit, visit === shown)))) : '');
}

/**
 * @param {Cell} cell
 * @param {{isovalue?: number, color: number[], table?: string} | undefined} surface
 * @param {CellView} view
 */
function cellCard(cell, surface, view) {
  const title = say`Cell ${cell.cell.join(', ')}`;
  if (cell.unknown || !cell.values || surface?.isovalue === undefined) {
    return card(title, 'why-cell', h('p', {class: 'panel-message bad'},
      cell.unknown ?? say`The voxels of this cell are not known.`));
  }
  view.show(cell, surface.isovalue, colorOf(surface.color));
  const inside = cell.values.filter(value => value >= Number(surface.isovalue)).length;
  return card(title, 'why-cell',
    h('p', {class: 'muted'}, say`Case ${cell.case}, table ${surface.table ?? '?'}: ${inside} of 8
      voxels are inside (at least ${short(surface.isovalue, 3)}), drawn filled. Triangle
      ${cell.triangle ?? '?'} of ${cell.triangle_count ?? '?'}. Drag to rotate.`),
    view.element, cell.doubt ? h('p', {class: 'panel-message bad'}, cell.doubt) : '');
}

/**
 * @param {Why} why
 * @param {CellView} view   Shows the cell. The view keeps its rotation.
 * @returns {HTMLElement[]}
 */
export function cardsOf(why, view) {
  const shown = why.shown === undefined ? undefined : why.visits[why.shown];
  return [pixelCard(why), instructionCard(why, shown), triangleCard(why, shown),
    ...(shown?.cell ? [cellCard(shown.cell, why.surfaces[shown.surface], view)] : [])];
}

/**
 * Positions of the writes to the pixel in the region's stream.
 * @param {Why} why
 * @returns {number[]}  Executed instructions before each write, ascending.
 */
export function changesOf({prologue, visits, doors, end_of_region}) {
  return [prologue, ...visits.map(visit => visit.writes), doors, end_of_region].flat()
    .map(({at}) => at).sort((a, b) => a - b);
}
