// One voxel cell in 3D: eight values, the triangle, and the point that the pixel's ray hits.
// Dragging and arrow keys rotate the cell.
import {h, s} from '../elements/dom.js';
import {grouped, significant} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {[number, number, number]} Vector */

/**
 * @typedef {object} Cell               A cell in the result of `why`.
 * @property {Vector} cell              The corner with the smallest indices.
 * @property {number} case              Bit c: corner c is inside.
 * @property {number} [triangle]
 * @property {number} [triangle_count]
 * @property {number[]} [values]        Value of corner c at cell + (c & 1, c >> 1 & 1, c >> 2).
 * @property {{voxel: Vector, value_0?: number, value_1?: number, fraction?: number}[]} [corners]
 *     Corners of the triangle.
 * @property {Vector} [hit_voxel]       Where the pixel's ray meets the triangle's plane.
 * @property {string} [unknown]         Reason why the voxels are unknown; other fields are missing.
 * @property {string} [doubt]
 */

const SIZE = 260;               // Drawing coordinates.
const SCALE = 60;               // Half of the nearest edge.
const DISTANCE = 6;             // From the eye to the center, in half edges.
const DRAG_RAD = 0.01;          // Per CSS pixel of drag.
const KEY_RAD = 0.15;
const MOST_TILT = 1.5;
const START = {turn: -0.6, tilt: 0.42};
const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5],
  [2, 6], [3, 7]];

/**
 * A value with five significant digits.
 * @param {number} value
 */
function valueText(value) {
  return significant(value, 5);
}

export class CellView {
  constructor() {
    /** @private @type {Cell | null} */ this.cell_ = null;
    /** @private */ this.isovalue_ = 0;
    /** @private */ this.color_ = '#ffffff';
    /** @private */ this.turn_ = START.turn;
    /** @private */ this.tilt_ = START.tilt;
    this.svg = s('svg', {class: 'cell', viewBox: `0 0 ${SIZE} ${SIZE}`, tabindex: 0, role: 'img',
      'data-testid': 'cell'});
    this.element = h('div', {class: 'cell-frame'}, this.svg);
    this.listen_();
  }

  /**
   * @param {Cell} cell
   * @param {number} isovalue
   * @param {string} color   Color of the surface.
   */
  show(cell, isovalue, color) {
    this.cell_ = cell;
    this.isovalue_ = isovalue;
    this.color_ = color;
    const inside = (cell.values ?? []).filter(value => value >= isovalue).length;
    this.svg.setAttribute('aria-label', say`Cell ${cell.cell.join(', ')}: ${inside} of its 8 voxels
      are inside, values ${(cell.values ?? []).map(valueText).join(', ')}. Arrow keys rotate it.`);
    this.draw_();
  }

  /**
   * The position of a point of the cell on the drawing.
   * @private
   * @param {Vector} at   0..1 along each axis.
   */
  project_(at) {
    const [x, y, z] = at.map(part => 2 * part - 1);
    const [cosTurn, sinTurn] = [Math.cos(this.turn_), Math.sin(this.turn_)];
    const [cosTilt, sinTilt] = [Math.cos(this.tilt_), Math.sin(this.tilt_)];
    // i to the right, k up; the eye looks along j, the patient's front to back in most scans.
    const right = x * cosTurn - y * sinTurn, away = x * sinTurn + y * cosTurn;
    const up = z * cosTilt + away * sinTilt, depth = away * cosTilt - z * sinTilt;
    const near = DISTANCE / (DISTANCE + depth) * SCALE;
    return {x: SIZE / 2 + right * near, y: SIZE / 2 - up * near, depth};
  }

  /** @private */
  draw_() {
    const cell = this.cell_;
    if (!cell?.values) {
      this.svg.replaceChildren();
      return;
    }
    const corners = cell.values.map((value, c) => ({
      ...this.project_([c & 1, c >> 1 & 1, c >> 2 & 1]), value,
      inside: value >= this.isovalue_,
    }));
    const edges = EDGES.map(([a, b]) => ({a: corners[a], b: corners[b]}))
      .sort((p, q) => q.a.depth + q.b.depth - p.a.depth - p.b.depth);
    this.svg.replaceChildren(
      ...edges.slice(0, 6).map(edge => this.edge_(edge)), this.triangle_(cell),
      ...edges.slice(6).map(edge => this.edge_(edge)), this.crossings_(cell),
      ...corners.sort((p, q) => q.depth - p.depth).map(corner => this.corner_(corner)),
      this.axes_());
  }

