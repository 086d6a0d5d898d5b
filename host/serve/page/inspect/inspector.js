// Panel: explains the color of a pixel, and steps through the stream of its region.
import {CellView} from './cell_view.js';
import {h, s} from '../elements/dom.js';
import {intro, messageLine, modeButton} from '../panel/panel_parts.js';
import {StreamView} from './stream_view.js';
import {say} from '../texts/say.js';
import {cardsOf, changesOf} from './why_cards.js';

/**
 * The `detail` of the event `explained` on `document`.
 * @typedef {object} Explained
 * @property {import('./why_cards.js').Why | null} result  null after an error.
 * @property {number} revision          Of the scene.
 * @property {string} error             '' without an error.
 * @property {'user' | 'tour'} by       Who asked.
 */

const MODE = 'inspect';
const HINT = say`Click a pixel to explain its color. Press Esc to stop.`;
const EMPTY = say`Press Inspect, then click a pixel in the picture.`;
const WATCHING = say`A view-only page cannot inspect.`;

const testIdOf = (/** @type {Element} */ element) => element.getAttribute('data-testid');

/** @param {Explained} explained */
function announce(explained) {
  document.dispatchEvent(new CustomEvent('explained', {detail: explained}));
}

class InspectorPanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    this.cell = new CellView();
    this.message = messageLine('inspector-message');
    this.stream = new StreamView(question => app.connection.ask(question),
      sentence => this.message.fail(sentence),
      scrub => document.dispatchEvent(new CustomEvent('stepped', {detail: scrub})));
    this.cards = h('div', {class: 'why-chain', 'data-testid': 'why-cards'});
    this.stream.element.hidden = true;
    /** Number of the newest question. Replies to older questions are dropped. */
    this.asked = 0;
    this.revision = 0;
    /** @type {{x: number, y: number} | null}  The pixel that the cards explain. */
    this.pixel = null;
    this.ring = s('g', {class: 'inspected'});
    this.x = this.field('x');
    this.y = this.field('y');
    const button = modeButton(app, {name: MODE, title: say`Inspect`, hint: HINT,
      testid: 'inspect-mode', click: (x, y) => void this.ask(x, y)});
    const form = h('form', {class: 'tool-row drives', onsubmit: (/** @type {Event} */ event) => {
      event.preventDefault();
      void this.ask(this.x.valueAsNumber, this.y.valueAsNumber);
    }}, button, h('span', {class: 'muted'}, say`or pixel`), this.x, this.y,
    h('button', {type: 'submit', 'data-testid': 'why-ask'}, say`Why?`));
    root.append(intro(say`Explains the color of a pixel, back to eight voxels.`),
      form, this.message.element, this.cards, this.stream.element);
    app.connection.on('hello', () => {
      if (this.revision === 0) {
        this.message.say(app.connection.watches ? WATCHING : EMPTY);
      }
    });
    app.picture.overlay.append(this.ring);
    app.picture.onChange(() => this.mark());
    app.picture.onShown(header => this.outdated(header.revision));
    root.addEventListener('panelhide', () => this.stream.stop());
    document.addEventListener('explain', event => {
      const {x, y} = /** @type {CustomEvent} */ (event).detail;
      void this.ask(x, y, 'tour');
    });
    document.addEventListener('step-to', event =>
      this.stream.goTo(/** @type {CustomEvent<number>} */ (event).detail));
  }

  /** @param {string} name */
  field(name) {
    return h('input', {type: 'number', min: 0, step: 1, required: true, class: 'pixel',
      'aria-label': say`Pixel ${name}`, title: say`Pixel ${name}`,
      'data-testid': `why-${name}`});
  }

  /**
   * @param {number} x    Pixel of the picture.
   * @param {number} y
   * @param {Explained['by']} [by]
   */
  async ask(x, y, by = 'user') {
    const number = ++this.asked;
    this.x.value = String(x);
    this.y.value = String(y);
    this.message.say(say`Explaining pixel (${x}, ${y}) …`);
    const reply = await this.app.connection.do(`why ${x} ${y}`, {quiet: true});
    if (number !== this.asked) {
      return;
    }
    if (!reply.ok) {
      this.message.refuse(reply);
      announce({result: null, revision: reply.revision ?? 0, error: reply.error ?? '', by});
      return;
    }
    this.revision = reply.revision ?? 0;
    this.cards.classList.remove('outdated');
    const unfolded = [...this.cards.querySelectorAll('details[open]')].map(testIdOf);
    this.cards.replaceChildren(...cardsOf(reply.result, this.cell));
    for (const details of this.cards.querySelectorAll('details')) {
      details.open = unfolded.includes(testIdOf(details));
    }
    this.stream.element.hidden = false;
    this.stream.open(x, y, changesOf(reply.result));
    this.pixel = {x, y};
    this.mark();
    this.tellSamples();
    const {shown, visits} = reply.result;
    const p_mm = visits[shown]?.cell?.hit_mm;
    if (p_mm) {
      document.dispatchEvent(new CustomEvent('place', {detail: {p_mm, from: MODE}}));
    }
    announce({result: reply.result, revision: this.revision, error: '', by});
  }

  /** Marks the explained pixel until the picture changes. */
  mark() {
    const place = this.pixel && this.app.picture.placeOfPixel(this.pixel.x, this.pixel.y);
    if (place) {
      const {x, y} = place;
      this.ring.replaceChildren(s('circle', {class: 'back', cx: x, cy: y, r: 6}),
        s('circle', {class: 'front', cx: x, cy: y, r: 6}));
    } else {
      this.ring.replaceChildren();
    }
  }

  /** @param {number} revision  Revision of the displayed frame. */
  outdated(revision) {
    if (this.revision !== 0 && revision > this.revision && this.cards.childElementCount > 0) {
      this.cards.classList.add('outdated');
      this.pixel = null;
      this.mark();
      this.message.say(say`The picture has changed. This explains the previous picture.`);
    } else {
      this.tellSamples();
    }
  }

  /** Says how the shown pixel differs from the explained sample, if it is the mean of several. */
  tellSamples() {
    const {picture} = this.app, samples = picture.header?.samples ?? 1;
    if (this.pixel && this.cards.childElementCount > 0) {
      this.message.say(samples === 1 ? '' :
        say`The picture shows ${picture.colorAt(this.pixel)}, the mean of ${samples} samples of
        the pixel. This explains one sample, at the pixel's center.`);
    }
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new InspectorPanel(root, app);
}
