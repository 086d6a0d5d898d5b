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
    /** @type {Triple | null}  The point of the first click. */
    this.first = null;
    /** Ends after the clicks so far: a second click waits for the point of the first. */
    this.clicked = Promise.resolve();
    this.count = 0;
    this.identity = '';
    this.message = messageLine('measure-message');
    this.list = h('ul', {class: 'distances', 'data-testid': 'measure-list'});
    this.drawing = s('g', {class: 'measure', 'data-testid': 'measure-lines'});
    const button = modeButton(app, {name: MODE, title: 'Measure', hint: HINT,
      testid: 'measure-mode',
      click: (x, y) => { this.clicked = this.clicked.then(() => this.click(x, y)); },
      leave: () => this.forgetFirst()});
    app.picture.overlay.append(this.drawing);
    root.append(intro('Straight-line distance between two points on a surface.'),
      h('div', {class: 'tool-row drives'}, button), this.list, this.message.element);
    app.picture.onChange(() => this.draw());
    // Slices measure, too.
    document.addEventListener('distance', event =>
      this.add(/** @type {CustomEvent} */ (event).detail));
    app.connection.on('hello', () => this.show());
    app.store.subscribe(['volume'], ({volume}) => this.open(volume?.identity ?? ''));
    app.session.add('measurements', {
      save: () => this.distances,
      restore: distances => {
        this.distances = distances;
        this.count = Math.max(0, ...this.distances.map(({name}) => Number(name)));
        this.show();
      },
    });
    this.show();
  }

  /** @param {string} identity  Another volume clears the distances. */
  open(identity) {
    if (identity !== this.identity) {
      this.identity = identity;
      this.distances = [];
      this.first = null;
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
      await this.begin(x, y);
      return;
    }
    this.forgetFirst();
    const reply = await this.app.connection.do(`measure ${first.join(',')} ${x} ${y}`,
      {quiet: true});
    if (!reply.ok) {
      this.message.fail(reply.error ?? '');
      return;
    }
    this.add(reply.result);
  }

  /**
   * Keeps the point of the first click: the pixel may show another one at the second click.
   * @param {number} x
   * @param {number} y
   */
  async begin(x, y) {
    const {ok, error = '', result} = await this.app.connection.do(`pick ${x} ${y}`, {quiet: true});
    if (!ok || !result?.hit) {
      this.message.fail(ok ? 'There is no surface. Click a point on a surface.' : error);
      return;
    }
    this.first = result.p_mm;
    this.message.say('Click the second point.');
    this.draw();
  }

  /** @param {Omit<Distance, 'name'>} result  The fields of `measure`. */
  add(result) {
    if (this.distances.length === MAX_DISTANCES) {
      this.distances.shift();
    }
    this.distances.push({name: String(++this.count), ...result});
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
    if (this.distances.length === 0 && !this.first) {
      if (this.drawing.childElementCount > 0) {
        this.drawing.replaceChildren();
      }
      return;
    }
    this.drawing.replaceChildren(...this.app.picture.eyes().map(eye =>
      s('g', {class: `eye-${eye.name}`}, ...this.marks(eye))));
  }

  /** @param {import('../panel/app.js').Eye} eye */
  marks(eye) {
    const marks = this.distances.flatMap(distance => {
      const a = eye.project(distance.a_mm), b = eye.project(distance.b_mm);
      return a.visible && b.visible ? [this.line(distance, a, b)] : [];
    });
    const first = this.first && eye.project(this.first);
    if (first?.visible) {
      marks.push(s('circle', {cx: first.x, cy: first.y, r: 4}));
    }
    return marks;
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
