// Panel: distances, angles, paths and notes on surfaces, over the picture; list of all measures.
import {h, s} from '../elements/dom.js';
import {saveBlob} from '../elements/save_file.js';
import {checked} from '../panel/measure_check.js';
import {csvOf, jsonOf} from '../panel/measure_files.js';
import {MeasureList} from '../panel/measure_list.js';
import {Points, labelText} from '../panel/measures.js';
import {editNote} from '../panel/note_editor.js';
import {choiceRow, intro, messageLine, modeButton, sentenceOf} from '../panel/panel_parts.js';
import {MeasureEnds} from './measure_ends.js';
import {drawMarks} from './measure_marks.js';
import {say} from '../texts/say.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('../panel/measures.js').Measure} Measure */
/** @typedef {'distance' | 'angle' | 'path' | 'part' | 'note'} LineKind */
/** @typedef {{x: number, y: number, visible: boolean}} Place  In the picture. */

const MODE = 'measure';
const HINTS = {
  distance: say`Click two points on a surface to measure the distance. Press Esc to stop.`,
  angle: say`Click three points on a surface: the second is the vertex. Press Esc to stop.`,
  path: say`Click the points of a path on a surface. Enter ends it. Press Esc to stop.`,
  part: say`Click a part of a surface to measure its volume. Press Esc to stop.`,
  note: say`Click a point on a surface, then type the note. Press Esc to stop.`,
};
const NO_VOLUME = say`This part has no volume, because it or a part in it has holes.
  The watertight tables leave no holes.`;
