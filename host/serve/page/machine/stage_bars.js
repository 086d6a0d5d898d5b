// Time per frame: stages of the busiest node of each role, wall time and modelled time.
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */
/** @typedef {import('./ring_flow.js').NodeReport} NodeReport */
/** @typedef {{label: string, who: string, parts: {name: string, ms: number}[]}} Row */

const KINDS = [['gp', say`GPs`], ['renderer', say`Renderers`],
  ['framebuffer', say`Frame buffer`]];
/** Stages of the nodes, as the page writes them. */
export const STAGES = new Map([['wait', say`wait`], ['receive', say`receive`], ['send', say`send`],
  ['work', say`work`], ['load', say`load`], ['extract', say`extract`],
  ['simplify', say`simplify`], ['measure', say`measure`], ['assign', say`assign`],
  ['transform', say`transform`], ['select', say`select`], ['set_up', say`set up`],
  ['plan', say`plan`], ['primitives', say`primitives`], ['end_of_region', say`end of region`],
  ['assemble', say`assemble`]]);
const MANY = 8;     // Number of stage colors; more stages repeat the colors.

/**
 * Stages of the busiest node of each role. A frame waits for this node.
 * @param {MachineReport} report
 * @returns {Row[]}
 */
export function rowsOf({nodes, frames}) {
  const sum = (/** @type {NodeReport} */ node) =>
    node.stages.reduce((all, {ms}) => all + ms, 0);
  return KINDS.flatMap(([role, label]) => {
    const ours = nodes.filter(node =>
      node.role.replace('_', '') === role && node.stages.length > 0);
    if (ours.length === 0 || frames === 0) {
      return [];
    }
    const longest = ours.reduce((a, b) => sum(b) > sum(a) ? b : a);
    return [{label, who: longest.name, parts: longest.stages.map(({name, ms}) =>
      ({name: STAGES.get(name) ?? name, ms: ms / frames}))}];
  });
}

/** @param {number} ms */
function msText(ms) {
  return `${grouped(ms, ms < 10 ? 1 : 0)} ms`;
}

/**
 * @param {{ms: number, class: string, title: string}[]} parts
 * @param {number} scale_ms  That the whole width stands for.
 */
function bar(parts, scale_ms) {
  const element = h('div', {class: 'stage-bar'});
  for (const part of parts) {
    const piece = h('span', {class: part.class, title: part.title});
    piece.style.width = `${100 * part.ms / scale_ms}%`;
    element.append(piece);
  }
  return element;
}

export class StageBars {
  constructor() {
    /** @private */
    this.rows_ = h('div', {class: 'stage-rows'});
    /** @private */
    this.clocks_ = h('div', {class: 'stage-rows', 'data-testid': 'clocks'});
    this.element = h('div', {class: 'stack', 'data-testid': 'stages'}, this.rows_, this.clocks_,
      h('p', {class: 'legend'}, say`The modelled time counts the cycles of the busiest Renderer
        at 40 MHz, with the same number of Renderers and samples. It excludes GPs, ring and
        frame buffer.`));
  }

  /** @param {MachineReport} report  Without a finished frame the bars stay. */
  update(report) {
    const {frame} = report;
    const rows = rowsOf(report);
    if (rows.length > 0) {
      const totals = rows.map(({parts}) => parts.reduce((all, {ms}) => all + ms, 0));
      const scale = Math.max(...totals, 0.001);
      this.rows_.replaceChildren(...rows.flatMap(({label, who, parts}, row) => [
        h('div', {class: 'stage-label'}, h('span', {}, label, h('span', {class: 'muted'},
          ` ${say`${who}, busiest`}`)), h('span', {class: 'number'}, msText(totals[row]))),
        bar(parts.map(({name, ms}, n) => ({ms, class: `stage-${n % MANY}`,
          title: say`${name}: ${msText(ms)} per frame`})), scale),
        h('p', {class: 'legend keys'}, ...parts.filter(({ms}) => ms > 0.02 * scale).map(
          ({name, ms}) => h('span', {}, h('i', {class: `stage-${
            parts.findIndex(part => part.name === name) % MANY}`}), `${name} ${msText(ms)}`))),
      ]));
    }
    if (frame && frame.elapsed_ms > 0) {
      const modelled = frame.renderer_ms_1993 ?? 0;  // Unknown for a frame of several passes.
      const scale = Math.max(frame.elapsed_ms, modelled, 0.001);
      /** @type {(label: string, ms: number, color: string) => HTMLElement[]} */
      const clock = (label, ms, color) => [
        h('div', {class: 'stage-label'}, h('span', {}, label),
          h('span', {class: 'number'}, msText(ms))),
        bar([{ms, class: color, title: msText(ms)}], scale)];
      this.clocks_.replaceChildren(
        ...clock(say`Last frame, wall time`, frame.elapsed_ms, 'stage-0'),
        ...clock(say`Same frame, Renderers of 1993`, modelled, 'stage-2'));
    }
  }
}
