// The texts of the six steps. Each text uses the machine's answers.
import {counted, duration, grouped, percent, short, significant} from '../elements/numbers.js';
import {LIMITS} from '../link/vocabulary.js';
import {cellOf, evaluationOf, regionsOf, sentPixels, shownOf, triangleCount} from './facts.js';

/** @typedef {import('./facts.js').Facts} Facts */
/**
 * @typedef {object} Step
 * @property {string} title
 * @property {string} panel     ID of the tab.
 * @property {string} watched   The tab on a view-only page.
 * @property {string} part      data-testid of the part of the panel that the step is about.
 * @property {(facts: Facts) => string[]} text  Paragraphs.
 */

const CYCLES_PER_MS_1993 = 40_000;  // Pixel processors at 40 MHz.
const BACKGROUND = 'This pixel shows the background, and no triangle. Press Inspect and click a '
  + 'pixel on a surface.';

/** @param {import('./facts.js').State} state */
function scanText({volume}) {
  if (!volume) {
    return 'This scene has no scan: its triangles come from a file.';
  }
  const [columns, rows, slices] = volume.size;
  return `The scan has ${counted(slices, 'slice')} of ${columns} × ${rows} voxels. `
    + 'Two neighboring slices and the voxels between them form cells: each cell has eight '
    + 'voxels as its corners.';
}

/** @param {Facts} facts */
function cellText(facts) {
  const {state, why, watches} = facts, cell = cellOf(facts), shown = shownOf(facts);
  if (watches) {
    return [scanText(state), 'Marching cubes compares the voxels of each cell with the isovalue '
      + 'of a surface, and joins the places on the edges of the cell where the value is the '
      + `isovalue. The visible surfaces have ${counted(triangleCount(state), 'triangle')}.`];
  }
  if (!why || !shown) {
    return [scanText(state), ...(why ? [BACKGROUND] : [])];
  }
  const isovalue = why.surfaces[shown.surface]?.isovalue;
  if (!cell || isovalue === undefined) {
    return [scanText(state), `Pixel (${why.x}, ${why.y}) shows no triangle of a cell. `
      + `${shown.cell?.unknown ?? ''}`.trim()];
  }
  const inside = (cell.values ?? []).filter(value => value >= isovalue).length;
  return [scanText(state), `Pixel (${why.x}, ${why.y}) shows the cell ${cell.cell.join(', ')}. `
    + `${inside} of its 8 voxels have at least the isovalue, ${short(isovalue, 3)}.`,
  'Marching cubes joins the places on the edges of the cell where the value is the isovalue. Case '
    + `${cell.case} of the 256 cases gives ${counted(cell.triangle_count ?? 0, 'triangle')} `
    + 'here. The crosshair of the slices stands at the pixel.'];
}

/** @param {Facts} facts */
function binText(facts) {
  const {state, why, watches} = facts, shown = shownOf(facts);
  const [columns, rows] = regionsOf(state), {machine} = state;
  const share = `${counted(machine.gps, 'Graphics Processor')} (GPs) share the `
    + `${counted(triangleCount(state), 'triangle')} of the visible surfaces. For each picture, a `
    + 'GP moves the corners of its triangles to the viewpoint.';
  const regions = `A region has ${LIMITS.region_px} × ${LIMITS.region_px} pixels. This picture has `
    + `${columns} × ${rows} regions. A GP puts each triangle into the bin of `
    + 'each region that the triangle touches.';
  if (watches || !why) {
    return [share, regions];
  }
  return [shown ? `gp-${shown.gp} extracted the triangle of this pixel, from slab ${shown.slab}. `
    + share : share, regions,
  `The pixel lies in region ${why.region}. The bins of this region have `
    + `${counted(why.primitives_in_region, 'triangle')}. ${visitText(why)}`];
}

/**
 * The triangles that cover the pixel.
 * @param {import('./facts.js').Why} why
 */
function visitText({visits}) {
  if (visits.length === 0) {
    return 'None of them covers the pixel.';
  }
  const masked = visits.filter(({shut_out}) => shut_out).length;
  const cover = `${grouped(visits.length)} of them ${visits.length === 1 ? 'covers' : 'cover'} the `
    + 'pixel.';
  return masked === 0 ? `${cover} The pixel shows the one with the smallest depth.`
    : `${cover} ${grouped(masked)} of these ${masked === 1 ? 'is' : 'are'} masked, because the `
      + 'surface is transparent. Of the others, the pixel shows the one with the smallest depth.';
}

/** @param {Facts} facts */
function streamText(facts) {
  const {state, why, stream, frame, watches} = facts, shown = shownOf(facts);
  const what = 'For each region, the GPs write an opcode stream: a list of instructions for a '
    + `Renderer. The machine has ${counted(state.machine.renderers, 'Renderer')}.`;
  if (watches) {
    const count = frame?.instructions;
    return [what, count ? 'For the last picture, the Renderers executed '
      + `${counted(count, 'instruction')}.` : 'No picture has been drawn since the tour began.'];
  }
  if (!why || !stream) {
    return [what];
  }
  const paragraphs = [what, `The stream of region ${stream.region} has `
    + `${counted(stream.count, 'instruction')}. renderer-${stream.renderer} executes the stream.`];
  if (shown && shown.writes.length > 0) {
    const [{at, instruction}] = shown.writes;
    paragraphs.push(`The panel stands before instruction ${grouped(at)}: “${instruction}”. `
      + 'There the triangle of the pixel begins to write. It stores '
      + `${counted(shown.writes.length, 'value')} in the pixel. The buttons of the panel go on, `
      + 'and back.');
  }
  return paragraphs;
}