  /**
   * @private
   * @param {{a: {x: number, y: number}, b: {x: number, y: number}}} edge
   */
  edge_({a, b}) {
    return s('line', {class: 'edge', x1: a.x, y1: a.y, x2: b.x, y2: b.y});
  }

  /**
   * @private
   * @param {Cell} cell
   * @param {Vector} voxel
   */
  inCell_(cell, voxel) {
    return this.project_([voxel[0] - cell.cell[0], voxel[1] - cell.cell[1],
      voxel[2] - cell.cell[2]]);
  }

  /**
   * @private
   * @param {Cell} cell
   */
  triangle_(cell) {
    const points = (cell.corners ?? []).map(({voxel}) => this.inCell_(cell, voxel));
    return s('polygon', {class: 'face', fill: this.color_, 'data-testid': 'cell-triangle',
      points: points.map(({x, y}) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' ')});
  }

  /**
   * The triangle's corners, and where the pixel's ray meets it.
   * @private
   * @param {Cell} cell
   */
  crossings_(cell) {
    /** @type {SVGElement[]} */
    const marks = (cell.corners ?? []).map(({voxel, fraction, value_0, value_1}) => {
      const {x, y} = this.inCell_(cell, voxel);
      const title = fraction === undefined ? say`center of the crossings of the cell`
        : say`${grouped(100 * fraction, 1)} % of the way from ${valueText(value_0 ?? 0)} to
          ${valueText(value_1 ?? 0)}`;
      return s('circle', {class: 'crossing', cx: x, cy: y, r: 4, fill: this.color_},
        s('title', {}, title));
    });
    if (cell.hit_voxel) {
      const {x, y} = this.inCell_(cell, cell.hit_voxel);
      marks.push(s('g', {class: 'hit'}, s('title', {}, say`hit point of the pixel`),
        s('line', {x1: x - 6, y1: y, x2: x + 6, y2: y}),
        s('line', {x1: x, y1: y - 6, x2: x, y2: y + 6})));
    }
    return s('g', {}, ...marks);
  }

  /**
   * @private
   * @param {{x: number, y: number, value: number, inside: boolean}} corner
   */
  corner_({x, y, value, inside}) {
    const out = x < SIZE / 2 ? -1 : 1;
    return s('g', {class: inside ? 'corner inside' : 'corner outside'},
      s('circle', {cx: x, cy: y, r: 6}),
      s('text', {x: x + 10 * out, y: y + 4, 'text-anchor': out < 0 ? 'end' : 'start'},
        valueText(value)));
  }

  /** Names of the voxel axes, at their common corner. @private */
  axes_() {
    const ends = /** @type {[string, Vector][]} */ ([['i', [0.5, 0, 0]], ['j', [0, 0.5, 0]],
      ['k', [0, 0, 0.5]]]);
    return s('g', {class: 'axis'}, ...ends.map(([name, at]) => {
      const {x, y} = this.project_(at);
      return s('text', {x, y: y + 4, 'text-anchor': 'middle'}, name);
    }));
  }

  /** @private */
  listen_() {
    /** @type {{x: number, y: number} | null} */
    let last = null;
    this.svg.addEventListener('pointerdown', event => {
      last = {x: event.clientX, y: event.clientY};
      this.svg.setPointerCapture(event.pointerId);
    });
    this.svg.addEventListener('pointermove', event => {
      if (last) {
        this.turnBy_((last.x - event.clientX) * DRAG_RAD, (event.clientY - last.y) * DRAG_RAD);
        last = {x: event.clientX, y: event.clientY};
      }
    });
    for (const name of ['pointerup', 'pointercancel']) {
      this.svg.addEventListener(name, () => { last = null; });
    }
    const turns = new Map([['ArrowLeft', [KEY_RAD, 0]], ['ArrowRight', [-KEY_RAD, 0]],
      ['ArrowUp', [0, -KEY_RAD]], ['ArrowDown', [0, KEY_RAD]]]);
    this.svg.addEventListener('keydown', event => {
      const turn = turns.get(event.key);
      if (turn) {
        event.preventDefault();
        event.stopPropagation();
        this.turnBy_(turn[0], turn[1]);
      }
    });
  }

  /**
   * @private
   * @param {number} turn     Radians.
   * @param {number} tilt
   */
  turnBy_(turn, tilt) {
    this.turn_ += turn;
    this.tilt_ = Math.min(Math.max(this.tilt_ + tilt, -MOST_TILT), MOST_TILT);
    this.draw_();
  }
}
