// The texts of the six steps. Each text uses the machine's answers.
import {duration, grouped, percent, short, significant} from '../elements/numbers.js';
import {LIMITS} from '../link/vocabulary.js';
import {unitName} from '../machine/model_view.js';
import {plural, say} from '../texts/say.js';
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
const BACKGROUND = say`This pixel shows the background, and no triangle. Press Inspect and click a
  pixel on a surface.`;

/** @param {number} count */
function triangles(count) {
  return plural(count, say`1 triangle`, say`${grouped(count)} triangles`);
}

/** @param {number} count */
function instructions(count) {
  return plural(count, say`1 instruction`, say`${grouped(count)} instructions`);
}

/** @param {number} count */
function renderers(count) {
  return plural(count, say`1 Renderer`, say`${grouped(count)} Renderers`);
}

/** @param {import('./facts.js').State} state */
function scanText({volume}) {
  if (!volume) {
    return say`This scene has no scan: its triangles come from a file.`;
  }
  const [columns, rows, count] = volume.size;
  const slices = plural(count, say`1 slice`, say`${grouped(count)} slices`);
  return say`The scan has ${slices} of ${columns} × ${rows} voxels.
    Two neighboring slices and the voxels between them form cells: each cell has eight
    voxels as its corners.`;
}

/** @param {Facts} facts */
function cellText(facts) {
  const {state, why, watches} = facts, cell = cellOf(facts), shown = shownOf(facts);
  if (watches) {
    return [scanText(state), say`Marching cubes compares the voxels of each cell with the isovalue
      of a surface, and joins the places on the edges of the cell where the value is the
      isovalue. The visible surfaces have ${triangles(triangleCount(state))}.`];
  }
  if (!why || !shown) {
    return [scanText(state), ...(why ? [BACKGROUND] : [])];
  }
  const isovalue = why.surfaces[shown.surface]?.isovalue;
  if (!cell || isovalue === undefined) {
    return [scanText(state), say`Pixel (${why.x}, ${why.y}) shows no triangle of a cell.`
      + ` ${shown.cell?.unknown ?? ''}`];
  }
  const inside = (cell.values ?? []).filter(value => value >= isovalue).length;
  return [scanText(state), say`Pixel (${why.x}, ${why.y}) shows the cell ${cell.cell.join(', ')}.
    ${inside} of its 8 voxels have at least the isovalue, ${short(isovalue, 3)}.`,
  say`Marching cubes joins the places on the edges of the cell where the value is the isovalue. Case
    ${cell.case} of the 256 cases gives ${triangles(cell.triangle_count ?? 0)}
    here. The crosshair of the slices stands at the pixel.`];
}

/** @param {Facts} facts */
function binText(facts) {
  const {state, why, watches} = facts, shown = shownOf(facts);
  const [columns, rows] = regionsOf(state), {gps} = state.machine;
  const processors = plural(gps, say`1 Graphics Processor`,
    say`${grouped(gps)} Graphics Processors`);
  const share = say`${processors} (GPs) share the
    ${triangles(triangleCount(state))} of the visible surfaces. For each picture, a
    GP moves the corners of its triangles to the viewpoint.`;
  const regions = say`A region has ${LIMITS.region_px} × ${LIMITS.region_px} pixels. This picture
    has ${columns} × ${rows} regions. A GP puts each triangle into the bin of
    each region that the triangle touches.`;
  if (watches || !why) {
    return [share, regions];
  }
  const extracted = shown
    && say`gp-${shown.gp} extracted the triangle of this pixel, from slab ${shown.slab}.`;
  const found = say`The pixel lies in region ${why.region}. The bins of this region have
    ${triangles(why.primitives_in_region)}.`;
  return [extracted ? `${extracted} ${share}` : share, regions, `${found} ${visitText(why)}`];
}

/**
 * The triangles that cover the pixel.
 * @param {import('./facts.js').Why} why
 */