const MOST_ERRORS = 3;      // Of a session, in one message.
const ASIDE = 22;           // From the point of a note to the field, CSS pixels.

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
    /** Identity of the shown volume. @type {string | undefined} */
    this.voxels = undefined;
    /** The place of the note that is being written. @type {Triple | null} */
    this.note = null;
    /** Boxes of the labels by name. @type {Map<string, import('../panel/labels.js').Box>} */
    this.boxes = new Map();
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
    this.button = modeButton(app, {name: MODE, title: say`Measure`, hint: () => HINTS[this.kind],
      testid: 'measure-mode',
      click: (x, y) => {
        const {kind} = this;
        this.afterClicks(() => this.click(x, y, kind));
      },
      leave: () => this.afterClicks(() => this.finish())});
    const kinds = choiceRow(say`What to measure`, [
      {name: 'distance', title: say`Distance`, help: say`Straight line between two points`},
      {name: 'angle', title: say`Angle`, help: say`Three points: the second is the vertex`},
      {name: 'path', title: say`Path`, help: say`Length of straight lines from point to point`},
      {name: 'part', title: say`Part`,
        help: say`Volume of a connected part of a surface, or of a cavity in it`},
      {name: 'note', title: say`Note`, help: say`An arrow with a text`},
    ], kind => this.choose(kind));
    this.done = h('button', {type: 'button', hidden: true, 'data-testid': 'measure-done',
      title: say`Ends the path (Enter)`,
      onclick: () => this.afterClicks(() => this.finish())}, say`End path`);
    const save = (/** @type {string} */ suffix, /** @type {() => string} */ text) =>
      h('button', {type: 'button', class: 'quiet', 'data-testid': `measure-${suffix}`,
        title: say`Saves all measurements as ${suffix.toUpperCase()}`,
        onclick: () => saveBlob(new Blob([text()]), `measurements.${suffix}`)},
      suffix.toUpperCase());
    const volume = () => app.store.state?.volume ?? {name: '', unit: ''};
    this.files = h('div', {class: 'tool-row', hidden: true},
      h('span', {class: 'legend'}, say`Save as`),
      save('csv', () => csvOf(app.measures.list, volume())),
      save('json', () => jsonOf(app.measures.list, volume())), h('span', {class: 'grow'}),
      h('button', {type: 'button', class: 'quiet', 'data-testid': 'measure-delete-all',
        onclick: () => app.measures.removeAll()}, say`Delete all`));
    app.picture.overlay.append(this.drawing);
    root.append(
      intro(say`Distances, angles, paths, volumes of parts, and notes on surfaces. Slices measure,
        too.`),
      h('div', {class: 'tool-row drives'}, kinds.element, this.button, this.done),
      this.list.element, this.files, this.message.element);
  }

  listen() {
    const {app} = this;
    app.picture.onChange(() => this.draw());
    document.addEventListener('keydown', event => {
      const isField = event.target instanceof HTMLInputElement;
      if (event.key === 'Enter' && !isField && this.kind === 'path' &&
          app.modes.current?.name === MODE) {
        this.afterClicks(() => this.finish());
      }
    });
    // A finger's press comes again as a mouse's, which must not take the focus from the field.
    app.picture.stage.addEventListener('mousedown', event => {
      if (document.activeElement?.matches('.note-editor')) {
        event.preventDefault();
      }
    });
    app.measures.watch(() => this.show());
    app.connection.on('hello', () => {
      this.told = -1;
      this.show();
    });
    app.store.subscribe(['volume'], ({volume}) => {
      app.measures.show(volume);
      this.open(volume?.series_identity ?? '');
      if (volume?.identity !== this.voxels) {
        this.voxels = volume?.identity;
        this.points = new Points(this.kind);  // None joins points of two volumes.
        this.draw();
      }
    });
    app.session.add('measurements', {
      save: () => app.measures.list, restore: saved => this.restore(saved)});
  }

  /**
   * Takes the measurements of a session that are right, and reports the others.
   * @param {unknown} saved
   */
  restore(saved) {
    const {list, errors} = checked(saved);
    this.app.measures.restore(list);
    const more = errors.length - MOST_ERRORS;
    if (errors.length > 0) {
      this.app.toasts.error([...errors.slice(0, MOST_ERRORS),
        ...more > 0 ? [say`${more} more were left out.`] : []].join('\n'));
    }
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
   * @param {LineKind} kind  What was measured at the click.
   */
  async click(x, y, kind) {
    if (this.rewrite(x, y)) {
      return;
    }
    const {voxels} = this;
    // The point of each click is kept: the pixel may show another one at the next click.
    const isPart = kind === 'part';
    if (isPart) {
      this.message.say(say`Measuring the part …`);
    }
    const {ok, error = '', result} = await this.app.connection.do(
      `pick ${x} ${y}${isPart ? ' part=yes' : ''}`, {quiet: true});
    if (voxels !== this.voxels) {
      return;  // The point belongs to a volume that was shown before.
    }
    if (!ok || !result?.hit) {
      this.message.fail(ok ? say`There is no surface. Click a point on a surface.` : error);
      return;
    }
    if (kind === 'note') {
      this.write(result.p_mm);
      return;
    }
    if (isPart) {
      if (result.slice) {
        this.message.fail(say`There is a slice in front. Hide it, or click a part of a surface.`);
      } else {
        this.addPart(result);
      }
      return;
    }
    try {
      this.add(this.points.take(result.p_mm));
    } catch (same) {
      this.add(null, sentenceOf(same));
    }
  }

  /**
   * Adds the volume of a part, or says why it has none.
   * @param {any} picked  The answer to `pick ... part=yes`.
   */
  addPart({surface, isovalue, p_mm, part}) {
    if (part.volume_ml === undefined) {
      this.add(null, NO_VOLUME);
      return;
    }
    const {cavity, closed, area_mm2} = part;
    this.add({kind: 'part', points_mm: [p_mm], value: part.volume_ml,
      part: {surface, isovalue, cavity, closed, area_mm2}});
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
        (isPath && this.points.list.length > 0 ? ` ${say`Click the next point, or press Enter.`}`
          : ''));
    }
    this.draw();
  }

  show() {
    const {measures, connection} = this.app;
    const advice = connection.watches ? say`A view-only page measures in slices alone.`
      : say`Press Measure, then click points on a surface.`;
    if (measures.list.length !== this.told) {
      this.told = measures.list.length;
      this.message.say(this.told > 0 ? '' : advice);
    }
    this.files?.toggleAttribute('hidden', measures.list.length === 0);
    this.draw();
  }

  draw() {
    const {picture, measures} = this.app;
    const seen = measures.seen.filter(({slice}) => !slice);
    this.boxes = new Map();
    if (seen.length === 0 && this.points.list.length === 0 && !this.note) {
      if (this.drawing.childElementCount > 0) {
        this.drawing.replaceChildren();
      }
      return;
    }
    this.drawing.replaceChildren(...picture.eyes().map(eye => {
      const {group, boxes} = drawMarks(this.seen(seen, eye), eye, picture.height);
      boxes.forEach((box, name) => this.boxes.set(name, box));
      return group;
    }));
  }

  /**
   * The measurements that an eye sees whole, and the points so far.
   * @param {Measure[]} measures
   * @param {import('../panel/app.js').Eye} eye
   * @returns {import('./measure_marks.js').Seen[]}
   */
  seen(measures, eye) {
    const {held} = this.ends, {chosen} = this.app.measures;
    const whole = measures.flatMap(measure => {
      const {name, kind, points_mm} = measure;
      const places = points_mm.map((p_mm, end) =>
        held?.name === name && held.end === end && held.eye === eye.name
          ? {x: held.x, y: held.y, visible: true} : eye.project(p_mm));
      return places.every(({visible}) => visible) ? [{name, kind, places: places.map(pairOf),
        text: labelText(measure), isChosen: name === chosen}] : [];
    });
    const making = [...this.points.list, ...this.note ? [this.note] : []]
      .map(p_mm => eye.project(p_mm)).filter(({visible}) => visible);
    return making.length === 0 ? whole : [...whole, {name: '', kind: this.points.kind,
      places: making.map(pairOf), text: '', isChosen: false}];
  }

  /**
   * Asks for the text of a new note.
   * @param {Triple} p_mm
   */
  write(p_mm) {
    const {picture, measures} = this.app, {voxels} = this;
    const place = picture.eyes()[0]?.project(p_mm) ?? {x: 0, y: 0};
    this.note = p_mm;
    this.draw();
    this.message.say(say`Type the text of the note. Enter keeps it.`);
    this.edit({left: place.x + ASIDE, top: place.y - ASIDE}, '', text => {
      this.note = null;
      const refusal = text !== null && voxels === this.voxels
        ? measures.add({kind: 'note', points_mm: [p_mm], value: 0, text}) : '';
      if (refusal) {
        this.message.fail(refusal);
      }
      this.draw();
    });
  }

  /**
   * Changes the note whose text is at a pixel. Returns whether there is one.
   * @param {number} x
   * @param {number} y
   */
  rewrite(x, y) {
    const {picture, measures} = this.app;
    const at = picture.placeOfPixel(x, y);
    const found = at && [...this.boxes].find(([name, {left, top, width, height}]) =>
      measures.named(name)?.kind === 'note' && at.x >= left && at.x <= left + width &&
      at.y >= top && at.y <= top + height);
    if (found) {
      const [name, box] = found;
      this.edit(box, measures.named(name)?.text ?? '', text =>
        text !== null && measures.write(name, text));
    }
    return Boolean(found);
  }

  /**
   * @param {{left: number, top: number}} at  Places of the picture.
   * @param {string} text
   * @param {(text: string | null) => void} done
   */
  edit({left, top}, text, done) {
    const {stage, overlay} = this.app.picture;
    const outer = stage.parentElement?.getBoundingClientRect() ?? stage.getBoundingClientRect();
    const inner = overlay.getBoundingClientRect();
    editNote(stage, [left + inner.left - outer.left, top + inner.top - outer.top], text, done);
  }
}

/**
 * @param {Place} place
 * @returns {[number, number]}
 */
function pairOf({x, y}) {
  return [x, y];
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new MeasurePanel(root, app);
}
