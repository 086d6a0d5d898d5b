// Panel: distances, angles and paths on surfaces, drawn over the picture; the list of all measures.
import {h, s} from '../elements/dom.js';
import {saveBlob} from '../elements/save_file.js';
import {csvOf, jsonOf} from '../panel/measure_files.js';
import {MeasureList} from '../panel/measure_list.js';
import {Points, measureText} from '../panel/measures.js';
import {choiceRow, intro, messageLine, modeButton, sentenceOf} from '../panel/panel_parts.js';
import {MeasureEnds} from './measure_ends.js';

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
    /** Points of the clicks so far. */
    this.points = new Points('distance');
    /** Ends after all clicks so far: a measurement does not end before the points of its clicks. */
    this.clicked = Promise.resolve();
    this.identity = '';
    /** How many measurements the message knows. */
    this.told = -1;
    this.message = messageLine('measure-message');
    this.ends = new MeasureEnds(app, this.message, {
      grabs: ({name}) => app.modes.current ? app.modes.current.name === MODE
        : name === app.measures.chosen,
      changed: () => this.draw()});
    this.list = new MeasureList(app, 'measure', this.ends.mover, this.message);
    this.drawing = s('g', {class: 'measure', 'data-testid': 'measure-lines'});
    this.build(root);
    this.listen();
  }

  /** @param {HTMLElement} root */
  build(root) {
    const {app} = this;
    this.button = modeButton(app, {name: MODE, title: 'Measure', hint: () => HINTS[this.kind],
      testid: 'measure-mode',
      click: (x, y) => this.afterClicks(() => this.click(x, y)),
      leave: () => this.afterClicks(() => this.finish())});
    const kinds = choiceRow('What to measure', [
      {name: 'distance', title: 'Distance', help: 'Straight line between two points'},
      {name: 'angle', title: 'Angle', help: 'Three points: the second is the vertex'},
      {name: 'path', title: 'Path', help: 'Length of straight lines from point to point'},
    ], kind => this.choose(kind));
    this.done = h('button', {type: 'button', hidden: true, 'data-testid': 'measure-done',
      title: 'Ends the path (Enter)',
      onclick: () => this.afterClicks(() => this.finish())}, 'End path');
    const save = (/** @type {string} */ suffix, /** @type {() => string} */ text) =>
      h('button', {type: 'button', class: 'quiet', 'data-testid': `measure-${suffix}`,
        title: `Saves all measurements as ${suffix.toUpperCase()}`,
        onclick: () => saveBlob(new Blob([text()]), `measurements.${suffix}`)},
      suffix.toUpperCase());
    const volume = () => app.store.state?.volume ?? {name: '', unit: ''};
    this.files = h('div', {class: 'tool-row', hidden: true},
      h('span', {class: 'legend'}, 'Save as'),
      save('csv', () => csvOf(app.measures.list, volume())),
      save('json', () => jsonOf(app.measures.list, volume())), h('span', {class: 'grow'}),
      h('button', {type: 'button', class: 'quiet', 'data-testid': 'measure-delete-all',
        onclick: () => app.measures.removeAll()}, 'Delete all'));
    app.picture.overlay.append(this.drawing);
    root.append(intro('Distances, angles and paths on surfaces. Slices measure, too.'),
      h('div', {class: 'tool-row drives'}, kinds.element, this.button, this.done),
      this.list.element, this.files, this.message.element);
  }

  listen() {
    const {app} = this;
    app.picture.onChange(() => this.draw());
    document.addEventListener('keydown', event => {
      if (event.key === 'Enter' && app.modes.current?.name === MODE && this.kind === 'path') {
        this.afterClicks(() => this.finish());
      }
    });
    app.measures.watch(() => this.show());
    app.connection.on('hello', () => {
      this.told = -1;
      this.show();
    });
    app.store.subscribe(['volume'], ({volume}) => this.open(volume?.identity ?? ''));
    app.session.add('measurements', {
      save: () => app.measures.list, restore: list => app.measures.restore(list)});
  }

  /** @param {string} identity  Another volume clears the measures. */
  open(identity) {
    if (identity !== this.identity) {
      this.identity = identity;
      this.points = new Points(this.kind);
      this.app.measures.clear();
    }
  }

  /**
   * Acts after all clicks so far.
   * @param {() => void | Promise<void>} act
   */
  afterClicks(act) {
    this.clicked = this.clicked.then(act);
  }

  /** @param {LineKind} kind */
  choose(kind) {
    this.kind = kind;
    this.afterClicks(() => {
      this.finish();
      this.points = new Points(kind);
    });
    const {modes} = this.app;
    if (modes.current?.name === MODE) {  // The hint is another one.
      modes.leave(MODE);
      this.button?.click();
    }
  }

  /** Keeps a path of two or more points, and forgets others that are not whole. */
  finish() {
    this.add(this.points.end());
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  async click(x, y) {
    const identity = this.identity;
    // The point of each click is kept: the pixel may show another one at the next click.
    const {ok, error = '', result} = await this.app.connection.do(`pick ${x} ${y}`, {quiet: true});
    if (identity !== this.identity) {
      return;  // The point belongs to a volume that was open before.
    }
    if (!ok || !result?.hit) {
      this.message.fail(ok ? 'There is no surface. Click a point on a surface.' : error);
      return;
    }
    try {
      this.add(this.points.take(result.p_mm));
    } catch (same) {
      this.add(null, sentenceOf(same));
    }
  }

  /**
   * Adds a measurement if there is one, and says what is next, or what is wrong.
   * @param {Omit<Measure, 'name'> | null} measure
   * @param {string} [wrong]
   */
  add(measure, wrong = '') {
    const refusal = wrong || (measure ? this.app.measures.add(measure) : '');
    const isPath = this.points.kind === 'path';
    this.done?.toggleAttribute('hidden', !(isPath && this.points.list.length > 1));
    if (refusal) {
      this.message.fail(refusal);
    } else {
      this.message.say(this.points.sentence +
        (isPath && this.points.list.length > 0 ? ' Click the next point, or press Enter.' : ''));
    }
    this.draw();
  }

  show() {
    const {measures, connection} = this.app;
    const advice = connection.watches ? 'A view-only page measures in slices alone.'
      : 'Press Measure, then click points on a surface.';
    if (measures.list.length !== this.told) {
      this.told = measures.list.length;
      this.message.say(this.told > 0 ? '' : advice);
    }
    this.files?.toggleAttribute('hidden', measures.list.length === 0);
    this.draw();
  }

  draw() {
    const lines = this.app.measures.list.filter(({slice}) => !slice);
    if (lines.length === 0 && this.points.list.length === 0) {
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
      const {held} = this.ends, {name} = measure;
      const places = measure.points_mm.map((p_mm, end) =>
        held?.name === name && held.end === end && held.eye === eye.name
          ? {x: held.x, y: held.y, visible: true} : eye.project(p_mm));
      return places.every(({visible}) => visible)
        ? [line(places, `${name}: ${measureText(measure)}`, measure.kind,
          name === this.app.measures.chosen)] : [];
    });
    const places = this.points.list.map(p_mm => eye.project(p_mm)).filter(({visible}) => visible);
    return places.length > 0 ? [...marks, line(places, '', this.points.kind, false)] : marks;
  }
}

/**
 * Lines from place to place, with a label at the middle, or at the vertex of an angle.
 * @param {Place[]} places
 * @param {string} text
 * @param {import('../panel/measures.js').Kind} kind
 * @param {boolean} isChosen
 */
function line(places, text, kind, isChosen) {
  const ends = places.slice(1).map(({x, y}, k) =>
    ({x1: places[k].x, y1: places[k].y, x2: x, y2: y}));
  const half = (places.length - 1) / 2;
  const [a, b] = kind === 'angle' ? [places[1] ?? places[0], places[1] ?? places[0]]
    : [places[Math.floor(half)], places[Math.ceil(half)]];
  return s('g', {}, ...ends.map(each => s('line', {class: 'back', ...each})),
    ...ends.map(each => s('line', {class: 'front', ...each})),
    ...places.map(({x, y}) => s('circle', {cx: x, cy: y, r: isChosen ? 5 : text ? 3 : 4})),
    text && s('text', {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 - LABEL_ABOVE}, text));
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new MeasurePanel(root, app);
}
