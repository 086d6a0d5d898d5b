// The list of measurements: names, values, and the ends of the chosen one.
import {h, setText} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {kindWord, partText, slabNote, valuesText} from './measure_words.js';
import {MOST_NOTE, endTitle, measureText} from './measures.js';

/** @typedef {import('./measures.js').Measure} Measure */

const FAR = 10;             // Steps of an arrow key with Shift.
const MOVES = new Map([['ArrowLeft', [-1, 0]], ['ArrowRight', [1, 0]], ['ArrowUp', [0, -1]],
  ['ArrowDown', [0, 1]]]);

/**
 * How a panel moves the ends of measurements.
 * @typedef {object} Mover
 * @property {(measure: Measure) => string} refusal  Why it cannot; empty if it can.
 * @property {string} hint                           What the arrow keys do.
 * @property {(measure: Measure, end: number) => void} look   The end has the focus.
 * @property {(measure: Measure, end: number, across: number, down: number) => void} move
 * @property {() => void} leave                      The focus is lost: the movement is over.
 */

/** @typedef {{element: HTMLElement, shape: string, update: (measure: Measure) => void}} Row */

export class MeasureList {
  /**
   * @param {import('./app.js').App} app
   * @param {string} testid      Before the names of all its elements for tests.
   * @param {Mover} mover
   * @param {{say: (text: string) => void, fail: (text: string) => void}} message
   */
  constructor(app, testid, mover, message) {
    /** @private */ this.app_ = app;
    /** @private */ this.testid_ = testid;
    /** @private */ this.mover_ = mover;
    /** @private */ this.message_ = message;
    /** @private @type {Map<string, Row>} */ this.rows_ = new Map();
    this.element = h('ul', {class: 'distances', 'data-testid': `${testid}-list`,
      'aria-label': say`Measurements`});
    app.measures.watch(() => this.show());
  }

  /** Changes only what differs, so that the focus stays in an end that moves. */
  show() {
    const {measures} = this.app_;
    const rows = measures.list.map(measure => {
      const isChosen = measure.name === measures.chosen;
      const shape = `${measure.kind} ${isChosen && [measure.points_mm.length, measure.text]}`;
      const known = this.rows_.get(measure.name);
      const row = known?.shape === shape ? known : this.row_(measure, isChosen, shape);
      row.update(measure);
      return /** @type {const} */ ([measure.name, row]);
    });
    this.rows_ = new Map(rows);
    const elements = rows.map(([, {element}]) => element);
    const isSame = elements.length === this.element.childElementCount &&
      elements.every((element, k) => element === this.element.children[k]);
    if (!isSame) {
      this.element.replaceChildren(...elements);
    }
  }

  /**
   * @private
   * @param {Measure} measure
   * @param {boolean} isChosen
   * @param {string} shape
   * @returns {Row}
   */
  row_({name, kind, points_mm}, isChosen, shape) {
    const {measures} = this.app_;
    const value = h('b', {class: 'number'}), values = h('div', {class: 'legend'});
    const choose = h('button', {type: 'button', class: 'quiet badge', 'aria-expanded': isChosen,
      'aria-label': say`Measurement ${name}`, title: say`Shows its ends and its name`,
      'data-testid': `${this.testid_}-choose-${name}`, onclick: () => {
        measures.choose(isChosen ? '' : name);
        this.showVolume_(measures.named(name));
        /** @type {HTMLElement | null | undefined} */
        (this.rows_.get(name)?.element.querySelector('.badge'))?.focus();
      }}, name);
    const element = h('li', {class: isChosen ? 'chosen' : ''}, h('div', {class: 'tool-row'}, choose,
      h('div', {class: 'grow'}, value,
        kind !== 'distance' && h('span', {class: 'legend'}, ` ${kindWord(kind)}`), values),
      h('button', {type: 'button', class: 'quiet', 'aria-label': say`Delete measurement ${name}`,
        title: say`Delete`, 'data-testid': `${this.testid_}-delete-${name}`,
        onclick: () => measures.remove(name)}, '×')),
    isChosen && this.more_(name, points_mm.length));
    return {element, shape, update: measure => {
      setText(value, measureText(measure));
      const unit = this.app_.store.state?.volume?.unit ?? '';
      setText(values, [measure.values
        ? `${valuesText(measure.values, unit)}${slabNote(measure.slice)}`
        : measure.part ? partText(measure.part, unit) : '',
      measures.isSeen(measure) ? '' : say`of volume ${measure.frame ?? 1}`]
        .filter(Boolean).join(', '));
    }};
  }

