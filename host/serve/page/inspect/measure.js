// Panel: distances, angles and paths on surfaces, drawn over the picture; the list of all measures.
import {h, s} from '../elements/dom.js';
import {choiceRow, intro, messageLine, modeButton, sentenceOf} from '../panel/panel_parts.js';
import {KIND_TITLES, POINTS, angleOf, csvOf, jsonOf, lengthOf, measureText, valuesText}
  from '../panel/measures.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('../panel/measures.js').Measure} Measure */
/** @typedef {'distance' | 'angle' | 'path'} LineKind */
/** @typedef {{x: number, y: number, visible: boolean}} Place  In the picture. */

const MODE = 'measure';
const HINTS = {
  distance: 'Click two points on a surface to measure the distance. Press Esc to stop.',
  angle: 'Click three points on a surface: the second is the vertex. Press Esc to stop.',
  path: 'Click the points of a path on a surface. Enter ends it. Press Esc to stop.',
};
const NEXT = ['', 'Click the second point.', 'Click the third point.'];
const LABEL_ABOVE = 8;

class MeasurePanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    /** @type {LineKind} */
    this.kind = 'distance';
    /** Points of the clicks so far. @type {Triple[]} */
    this.points = [];
    /** Ends after the clicks so far: each click waits for the point of the one before. */
    this.clicked = Promise.resolve();
    this.identity = '';
    this.message = messageLine('measure-message');
    this.list = h('ul', {class: 'distances', 'data-testid': 'measure-list'});
    this.drawing = s('g', {class: 'measure', 'data-testid': 'measure-lines'});
    this.build(root);
    this.listen();
  }

  /** @param {HTMLElement} root */
  build(root) {
    const {app} = this;
    this.button = modeButton(app, {name: MODE, title: 'Measure', hint: () => HINTS[this.kind],
      testid: 'measure-mode',
      click: (x, y) => { this.clicked = this.clicked.then(() => this.click(x, y)); },
      leave: () => this.finish()});
    const kinds = choiceRow('What to measure', [
      {name: 'distance', title: 'Distance', help: 'Straight line between two points'},
      {name: 'angle', title: 'Angle', help: 'Three points: the second is the vertex'},
      {name: 'path', title: 'Path', help: 'Length of straight lines from point to point'},
    ], kind => this.choose(/** @type {LineKind} */ (kind)));
    this.done = h('button', {type: 'button', hidden: true, 'data-testid': 'measure-done',
      title: 'Ends the path (Enter)', onclick: () => this.finish()}, 'End path');
    const save = (/** @type {string} */ suffix, /** @type {() => string} */ text) =>
      h('button', {type: 'button', class: 'quiet', 'data-testid': `measure-${suffix}`,
        title: `Saves all measurements as ${suffix.toUpperCase()}`,
        onclick: () => this.save(suffix, text())}, suffix.toUpperCase());
    this.files = h('div', {class: 'tool-row', hidden: true},
      h('span', {class: 'legend'}, 'Save as'),
      save('csv', () => csvOf(app.measures.list, app.store.state?.volume?.unit ?? '')),
      save('json', () => jsonOf(app.measures.list, app.store.state?.volume ??
        {name: '', unit: ''})));
    app.picture.overlay.append(this.drawing);
    root.append(intro('Distances, angles and paths on surfaces. Slices measure, too.'),
      h('div', {class: 'tool-row drives'}, kinds.element, this.button, this.done), this.list,
      this.files, this.message.element);
  }

  listen() {
    const {app} = this;
    app.picture.onChange(() => this.draw());
    // A headset measures, too.
    document.addEventListener('distance', event => {
      const {a_mm, b_mm, distance_mm} = /** @type {CustomEvent} */ (event).detail;
      this.add('distance', [a_mm, b_mm], distance_mm);
    });
    document.addEventListener('keydown', event => {
      if (event.key === 'Enter' && app.modes.current?.name === MODE && this.kind === 'path') {
        this.finish();
      }
    });
    app.measures.watch(() => this.show());
    app.connection.on('hello', () => this.show());
    app.store.subscribe(['volume'], ({volume}) => this.open(volume?.identity ?? ''));
    app.session.add('measurements', {
      save: () => app.measures.list, restore: list => app.measures.restore(list)});
  }

  /** @param {string} identity  Another volume clears the measures. */
  open(identity) {
    if (identity !== this.identity) {
      this.identity = identity;
      this.points = [];
      this.app.measures.clear();
    }
  }

  /** @param {LineKind} kind */
  choose(kind) {
    this.finish();
    this.kind = kind;
    const {modes} = this.app;
    if (modes.current?.name === MODE) {  // The hint is another one.
      modes.leave(MODE);
      this.button?.click();
    }
  }

  /** Keeps a path of two or more points, and forgets others that are not whole. */
  finish() {
    const points = this.points;
    this.points = [];
    if (this.kind === 'path' && points.length > 1) {
      this.add('path', points, lengthOf(points));
    }
    this.tell();
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  async click(x, y) {
    const kind = this.kind;
    if (kind === 'distance' && this.points.length === 1) {
      const [first] = this.points;
      this.points = [];
      this.tell();
      const reply = await this.app.connection.do(`measure ${first.join(',')} ${x} ${y}`,
        {quiet: true});
      if (reply.ok) {
        const {a_mm, b_mm, distance_mm} = reply.result;
        this.add('distance', [a_mm, b_mm], distance_mm);
      } else {
        this.message.fail(reply.error ?? '');
      }
      return;
    }
    // The point of each click is kept: the pixel may show another one at the next click.
    const {ok, error = '', result} = await this.app.connection.do(`pick ${x} ${y}`, {quiet: true});
    if (!ok || !result?.hit) {
      this.message.fail(ok ? 'There is no surface. Click a point on a surface.' : error);
      return;
    }
    if (kind !== this.kind) {
      return;
    }
    this.points = [...this.points, result.p_mm];
    if (kind === 'angle' && this.points.length === POINTS.angle) {
      const points = this.points;
      this.points = [];
      try {
        this.add('angle', points, angleOf(points));
      } catch (error) {
        this.tell();
        this.message.fail(sentenceOf(error));
        return;
      }
    }
    this.tell();
  }

  /**
   * @param {LineKind} kind
   * @param {Triple[]} points_mm
   * @param {number} value
   */
  add(kind, points_mm, value) {
    try {
      this.app.measures.add({kind, points_mm, value});
    } catch (error) {
      this.message.fail(sentenceOf(error));
    }
  }

  /** What to do next, and the points so far. */
  tell() {
    const count = this.points.length;
    const isPath = this.kind === 'path' && count > 0;
    this.done?.toggleAttribute('hidden', !(isPath && count > 1));
    const length = measureText({kind: 'path', value: lengthOf(this.points)});
    this.message.say(isPath ? `${length} so far. Click the next point, or press Enter.`
      : NEXT[count] ?? '');
    this.draw();
  }

  show() {
    const {measures, connection, store} = this.app;
    const advice = connection.watches ? 'A view-only page cannot measure.'
      : 'Press Measure, then click points on a surface.';
    this.message.say(measures.list.length > 0 ? '' : advice);
    this.files?.toggleAttribute('hidden', measures.list.length === 0);
    const unit = store.state?.volume?.unit ?? '';
    this.list.replaceChildren(...measures.list.map(measure => h('li', {},
      h('span', {class: 'badge'}, measure.name),
      h('div', {class: 'grow'}, h('b', {class: 'number'}, measureText(measure)),
        measure.kind !== 'distance' && h('span', {class: 'legend'},
          ` ${KIND_TITLES[measure.kind].toLowerCase()}`),
        measure.values && h('div', {class: 'legend'}, valuesText(measure.values, unit))),
      h('button', {type: 'button', class: 'quiet',
        'aria-label': `Delete measurement ${measure.name}`, title: 'Delete',
        'data-testid': `measure-delete-${measure.name}`,
        onclick: () => measures.remove(measure)}, '×'))));
    this.draw();
  }

  /**
   * @param {string} suffix
   * @param {string} text
   */
  save(suffix, text) {
    const url = URL.createObjectURL(new Blob([text], {type: suffix === 'csv' ? 'text/csv'
      : 'application/json'}));
    h('a', {href: url, download: `measurements.${suffix}`}).click();
    URL.revokeObjectURL(url);
  }

  draw() {
    const lines = this.app.measures.list.filter(({slice}) => !slice);
    if (lines.length === 0 && this.points.length === 0) {
      if (this.drawing.childElementCount > 0) {
        this.drawing.replaceChildren();
      }
      return;
    }
    this.drawing.replaceChildren(...this.app.picture.eyes().map(eye =>
      s('g', {class: `eye-${eye.name}`}, ...this.marks(lines, eye))));
  }

  /**
   * @param {Measure[]} measures
   * @param {import('../panel/app.js').Eye} eye
   */
  marks(measures, eye) {
    const marks = measures.flatMap(measure => {
      const places = measure.points_mm.map(p_mm => eye.project(p_mm));
      return places.every(({visible}) => visible)
        ? [line(places, `${measure.name}: ${measureText(measure)}`, measure.kind)] : [];
    });
    const places = this.points.map(p_mm => eye.project(p_mm)).filter(({visible}) => visible);
    return places.length > 0 ? [...marks, line(places, '', this.kind)] : marks;
  }
}

/**
 * Lines from place to place, with a label at the middle, or at the vertex of an angle.
 * @param {Place[]} places
 * @param {string} text
 * @param {import('../panel/measures.js').Kind} kind
 */
function line(places, text, kind) {
  const ends = places.slice(1).map(({x, y}, k) =>
    ({x1: places[k].x, y1: places[k].y, x2: x, y2: y}));
  const half = (places.length - 1) / 2;
  const [a, b] = kind === 'angle' ? [places[1] ?? places[0], places[1] ?? places[0]]
    : [places[Math.floor(half)], places[Math.ceil(half)]];
  return s('g', {}, ...ends.map(each => s('line', {class: 'back', ...each})),
    ...ends.map(each => s('line', {class: 'front', ...each})),
    ...places.map(({x, y}) => s('circle', {cx: x, cy: y, r: text ? 3 : 4})),
    text && s('text', {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 - LABEL_ABOVE}, text));
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new MeasurePanel(root, app);
}
