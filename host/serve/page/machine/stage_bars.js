// Where a frame's time goes: stages of the busiest node of each kind, and the two clocks.
import {h} from '../elements/dom.js';

/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */
/** @typedef {import('./ring_flow.js').NodeReport} NodeReport */
/** @typedef {{label: string, who: string, parts: {name: string, ms: number}[]}} Row */

const KINDS = [['gp', 'GPs'], ['renderer', 'Renderers'], ['framebuffer', 'Frame buffer']];
const MANY = 8;     // Colours of stages; more begin again.

/**
 * Stages of a frame: of each kind of node the one that worked longest, as the others wait for it.
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
      ({name: name.replaceAll('_', ' '), ms: ms / frames}))}];
  });
}

/** @param {number} ms */
function msText(ms) {
  return `${ms < 10 ? ms.toFixed(1) : ms.toFixed(0)} ms`;
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
      h('p', {class: 'legend'}, 'The modelled clock counts the cycles of the Renderer that ' +
        'worked longest, at 40 MHz: of as many Renderers and samples as here, without GPs, ring ' +
        'and frame buffer.'));
  }

  /** @param {MachineReport} report  Keeps what it shows if no frame was done. */
  update(report) {
    const {frame} = report;
    const rows = rowsOf(report);
    if (rows.length > 0) {
      const totals = rows.map(({parts}) => parts.reduce((all, {ms}) => all + ms, 0));
      const scale = Math.max(...totals, 0.001);
      this.rows_.replaceChildren(...rows.flatMap(({label, who, parts}, row) => [
        h('div', {class: 'stage-label'}, h('span', {}, label, h('span', {class: 'muted'},
          ` ${who}, the busiest`)), h('span', {class: 'number'}, msText(totals[row]))),
        bar(parts.map(({name, ms}, n) => ({ms, class: `stage-${n % MANY}`,
          title: `${name}: ${msText(ms)} a frame`})), scale),
        h('p', {class: 'legend keys'}, ...parts.filter(({ms}) => ms > 0.02 * scale).map(
          ({name, ms}) => h('span', {}, h('i', {class: `stage-${
            parts.findIndex(part => part.name === name) % MANY}`}), `${name} ${msText(ms)}`))),
      ]));
    }
    if (frame && frame.elapsed_ms > 0) {
      const modelled = frame.renderer_ms_1993 ?? 0;  // Not known of a frame drawn in passes.
      const scale = Math.max(frame.elapsed_ms, modelled, 0.001);
      /** @type {(label: string, ms: number, colour: string) => HTMLElement[]} */
      const clock = (label, ms, colour) => [
        h('div', {class: 'stage-label'}, h('span', {}, label),
          h('span', {class: 'number'}, msText(ms))),
        bar([{ms, class: colour, title: msText(ms)}], scale)];
      this.clocks_.replaceChildren(
        ...clock('The last frame here, wall clock', frame.elapsed_ms, 'stage-0'),
        ...clock('The same on Renderers of 1993, modelled', modelled, 'stage-2'));
    }
  }
}