function visitText({visits}) {
  if (visits.length === 0) {
    return say`None of them covers the pixel.`;
  }
  const masked = visits.filter(({shut_out}) => shut_out).length;
  const cover = plural(visits.length, say`1 of them covers the pixel.`,
    say`${grouped(visits.length)} of them cover the pixel.`);
  const shows = masked === 0 ? say`The pixel shows the one with the smallest depth.`
    : plural(masked, say`1 of these is masked, because the surface is transparent. Of the others,
      the pixel shows the one with the smallest depth.`,
    say`${grouped(masked)} of these are masked, because the surface is transparent. Of the others,
      the pixel shows the one with the smallest depth.`);
  return `${cover} ${shows}`;
}

/** @param {Facts} facts */
function streamText(facts) {
  const {state, why, stream, frame, watches} = facts, shown = shownOf(facts);
  const what = say`For each region, the GPs write an opcode stream: a list of instructions for a
    Renderer. The machine has ${renderers(state.machine.renderers)}.`;
  if (watches) {
    const count = frame?.instructions;
    return [what,
      count ? say`For the last picture, the Renderers executed ${instructions(count)}.`
        : say`No picture has been drawn since the tour began.`];
  }
  if (!why || !stream) {
    return [what];
  }
  const paragraphs = [what, say`The stream of region ${stream.region} has
    ${instructions(stream.count)}. renderer-${stream.renderer} executes the stream.`];
  if (shown && shown.writes.length > 0) {
    const [{at, instruction}] = shown.writes, {length} = shown.writes;
    const values = plural(length, say`1 value`, say`${grouped(length)} values`);
    paragraphs.push(say`The panel stands before instruction ${grouped(at)}: “${instruction}”.
      There the triangle of the pixel begins to write. It stores
      ${values} in the pixel. The buttons of the panel go on,
      and back.`);
  }
  return paragraphs;
}

/** @param {Facts} facts */
function processorText(facts) {
  const {stream, watches} = facts, found = evaluationOf(facts);
  const what = say`A Renderer has ${grouped(LIMITS.region_pixels)} pixel processors, one per pixel
    of a region. All execute the same instruction at the same time. A tree of adders gives each of
    them the value of A x + B y + C for its place x, y in the region.`;
  const edges = say`Each edge of a triangle is such an expression. Where the value is negative, the
    pixel is outside, and its processor is disabled.`;
  if (watches || !found) {
    return [what, edges];
  }
  const [a, b, c] = found.terms.map(term => grouped(term));
  const enabled = stream && stream.at === found.at
    ? ` ${plural(stream.enabled, say`Now 1 pixel of the region is enabled.`,
      say`Now ${grouped(stream.enabled)} pixels of the region are enabled.`)}` : '';
  return [what, `${edges}${enabled}`,
    say`Instruction ${grouped(found.at)} writes the depth: A = ${a}, B = ${b}, C = ${c}. At x =
    ${found.x}, y = ${found.y} the value is ${grouped(found.sum)}. Without its lowest
    ${found.shift} bits, and as a number of ${found.bits} bits, this is the depth
    ${grouped(found.z)}.`];
}

/** @param {Facts} facts */
function ringText({why, report, watches}) {
  const what = say`A Renderer sends its finished regions over the ring to the frame buffer, which
    puts the regions together.`;
  if (!report || !watches && !why) {
    return [what];
  }
  const {renderer, region} = watches || !why ? {renderer: null, region: 0} : why;
  const cycles = renderer === null ? undefined : report.frame?.regions.cycles[region];
  return [`${what} ${channelText(report)}`, sentText(report, renderer),
    ...(cycles ? [cycleText(region, cycles)] : [])];
}

/** @param {import('./facts.js').MachineReport} report */
function channelText(report) {
  const nodes = report.nodes.length, channels = report.channels.length;
  return say`The ring joins ${plural(nodes, say`1 node`, say`${grouped(nodes)} nodes`)} and has
    ${plural(channels, say`1 channel`, say`${grouped(channels)} channels`)}.`;
}

