// Clip planes: one for each side of the patient, and a box.
import {h} from '../elements/dom.js';
import {short} from '../elements/numbers.js';
import {plain} from '../link/lines.js';
import {gesture, show} from '../panel/gesture.js';
import {SIDES} from '../picture/projection.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').ClipState} ClipState */

const SIDE_NAMES = new Map([['L', say`left`], ['R', say`right`], ['A', say`anterior`],
  ['P', say`posterior`], ['S', say`superior`], ['I', say`inferior`]]);
const AXIS = new Map([['L', 0], ['R', 0], ['A', 1], ['P', 1], ['S', 2], ['I', 2]]);

/** @param {string} letter */
function sideName(letter) {
  return SIDE_NAMES.get(letter) ?? '';
}

/**
 * @param {HTMLElement} root
 * @param {App} app
 */
export function createClips(root, app) {
  const list = h('div', {id: 'clips', 'data-testid': 'clip-list'});
  const buttons = SIDES.map(({letter}) => h('button', {'data-testid': `clip-add-${letter}`,
    title: say`Keep only the ${sideName(letter)} half, then move the plane`,
    'aria-label': say`Keep the ${sideName(letter)} side`,
    onclick: () => {
      app.connection.mark();
      void app.connection.do(`clip ${letter}`);
    }}, letter));
  const box = h('button', {'data-testid': 'clip-add-box',
    title: say`Keep a box in the middle of the volume`, onclick: () => clipBox(app)}, say`Box`);
  root.append(h('p', {class: 'muted'}, say`Keep only this side of the patient:`),
    h('div', {class: 'chips', role: 'group', 'aria-label': say`Add a clip plane`}, ...buttons, box),
    list);
  /** @type {Map<string, PlaneRow>} */
  const rows = new Map();
  app.store.subscribe(['clips', 'volume'], state => {
    // The six planes of a box have the same words.
    const words = [...new Set(state.clips.map(each => each.words))];
    const kinds = words.map(each => each.split(' ')[0]);
    for (const [kind, row] of rows) {
      if (!kinds.includes(kind)) {
        row.root.remove();
        rows.delete(kind);
      }
    }
    words.forEach((text, index) => {
      const kind = kinds[index];
      const row = rows.get(kind) ?? new PlaneRow(app, kind);
      rows.set(kind, row);
      list.append(row.root);
      row.show(text);
    });
    buttons.forEach((button, index) => {
      button.setAttribute('aria-pressed', String(kinds.includes(SIDES[index].letter)));
    });
    box.setAttribute('aria-pressed', String(kinds.includes('box')));
  });
}

/** @param {App} app */
function clipBox({connection, store}) {
  const size = store.state?.volume?.size;
  if (size) {
    const at = (/** @type {number} */ share) =>
      size.map(n => Math.round((n - 1) * share)).join(',');
    connection.mark();
    void connection.do(`clip box ${at(0.25)} ${at(0.75)}`);
  }
}

/** A plane with its position in millimeters, or the box with its corners in voxels. */
class PlaneRow {
  /**
   * @param {App} app
   * @param {string} kind  A letter, or 'box'.
   */
  constructor(app, kind) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.kind_ = kind;
    const off = () => void app.connection.do(`clip ${kind} off`);
    const remove = h('button', {class: 'quiet icon', title: say`Remove`, onclick: off,
      'aria-label': kind === 'box' ? say`Remove the clip plane box`
        : say`Remove the clip plane ${kind}`, 'data-testid': `clip-off-${kind}`}, '×');
    /** @private */
    this.place_ = h('input', {type: 'range', step: 0.5, 'data-testid': `clip-place-${kind}`,
      'aria-label': say`Position of the plane that keeps the ${sideName(kind)} side`,
      ...gesture(app.connection, () => void app.connection.set({name: 'clip',
        words: [kind, this.place_.value]}))});
    /** @private */
    this.text_ = h('span', {class: 'number amount'});
    /** @private */
    this.corners_ = h('input', {type: 'text', class: 'grow mono', 'data-testid': 'clip-corners',
      'aria-label': say`First and last voxel of the box, each as I,J,K`,
      onchange: () => void app.connection.do(`clip box ${this.corners_.value}`)});
    const flip = h('button', {class: 'quiet icon', 'data-testid': `clip-flip-${kind}`,
      title: say`Keep the other side`, 'aria-label': say`Flip the clip plane ${kind}`,
      onclick: () => void app.connection.do(`clip ${kind} flip`)}, '⇄');
    this.root = kind === 'box'
      ? h('div', {class: 'row'}, h('span', {class: 'field'}, say`box`), this.corners_, remove)
      : h('div', {class: 'row'}, h('span', {class: 'field'}, sideName(kind)), this.place_,
        this.text_, flip, remove);
  }

  /** @param {string} words  `words` of the state. */
  show(words) {
    if (this.kind_ === 'box') {
      show(this.corners_, words.replace(/^box /, ''));
      return;
    }
    const volume = this.app_.store.state?.volume;
    const axis = AXIS.get(this.kind_);
    if (volume && axis !== undefined) {
      // Places are counted towards the side that is kept.
      const center = volume.center_mm[axis] * ('RAI'.includes(this.kind_) ? -1 : 1);
      this.place_.min = plain(center - volume.radius_mm, 0);
      this.place_.max = plain(center + volume.radius_mm, 0);
    }
    const at = words.split(' ')[1] ?? '0';
    show(this.place_, at);
    this.text_.textContent = `${short(Number(at), 1)} mm`;
  }
}
