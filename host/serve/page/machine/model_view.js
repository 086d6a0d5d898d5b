// Part of the machine panel: the modelled time of the 1993 machine for the current scene.
import {h} from '../elements/dom.js';
import {duration, grouped, percent, significant} from '../elements/numbers.js';
import {messageLine} from '../panel/panel_parts.js';
import {plural, say} from '../texts/say.js';

/**
 * How busy the units of a kind were: shares of the time, 0..1; index of the busiest one, from 0.
 * @typedef {{unit: string, mean: number, busiest: number, index: number}} UnitUse
 */
/**
 * limit: the unit that is, or "waiting".
 * @typedef {{ms: number, limit: string, use: UnitUse[]}} Step
 */

/**
 * The result of the command `model`.
 * @typedef {object} Modelled
 * @property {string} machine
 * @property {number} gps
 * @property {number} renderers
 * @property {number} frame_buffers
 * @property {Step} [load]              Loading the volume, if one is open.
 * @property {(Step & {name: string, triangles: number})[]} surfaces
 * @property {{primitives: number, samples: number, frames_per_s: number, latency_ms: number,
 *   limit: string, use: UnitUse[]}} frame  latency_ms: from the command until it is shown.
 */

/**
 * The `detail` of the event `estimated` on `document`.
 * @typedef {{result: Modelled | null, revision: number, error: string}} Estimated
 */

/** Names of the units on the page. */
const UNITS = new Map([['host', say`host`], ['host link', say`host link`], ['GP', say`GPs`],
  ['ring', say`ring channels`], ['Renderer', say`Renderers`],
  ['frame buffer', say`frame buffer ports`], ['waiting', say`waiting`]]);

/**
 * @param {string} unit  As the machine names it.
 * @returns {string} as the page does
 */
export function unitName(unit) {
  return UNITS.get(unit) ?? unit;
}

/** @param {{limit: string, use: UnitUse[]}} step */
function limitText({limit, use}) {
  const limiting = use.find(({unit}) => unit === limit);
  if (limiting) {
    return say`Limit: ${unitName(limit)}, ${percent(limiting.busiest)} busy`;
  }
  const most = use.reduce((a, b) => b.busiest > a.busiest ? b : a);
  return say`Limit: ${unitName(limit)}, ${unitName(most.unit)} ${percent(most.busiest)} busy`;
}

/**
 * The times, and the limiting unit of each step.
 * @param {Modelled} modelled
 * @returns {[string, string][]}
 */
export function factsOf({machine, gps, renderers, frame_buffers, load, surfaces, frame}) {
  /** @type {[string, string][]} */
  const facts = [[say`Machine`, [machine,
    plural(gps, say`1 GP`, say`${grouped(gps)} GPs`) + ', ' +
    plural(renderers, say`1 Renderer`, say`${grouped(renderers)} Renderers`),
    plural(frame_buffers, say`1 frame buffer`, say`${grouped(frame_buffers)} frame buffers`)]
    .join('\n')]];
  if (load) {
    facts.push([say`Load time`, `${duration(load.ms)}\n${limitText(load)}`]);
  }
  for (const surface of surfaces) {
    facts.push([say`Surface ${surface.name}`, [say`extracted in ${duration(surface.ms)}`,
      plural(surface.triangles, say`1 triangle`, say`${grouped(surface.triangles)} triangles`),
      limitText(surface)].join('\n')]);
  }
  const {primitives, samples, frames_per_s, latency_ms} = frame;
  const rate = significant(frames_per_s, 3);
  facts.push([say`Frames`, [say`${rate} frames/s`, say`latency ${duration(latency_ms)}`,
    plural(primitives, say`1 primitive`, say`${grouped(primitives)} primitives`),
    plural(samples, say`1 sample per pixel`, say`${grouped(samples)} samples per pixel`),
    limitText(frame)].join('\n')]);
  return facts;
}

/**
 * The load of one kind of unit while the picture is drawn.
 * @param {UnitUse} use
 * @param {boolean} isLimit
 */