  /**
   * Shows the volume of the time series that the chosen measurement belongs to.
   * @private
   * @param {Measure | null} measure
   */
  showVolume_(measure) {
    const {measures, store, connection} = this.app_;
    if (!measure || measure.name !== measures.chosen || measures.isSeen(measure)) {
      return;
    }
    const {name, frame = 1} = measure, isThere = frame <= (store.state?.volume?.frames ?? 1);
    if (isThere && !connection.watches) {
      document.dispatchEvent(new Event('pauseseries'));
      void connection.do(`time ${frame}`);
    } else {
      this.message_.fail(isThere
        ? say`Measurement ${name} belongs to volume ${frame}, which is not shown.`
        : say`Measurement ${name} belongs to volume ${frame}, which this scan does not have.`);
    }
  }

  /**
   * Name and ends of the chosen measurement.
   * @private
   * @param {string} name
   * @param {number} count  Of its ends.
   */
  more_(name, count) {
    const {measures} = this.app_;
    const field = h('input', {type: 'text', value: name, maxlength: 60,
      'aria-label': say`Name of measurement ${name}`, 'data-testid': `${this.testid_}-name`,
      onchange: () => {
        const refusal = measures.rename(name, field.value);
        if (refusal) {
          field.value = name;
          this.message_.fail(refusal);
        }
      }});
    const note = measures.named(name)?.text;
    const text = note !== undefined && h('input', {type: 'text', value: note, maxlength: MOST_NOTE,
      'aria-label': say`Text of note ${name}`, 'data-testid': `${this.testid_}-text`,
      onchange: (/** @type {Event} */ event) =>
        measures.write(name, /** @type {HTMLInputElement} */ (event.target).value)});
    return h('div', {class: 'tool-row'}, h('label', {class: 'number-field'}, say`Name`, field),
      text && h('label', {class: 'number-field grow'}, say`Text`, text),
      ...Array.from({length: count}, (_, end) => this.end_(name, end, count)));
  }

  /**
   * @private
   * @param {string} name
   * @param {number} end
   * @param {number} count
   */
  end_(name, end, count) {
    const {measures} = this.app_, mover = this.mover_;
    /** @param {(measure: Measure) => void} act */
    const withMeasure = act => {
      const measure = measures.named(name);
      const refusal = !measure ? '' : measures.isSeen(measure) ? mover.refusal(measure)
        : say`Measurement ${name} belongs to volume ${measure.frame ?? 1}. Show that volume
          first.`;
      if (measure && !refusal) {
        act(measure);
      } else if (refusal) {
        this.message_.fail(refusal);
      }
    };
    const own = measures.named(name);
    const title = endTitle(own?.kind ?? 'path', end, count);
    const hint = own && mover.refusal(own) || mover.hint;
    return h('button', {type: 'button', 'data-testid': `${this.testid_}-end-${end}`,
      'aria-label': say`${title} of measurement ${name}. ${hint}`, title: hint,
      onfocus: () => {
        const measure = measures.named(name);
        if (measure) {
          this.message_.say(hint);
          mover.look(measure, end);
        }
      },
      onblur: () => mover.leave(),
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        const move = MOVES.get(event.key), far = event.shiftKey ? FAR : 1;
        if (move && !event.ctrlKey && !event.metaKey && !event.altKey) {
          event.preventDefault();
          event.stopPropagation();
          withMeasure(measure => mover.move(measure, end, move[0] * far, move[1] * far));
        }
      }}, title);
  }
}
