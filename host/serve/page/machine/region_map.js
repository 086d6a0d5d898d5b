// A small copy of the picture with its regions: the Renderer and the cycles of each region.
import {contextOf, fitted, letterFont, onceAFrame, styleColor, watchSize}
  from '../elements/canvas.js';
import {byId, h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {LIMITS} from '../link/vocabulary.js';
import {plural, say} from '../texts/say.js';

/** @typedef {{columns: number, rows: number, renderer: number[], cycles: number[]}} Regions */

const EDGE = LIMITS.region_px;
const GOLDEN_DEG = 137.508;     // Multiples of this give distinct hues for any number of Renderers.
const LABEL_PX = 22;            // Regions smaller than this have no number.

/** @param {number} renderer */
export function rendererHue(renderer) {
  return (40 + GOLDEN_DEG * renderer) % 360;
}

/**
 * Whether the regions fit a picture of that size. Report and picture arrive separately.
 * @param {Regions} regions
 * @param {{width: number, height: number}} picture  Pixels.
 */
export function belongTo({columns, rows}, {width, height}) {
  return columns === Math.ceil(width / EDGE) && rows === Math.ceil(height / EDGE);
}

export class RegionMap {
  constructor() {
    /** @private @type {Regions | null} */ this.regions_ = null;
    /** The picture that the regions belong to. @private */
    this.picture_ = h('canvas', {});
    /** @private */ this.awaits_ = false;
    /** @private @type {number | null} */ this.hovered_ = null;
    this.canvas = h('canvas', {class: 'region-map', role: 'img', 'data-testid': 'region-map',
      'aria-label': say`Regions of the picture. The color shows the Renderer, lightness the
        cycles.`});
    this.readout = h('p', {class: 'legend', 'data-testid': 'region-readout'});
    /** @private */ this.drawSoon_ = onceAFrame(() => this.draw_());
    watchSize(this.canvas, this.drawSoon_);
    this.canvas.addEventListener('pointermove', event => this.hover_(this.regionAt_(event)));
    this.canvas.addEventListener('pointerleave', () => this.hover_(null));
  }

  /** @param {Regions | null} regions */
  update(regions) {
    const frame = /** @type {HTMLCanvasElement} */ (byId('frame'));
    this.awaits_ = regions !== null && !belongTo(regions, frame);
    if (!regions || belongTo(regions, frame)) {
      this.regions_ = regions;
      this.picture_.width = frame.width;
      this.picture_.height = frame.height;
      contextOf(this.picture_).drawImage(frame, 0, 0);
    }
    this.tell_();
    this.drawSoon_();
  }

  /**
   * The position of the picture on the canvas.
   * @private
   * @param {number} width
   * @param {number} height
   */
  place_(width, height) {
    const {width: across, height: down} = this.picture_;
    const scale = Math.min(width / across, height / down);
    return {x: (width - across * scale) / 2, y: (height - down * scale) / 2, scale, across, down};
  }

  /** @private */
  draw_() {
    const {context, width, height, unit} = fitted(this.canvas);
    const regions = this.regions_;
    if (width === 0 || !regions) {
      return;
    }
    const {x, y, scale, across, down} = this.place_(width, height);
    context.drawImage(this.picture_, x, y, across * scale, down * scale);
    const most = Math.max(1, ...regions.cycles), ink = styleColor(this.canvas, '--over-ink');
    context.save();
    context.beginPath();
    context.rect(x, y, across * scale, down * scale);
    context.clip();
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.font = letterFont(unit);
    const edge = EDGE * scale;
    for (let number = 0; number < regions.columns * regions.rows; ++number) {
      const renderer = regions.renderer[number];
      const share = (regions.cycles[number] ?? 0) / most;
      const left = x + number % regions.columns * edge;
      const top = y + Math.floor(number / regions.columns) * edge;
      context.fillStyle = renderer === undefined ? `hsla(210, 12%, ${15 + 60 * share}%, 0.6)`
        : `hsla(${rendererHue(renderer)}, 62%, ${16 + 52 * share}%, 0.62)`;
      context.fillRect(left + 0.5, top + 0.5, edge - 1, edge - 1);
      if (number === this.hovered_) {
        context.strokeStyle = ink;
        context.lineWidth = 2;
        context.strokeRect(left + 1.5, top + 1.5, edge - 3, edge - 3);
      }
      if (renderer !== undefined && edge >= LABEL_PX * unit) {
        context.fillStyle = ink;
        context.fillText(String(renderer), left + Math.min(edge, x + across * scale - left) / 2,
          top + Math.min(edge, y + down * scale - top) / 2);
      }
    }
    context.restore();
  }

  /**
   * @private
   * @param {MouseEvent} event
   * @returns {number | null}
   */
  regionAt_({clientX, clientY}) {
    const box = this.canvas.getBoundingClientRect();
    const {x, y, scale, across, down} = this.place_(box.width, box.height);
    const px = (clientX - box.left - x) / scale, py = (clientY - box.top - y) / scale;
    if (!this.regions_ || px < 0 || py < 0 || px >= across || py >= down) {
      return null;
    }
    return Math.floor(py / EDGE) * this.regions_.columns + Math.floor(px / EDGE);
  }

  /**
   * @private
   * @param {number | null} region
   */
  hover_(region) {
    if (region !== this.hovered_) {
      this.hovered_ = region;
      this.tell_();
      this.drawSoon_();
    }
  }

  /** @private */
  tell_() {
    const regions = this.regions_;
    if (!regions) {
      this.readout.textContent = this.awaits_ ? say`Waiting for the next picture …`
        : say`No frame has been drawn yet.`;
    } else if (this.hovered_ === null) {
      const all = regions.cycles.reduce((sum, each) => sum + each, 0);
      const most = Math.max(...regions.cycles);
      this.readout.textContent = say`Number and color show the Renderer, lightness the
        cycles: maximum ${grouped(most)}, total ${grouped(all)}.`;
    } else {
      const renderer = regions.renderer[this.hovered_];
      const column = this.hovered_ % regions.columns;
      const row = Math.floor(this.hovered_ / regions.columns);
      const count = regions.cycles[this.hovered_] ?? 0;
      const cycles = plural(count, say`1 cycle`, say`${grouped(count)} cycles`);
      this.readout.textContent = renderer === undefined
        ? say`Region (${column}, ${row}): ${cycles}`
        : say`Region (${column}, ${row}): renderer-${renderer}, ${cycles}`;
    }
  }
}
