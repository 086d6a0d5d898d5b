// Panel: straight-line distances between points on a surface, drawn over the picture.
import {h, s} from '../elements/dom.js';
import {intro, messageLine, modeButton} from '../panel/panel_parts.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {{name: string, a_mm: Triple, b_mm: Triple, distance_mm: number}} Distance */

const MODE = 'measure';
const HINT = 'Click two points on a surface to measure the distance. Press Esc to stop.';
const MAX_DISTANCES = 32;

/** @param {number} mm */
function lengthText(mm) {
  return mm < 100 ? `${mm.toFixed(1)} mm` : `${mm.toFixed(0)} mm`;
}

class MeasurePanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    /** @type {Distance[]} */
    this.distances = [];
    /** @type {{x: number, y: number} | null}  Pixel of the first click. */
    this.first = null;
    this.count = 0;
    this.source = '';
    this.message = messageLine('measure-message');
    this.list = h('ul', {class: 'distances', 'data-testid': 'measure-list'});
    this.drawing = s('g', {class: 'measure', 'data-testid': 'measure-lines'});
    const button = modeButton(app, {name: MODE, title: 'Measure', hint: HINT,
      testid: 'measure-mode', click: (x, y) => void this.click(x, y),
      leave: () => this.forgetFirst()});
    app.picture.overlay.append(this.drawing);
    root.append(intro('Straight-line distance between two points on a surface.'),
      h('div', {class: 'tool-row drives'}, button), this.list, this.message.element);
    app.picture.onChange(() => this.draw());
    app.connection.on('hello', () => this.show());
    // After the view changes, the pixel of the first click shows another point.
    app.store.subscribe(['camera', 'size'], () => this.forgetFirst());
    app.store.subscribe(['volume'], ({volume}) => this.open(volume?.source ?? ''));
    this.show();
  }

  /** @param {string} source  A new source clears the distances. */
  open(source) {
    if (source !== this.source) {
      this.source = source;
      this.distances = [];
      this.show();
    }
  }

  forgetFirst() {
    this.first = null;
    this.draw();
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  async click(x, y) {
    const first = this.first;
    if (!first) {
      this.first = {x, y};
      this.message.say('Click the second point.');
      this.draw();
      return;
    }
    this.forgetFirst();
    const reply = await this.app.connection.do(
      `measure ${first.x} ${first.y} ${x} ${y}`, {quiet: true});
    if (!reply.ok) {
      this.message.fail(reply.error ?? '');
      return;
    }
    if (this.distances.length === MAX_DISTANCES) {
      this.distances.shift();
    }
    this.distances.push({name: String(++this.count), ...reply.result});
    this.show();
  }

  show() {
    const advice = this.app.connection.watches ? 'A view-only page cannot measure.'
      : 'Press Measure, then click two points on a surface.';
    this.message.say(this.distances.length > 0 ? '' : advice);
    this.list.replaceChildren(...this.distances.map(distance => h('li', {},
      h('span', {class: 'badge'}, distance.name),
      h('b', {class: 'grow number'}, lengthText(distance.distance_mm)),
      h('button', {type: 'button', class: 'quiet', 'aria-label': `Delete distance ${distance.name}`,
        title: 'Delete', 'data-testid': `measure-delete-${distance.name}`,
        onclick: () => this.remove(distance)}, '×'))));
    this.draw();
  }

  /** @param {Distance} distance */
  remove(distance) {
    this.distances = this.distances.filter(each => each !== distance);
    this.show();
  }

  draw() {
    const {picture} = this.app;
    const marks = this.distances.flatMap(distance => {
      const a = picture.project(distance.a_mm), b = picture.project(distance.b_mm);
      return a.visible && b.visible ? [this.line(distance, a, b)] : [];
    });
    if (this.first) {
      const {x, y} = picture.placeOfPixel(this.first.x, this.first.y);
      marks.push(s('circle', {cx: x, cy: y, r: 4}));
    }
    this.drawing.replaceChildren(...marks);
  }

  /**
   * @param {Distance} distance
   * @param {{x: number, y: number}} a  Places in the picture.
   * @param {{x: number, y: number}} b
   */
  line(distance, a, b) {
    const ends = {x1: a.x, y1: a.y, x2: b.x, y2: b.y};
    const label = s('text', {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 - 8},
      `${distance.name}: ${lengthText(distance.distance_mm)}`);
    return s('g', {}, s('line', {class: 'back', ...ends}), s('line', {class: 'front', ...ends}),
      s('circle', {cx: a.x, cy: a.y, r: 3}), s('circle', {cx: b.x, cy: b.y, r: 3}), label);
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new MeasurePanel(root, app);
}
