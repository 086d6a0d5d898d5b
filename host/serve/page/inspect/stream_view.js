// Steps through the instruction stream of a region: the pixels after each instruction, and the
// disassembly.
import {contextOf} from '../elements/canvas.js';
import {ENGLISH, h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {LIMITS} from '../link/vocabulary.js';
import {plural, say} from '../texts/say.js';

/**
 * @typedef {object} Scrub              The answer to `ask scrub`.
 * @property {number} at                Executed instructions.
 * @property {number} count             All instructions.
 * @property {number} region
 * @property {number} renderer
 * @property {number} x0                Left edge of the region in the picture.
 * @property {number} y0
 * @property {{at: number, address: string, text: string, meaning: string, effect: string}[]}
 *     lines                          `effect` on the chosen pixel; may be ''.
 * @property {number} enabled           Number of enabled pixels.
 */

const EDGE = LIMITS.region_px;
const DIMMED = 0.35;            // Brightness of a disabled pixel.
const STEP_MS = 80;             // Between steps during playback.
const PLAY_STEPS = 150;         // Steps per playback.
/** Fields of the pixels, named as in `ask scrub`. */
const FIELDS = [['', say`automatic`], ['rgb', say`color`], ['normal', say`normal`],
  ['z', say`depth`], ['surface', say`surface`]];
const PAGE = 256;               // Instructions per Page Up or Page Down.

/**
 * RGBA with disabled pixels dimmed.
 * @param {Uint8Array} from     Bit 0 of alpha: the pixel is enabled.
 * @param {Uint8ClampedArray} to
 */
export function paintRegion(from, to) {
  for (let i = 0; i < to.length; i += 4) {
    const factor = (from[i + 3] & 1) === 1 ? 1 : DIMMED;
    to[i] = from[i] * factor;
    to[i + 1] = from[i + 1] * factor;
    to[i + 2] = from[i + 2] * factor;
    to[i + 3] = 255;
  }
}

export class StreamView {
  /**
   * @param {(question: {ask: string, [key: string]: unknown}) =>
   *   Promise<import('../link/types.js').Answer>} ask
   * @param {(sentence: string) => void} fail
   * @param {(scrub: Scrub) => void} [shown]  Called after each step.
   */
  constructor(ask, fail, shown = () => {}) {
    /** @private */ this.ask_ = ask;
    /** @private */ this.fail_ = fail;
    /** @private */ this.shown_ = shown;
    /** @private @type {{x: number, y: number} | null} */ this.pixel_ = null;
    /** @private @type {Scrub | null} */ this.last_ = null;
    /** @private @type {number[]} */ this.changes_ = [];
    /** @private @type {number | null} */ this.wanted_ = null;
    /** @private */ this.asking_ = false;
    /** @private */ this.playing_ = false;
    this.canvas = h('canvas', {class: 'region', width: EDGE, height: EDGE, role: 'img',
      'data-testid': 'region', 'aria-label': say`Pixels after the executed instructions`});
    /** @private */ this.mark_ = h('div', {class: 'region-mark', 'aria-hidden': 'true'});
    this.slider = h('input', {type: 'range', min: 0, max: 0, value: 0, 'data-testid': 'scrub',
      'aria-label': say`Executed instructions`,
      oninput: () => this.user_(Number(this.slider.value))});
    /** @private */ this.status_ = h('p', {class: 'legend number', 'data-testid': 'scrub-status'});
    /** @private */ this.lines_ = h('ol', {...ENGLISH, class: 'disassembly',
      'data-testid': 'disassembly'});
    /** @private */ this.meaning_ = h('p', {class: 'meaning', 'data-testid': 'scrub-meaning'});
    /** @private */ this.play_ = this.button_(say`Play`, 'scrub-play',
      say`Play the instruction stream`, () => this.setPlaying_(!this.playing_));
    /** @private */ this.field_ = h('select', {'data-testid': 'scrub-field',
      'aria-label': say`Displayed field`,
      onchange: () => this.seek_(this.last_?.at ?? -1)},
    ...FIELDS.map(([value, text]) => h('option', {value}, text)));
    this.element = this.build_();
  }

  /**
   * @private
   * @param {string} text
   * @param {string} testid
   * @param {string} title
   * @param {() => void} act
   */
  button_(text, testid, title, act) {
    return h('button', {type: 'button', 'data-testid': testid, title, onclick: act}, text);
  }

  /** @private */
  build_() {
    const by = (/** @type {number} */ step) => () => this.user_((this.last_?.at ?? 0) + step);
    const element = h('section', {class: 'why-card', 'data-testid': 'stream'},
      h('h3', {}, say`Instructions of the region, step by step`),
      h('div', {class: 'region-frame'}, this.canvas, this.mark_), this.status_, this.slider,
      h('div', {class: 'tool-row'},
        this.button_('«', 'scrub-first', say`Go to the start`, () => this.user_(0)),
        this.button_('‹', 'scrub-back', say`Step back (left arrow)`, by(-1)),
        this.play_,
        this.button_('›', 'scrub-on', say`Step forward (right arrow)`, by(1)),
        this.button_('»', 'scrub-last', say`Go to the end`,
          () => this.user_(this.last_?.count ?? 0)),
        h('label', {class: 'number-field'}, say`show`, this.field_)),
      h('div', {class: 'tool-row'}, h('span', {class: 'muted'}, say`Marked pixel:`),
        this.button_(say`‹ previous change`, 'change-back',
          say`Go to the previous change of this pixel`, () => this.jump_(-1)),
        this.button_(say`next change ›`, 'change-on', say`Go to the next change of this pixel`,
          () => this.jump_(1))),
      this.meaning_, this.lines_,
      h('p', {class: 'legend'}, say`Dark pixels are disabled. Instructions do not write to them.`));
    element.addEventListener('keydown', event => this.key_(event));
    return element;
  }

  /**
   * Opens the stream of the region that contains a pixel, at the end of the stream.
   * @param {number} x
   * @param {number} y
   * @param {number[]} changes    Positions of the writes to that pixel, ascending.
   */
  open(x, y, changes) {
    this.pixel_ = {x, y};
    this.changes_ = changes;
    this.last_ = null;
    this.setPlaying_(false);
    this.seek_(-1);
  }

  /**
   * Goes to a position of the stream, or to its end if the stream is shorter.
   * @param {number} at   Executed instructions.
   */
  goTo(at) {
    this.setPlaying_(false);
    this.seek_(at);
  }

  /** Stops playing. */
  stop() {
    this.setPlaying_(false);
  }

  /**
   * @private
   * @param {number} at   The position that the user chose.
   */
  user_(at) {
    this.setPlaying_(false);
    this.seek_(Math.min(Math.max(at, 0), this.last_?.count ?? 0));
  }

  /**
   * Goes to a position, newest only.
   * @private
   * @param {number} at   -1: the end.
   */
  seek_(at) {
    this.wanted_ = at;
    if (!this.asking_) {
      void this.work_();
    }
  }

  /** @private */
  async work_() {
    this.asking_ = true;
    while (this.wanted_ !== null && this.pixel_) {
      const at = this.wanted_, {x, y} = this.pixel_;
      this.wanted_ = null;
      try {
        const field = this.field_.value;
        const {json, bytes} = await this.ask_({ask: 'scrub', x, y, at, ...(field && {field})});
        if (this.pixel_.x === x && this.pixel_.y === y) {
          this.show_(json, new Uint8Array(bytes));
        }
      } catch (error) {
        this.setPlaying_(false);
        this.fail_(error instanceof Error ? error.message : String(error));
      }
    }
    this.asking_ = false;
  }

  /**
   * @private
   * @param {Scrub} scrub
   * @param {Uint8Array} pixels
   */
  show_(scrub, pixels) {
    this.last_ = scrub;
    const picture = new ImageData(EDGE, EDGE);
    paintRegion(pixels, picture.data);
    contextOf(this.canvas).putImageData(picture, 0, 0);
    const {x, y} = this.pixel_ ?? {x: 0, y: 0};
    this.mark_.style.left = `${(x - scrub.x0 + 0.5) / EDGE * 100}%`;
    this.mark_.style.top = `${(y - scrub.y0 + 0.5) / EDGE * 100}%`;
    this.slider.max = String(scrub.count);
    this.slider.value = String(scrub.at);
    const {count, enabled} = scrub;
    const instructions = plural(count, say`1 instruction`, say`${grouped(count)} instructions`);
    const writable = plural(enabled, say`1 pixel`, say`${grouped(enabled)} pixels`);
    this.status_.textContent = say`${grouped(scrub.at)} of ${instructions} executed,
      region ${scrub.region} on renderer-${scrub.renderer}, ${writable} enabled`;
    const next = scrub.lines.find(line => line.at === scrub.at);
    this.meaning_.replaceChildren(...next
      ? [`${say`Next:`} `, h('span', ENGLISH, `${next.meaning} (${next.address})`)]
      : [say`All instructions are executed.`]);
    this.lines_.replaceChildren(...scrub.lines.map(line => h('li', {
      class: line.at === scrub.at ? 'now' : '', title: line.address,
      'aria-current': line.at === scrub.at ? 'step' : null,
      onclick: () => this.user_(line.at),
    }, h('span', {class: 'muted number'}, grouped(line.at)), h('code', {}, line.text),
    line.effect ? h('span', {class: 'effect'}, line.effect) : '')));
    this.shown_(scrub);
  }

  /**
   * Goes to the previous or next write to the pixel.
   * @private
   * @param {-1 | 1} way
   */
  jump_(way) {
    const at = this.last_?.at ?? 0;
    const to = way > 0 ? this.changes_.find(each => each > at)
      : [...this.changes_].reverse().find(each => each < at);
    if (to !== undefined) {
      this.user_(to);
    }
  }

  /**
   * @private
   * @param {boolean} playing
   */
  setPlaying_(playing) {
    if (playing === this.playing_) {
      return;
    }
    this.playing_ = playing;
    this.play_.textContent = playing ? say`Pause` : say`Play`;
    if (playing) {
      if (this.last_ && this.last_.at >= this.last_.count) {
        this.seek_(0);
      }
      this.tick_();
    }
  }

  /** @private  One step of the playback. Slow replies slow the playback down. */
  tick_() {
    setTimeout(() => {
      const last = this.last_;
      if (!this.playing_ || !last) {
        return;
      }
      if (!this.asking_) {
        if (last.at >= last.count) {
          this.setPlaying_(false);
          return;
        }
        this.seek_(Math.min(last.count, last.at + Math.ceil(last.count / PLAY_STEPS)));
      }
      this.tick_();
    }, STEP_MS);
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   */
  key_(event) {
    if (event.target === this.slider && event.key.startsWith('Arrow')) {
      event.stopPropagation();
      return;
    }
    const steps = new Map([['ArrowLeft', -1], ['ArrowRight', 1], ['PageUp', -PAGE],
      ['PageDown', PAGE]]);
    const step = steps.get(event.key);
    if (step !== undefined) {
      event.preventDefault();
      event.stopPropagation();
      this.user_((this.last_?.at ?? 0) + step);
    }
  }
}