/**
 * The finished regions that went to the frame buffer.
 * @param {import('./facts.js').MachineReport} report
 * @param {number | null} renderer  null: all.
 */
function sentText(report, renderer) {
  const sent = sentPixels(report, renderer), time = duration(report.wall_ms);
  if (sent.messages === 0) {
    return renderer === null
      ? say`In the last ${time}, the Renderers sent no regions. Rotate the picture.`
      : say`In the last ${time}, renderer-${renderer} sent no regions. Rotate the picture.`;
  }
  const messages = plural(sent.messages, say`1 message`, say`${grouped(sent.messages)} messages`);
  const bytes = plural(sent.bytes, say`1 byte`, say`${grouped(sent.bytes)} bytes`);
  const to = sent.to.reduce((all, name) => say`${all} and ${name}`);
  return renderer === null
    ? say`In ${time}, the Renderers sent ${messages} RegionPixels with ${bytes} to ${to}.`
    : say`In ${time}, renderer-${renderer} sent ${messages} RegionPixels with ${bytes} to ${to}.`;
}

/**
 * @param {number} region
 * @param {number} count  Of the cycles that the region took.
 */
function cycleText(region, count) {
  return say`Region ${region} took ${plural(count, say`1 cycle`, say`${grouped(count)} cycles`)} in
    the last frame. That is ${duration(count / CYCLES_PER_MS_1993)} at the 40 MHz of 1993.`;
}

/** @param {Facts} facts */
function clockText({modelled, frame, watches}) {
  const what = say`This program has two clocks. The wall clock shows the time of this computer. The
    modelled clock counts the work of the picture, and replays the counts with the times of the
    machine of 1993.`;
  const {elapsed_ms, renderer_ms_1993} = frame ?? {};
  const wall = elapsed_ms ? say`The last frame took ${duration(elapsed_ms)} of wall time.` : '';
  if (watches) {
    const ours = renderer_ms_1993
      ? say`The Renderers of 1993 needed ${duration(renderer_ms_1993)}.` : '';
    return [what, `${wall} ${ours}`.trim()].filter(Boolean);
  }
  if (!modelled) {
    return [what];
  }
  const {gps, frame: drawn, load} = modelled;
  const limit = drawn.use.find(({unit}) => unit === drawn.limit);
  const draws = say`A machine with ${plural(gps, say`1 GP`, say`${grouped(gps)} GPs`)} and
    ${renderers(modelled.renderers)} would draw this scene ${significant(drawn.frames_per_s, 3)}
    times per second. A change is on its screen after ${duration(drawn.latency_ms)}.`;
  const loads = load ? ` ${say`Loading the scan took ${duration(load.ms)} there.`}` : '';
  const limits = limit
    ? `${say`The limit is the unit “${unitName(limit.unit)}”: ${percent(limit.busiest)} busy.`} `
    : '';
  return [what, `${draws}${loads}`,
    limits + say`The result is modelled, not measured. Some parameters are published; others are
      recalled, derived or fitted.`, wall].filter(Boolean);
}

/** @type {Step[]} */
export const STEPS = [
  {title: say`Slices and a cell`, panel: 'inspector', watched: 'slices', part: 'why-cell',
    text: cellText},
  {title: say`A triangle in a bin`, panel: 'inspector', watched: 'machine', part: 'why-triangle',
    text: binText},
  {title: say`The stream of a region`, panel: 'inspector', watched: 'machine', part: 'stream',
    text: streamText},
  {title: say`${grouped(LIMITS.region_pixels)} pixel processors`, panel: 'inspector',
    watched: 'machine', part: 'stream', text: processorText},
  {title: say`Over the ring to the frame buffer`, panel: 'machine', watched: 'machine',
    part: 'ring', text: ringText},
  {title: say`The clock of 1993`, panel: 'machine', watched: 'machine', part: 'model',
    text: clockText},
];