function useRow({unit, mean, busiest, index}, isLimit) {
  const name = unitName(unit);
  const title = name[0].toUpperCase() + name.slice(1);
  const [average, most] = [percent(mean), percent(busiest)];
  const text = average === most ? most : say`${average}, busiest ${most}`;
  const bar = h('div', {class: 'stage-bar',
    title: say`${title}: ${average} on average, ${most} for the busiest (number ${index})`});
  const parts = {'stage-0': mean, 'use-busiest': busiest - mean};
  for (const [part, share] of Object.entries(parts)) {
    const piece = h('span', {class: part});
    piece.style.width = `${100 * Math.max(share, 0)}%`;
    bar.append(piece);
  }
  const label = h('div', {class: 'stage-label', 'data-testid': 'model-use'},
    h('span', {}, isLimit ? h('b', {}, title) : title,
      isLimit && h('span', {class: 'muted'}, ` ${say`limit`}`)),
    h('span', {class: 'number'}, text));
  return [label, bar];
}

export class ModelView {
  /** @param {import('../panel/app.js').App} app */
  constructor(app) {
    /** @private */
    this.app_ = app;
    /** @private Revision of the estimate, null before the first. @type {number | null} */
    this.revision_ = null;
    /** @private */
    this.go_ = h('button', {type: 'button', 'data-testid': 'model-go',
      onclick: () => void this.ask_()}, say`Estimate`);
    /** @private */
    this.message_ = messageLine('model-message');
    /** @private */
    this.facts_ = h('dl', {class: 'facts', 'data-testid': 'model-facts'});
    /** @private */
    this.use_ = h('div', {class: 'stage-rows'});
    /** @private */
    this.legend_ = h('p', {class: 'legend'});
    /** @private */
    this.told_ = h('div', {class: 'stack', hidden: true}, this.facts_, this.legend_, this.use_);
    this.element = h('div', {class: 'stack', 'data-testid': 'model'},
      h('p', {class: 'legend'}, say`Estimates how long the machine of 1993 needed for the same
        work. The work is counted and replayed on a model of that machine.`),
      h('div', {class: 'tool-row'}, this.go_, this.message_.element), this.told_);
    app.store.subscribe(['revision'], ({revision}) => this.compare_(revision));
    document.addEventListener('estimate', () => this.go_.click());
    app.connection.on('hello', () => {
      this.go_.hidden = app.connection.watches;
      this.message_.say(app.connection.watches
        ? say`A view-only page cannot request an estimate.` : '');
    });
  }

  /** @private */
  async ask_() {
    this.go_.disabled = true;
    this.message_.say(say`Counting …`);
    const reply = await this.app_.connection.do('model', {quiet: true});
    this.go_.disabled = false;
    if (reply.ok) {
      this.revision_ = reply.revision ?? null;
      this.message_.say('');
      this.show_(reply.result);
      this.told_.scrollIntoView({block: 'nearest'});
      this.compare_(this.app_.store.state?.revision ?? null);
    } else {
      this.message_.refuse(reply);
    }
    document.dispatchEvent(new CustomEvent('estimated', {detail: {result: reply.result ?? null,
      revision: reply.revision ?? 0, error: reply.ok ? '' : reply.error ?? ''}}));
  }

  /**
   * Marks the estimate as outdated if the scene has changed.
   * @private
   * @param {number | null} revision
   */
  compare_(revision) {
    const isOld = this.revision_ !== null && revision !== this.revision_;
    if (isOld !== this.told_.classList.contains('outdated')) {
      this.told_.classList.toggle('outdated', isOld);
      if (!this.go_.disabled) {  // Otherwise the message shows the progress.
        this.message_.say(isOld ? say`The picture has changed since this estimate.` : '');
      }
    }
  }

  /**
   * @private
   * @param {Modelled} modelled
   */
  show_(modelled) {
    this.told_.hidden = false;
    this.facts_.replaceChildren(...factsOf(modelled).flatMap(([what, is]) =>
      [h('dt', {}, what), h('dd', {}, is)]));
    const {use, limit} = modelled.frame;
    this.legend_.textContent = say`Load of the units while the same view is redrawn. Bright:
      average of all units of a kind. Dim: the busiest unit.`;
    this.use_.replaceChildren(...use.flatMap(each => useRow(each, each.unit === limit)));
  }
}