/** @param {Facts} facts */
function processorText(facts) {
  const {stream, watches} = facts, found = evaluationOf(facts);
  const all = `${grouped(LIMITS.region_pixels)} pixel processors`;
  const what = `A Renderer has ${all}, one per pixel of a region. All execute the same `
    + 'instruction at the same time. A tree of adders gives each of them the value of '
    + 'A x + B y + C for its place x, y in the region.';
  const edges = 'Each edge of a triangle is such an expression. Where the value is negative, the '
    + 'pixel is outside, and its processor is disabled.';
  if (watches || !found) {
    return [what, edges];
  }
  const [a, b, c] = found.terms.map(term => grouped(term));
  const enabled = stream && stream.at === found.at
    ? ` Now ${counted(stream.enabled, 'pixel')} of the region `
      + `${stream.enabled === 1 ? 'is' : 'are'} enabled.` : '';
  return [what, `${edges}${enabled}`,
    `Instruction ${grouped(found.at)} writes the depth: A = ${a}, B = ${b}, C = ${c}. At x = `
    + `${found.x}, y = ${found.y} the value is ${grouped(found.sum)}. Without its lowest `
    + `${found.shift} bits, and as a number of ${found.bits} bits, this is the depth `
    + `${grouped(found.z)}.`];
}

/** @param {Facts} facts */
function ringText({why, report, watches}) {
  const what = 'A Renderer sends its finished regions over the ring to the frame buffer, which '
    + 'puts the regions together.';
  if (!report || !watches && !why) {
    return [what];
  }
  const {renderer, region} = watches || !why ? {renderer: null, region: 0} : why;
  const channels = `The ring joins ${counted(report.nodes.length, 'node')} and has `
    + `${counted(report.channels.length, 'channel')}.`;
  const {messages, bytes, to} = sentPixels(report, renderer);
  const who = renderer === null ? 'the Renderers' : `renderer-${renderer}`;
  const sent = messages === 0
    ? `In the last ${duration(report.wall_ms)}, ${who} sent no regions. Rotate the picture.`
    : `In ${duration(report.wall_ms)}, ${who} sent ${counted(messages, 'message')} RegionPixels `
      + `with ${counted(bytes, 'byte')} to ${to.join(' and ')}.`;
  const cycles = renderer === null ? undefined : report.frame?.regions.cycles[region];
  return [`${what} ${channels}`, sent, ...(cycles ? [`Region ${region} took `
    + `${counted(cycles, 'cycle')} in the last frame. That is `
    + `${duration(cycles / CYCLES_PER_MS_1993)} at the 40 MHz of 1993.`] : [])];
}

/** @param {Facts} facts */
function clockText({modelled, frame, watches}) {
  const what = 'This program has two clocks. The wall clock shows the time of this computer. The '
    + 'modelled clock counts the work of the picture, and replays the counts with the times of the '
    + 'machine of 1993.';
  const {elapsed_ms, renderer_ms_1993} = frame ?? {};
  const wall = elapsed_ms ? `The last frame took ${duration(elapsed_ms)} of wall time.` : '';
  if (watches) {
    const ours = renderer_ms_1993 ? `The Renderers of 1993 needed ${duration(renderer_ms_1993)}.`
      : '';
    return [what, `${wall} ${ours}`.trim()].filter(Boolean);
  }
  if (!modelled) {
    return [what];
  }
  const {gps, renderers, frame: drawn, load} = modelled;
  const limit = drawn.use.find(({unit}) => unit === drawn.limit);
  const loads = load ? ` Loading the scan took ${duration(load.ms)} there.` : '';
  return [what, `A machine with ${counted(gps, 'GP')} and ${counted(renderers, 'Renderer')} would `
    + `draw this scene ${significant(drawn.frames_per_s, 3)} times per second. A change is on its `
    + `screen after ${duration(drawn.latency_ms)}.${loads}`,
  (limit ? `The limit is the unit “${limit.unit}”: ${percent(limit.busiest)} busy. ` : '')
    + 'The result is modelled, not measured. Some parameters are published; others are recalled, '
    + 'derived or fitted.', wall].filter(Boolean);
}

/** @type {Step[]} */
export const STEPS = [
  {title: 'Slices and a cell', panel: 'inspector', watched: 'slices', part: 'why-cell',
    text: cellText},
  {title: 'A triangle in a bin', panel: 'inspector', watched: 'machine', part: 'why-triangle',
    text: binText},
  {title: 'The stream of a region', panel: 'inspector', watched: 'machine', part: 'stream',
    text: streamText},
  {title: `${grouped(LIMITS.region_pixels)} pixel processors`, panel: 'inspector',
    watched: 'machine', part: 'stream', text: processorText},
  {title: 'Over the ring to the frame buffer', panel: 'machine', watched: 'machine', part: 'ring',
    text: ringText},
  {title: 'The clock of 1993', panel: 'machine', watched: 'machine', part: 'model',
    text: clockText},
];
