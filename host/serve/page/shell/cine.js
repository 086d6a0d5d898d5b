// The strip below the picture of a time series: plays it, and steps through its volumes.
import {byId, h, setText, update} from '../elements/dom.js';
import {icon, setIcon} from '../elements/icons.js';
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

/** Volumes that are this far apart or less are played in real time, unless the user says else. */
const REAL_TIME_MS = 200;
const RATES = [2, 5, 10, 15, 25];  // Volumes per second.
const USUAL_RATE = 10;
const REAL_TIME = 'time', FASTEST = 'fast';
const RATE_OVER_MS = 2000;
const MOST_LAG_MS = 1000;      // Slices that are late hold up a series for so long.

class Cine {
  /** @param {App} app */
  constructor(app) {
    /** @private */ this.app_ = app;
    /** @private @type {VolumeState | null} */ this.volume_ = null;
    /** @private  The volume that was asked for last. */ this.wanted_ = 1;
    /** @private  Number of requests without a reply. */ this.underWay_ = 0;
    /** @private  Whether a pointer holds the slider. */ this.isHeld_ = false;
    /** @private  Counts the times that play was pressed; 0 while nothing plays. */
    this.playing_ = 0;
    /** @private */ this.presses_ = 0;
    /** @private @type {number[]} When the last volumes were shown. */ this.times_ = [];
    /** @private  Revision of the newest picture that has come. */ this.arrived_ = 0;
    /** @private @type {(() => void) | null} Tries whether the volume is shown everywhere. */
    this.waiting_ = null;
    const button = (/** @type {import('../elements/icons.js').IconName} */ name,
      /** @type {string} */ title, /** @type {() => void} */ act) => h('button', {class: 'icon',
      title, 'aria-label': title, 'data-testid': `cine-${name}`, onclick: act}, icon(name));
    /** @private */
    this.play_ = button('play', say`Play`, () => this.playing_ ? this.pause() : void this.play());
    /** @private */
    this.slider_ = h('input', {type: 'range', min: 1, max: 1, step: 1,
      'aria-label': say`Volume of the time series`, 'data-testid': 'cine-slider',
      onpointerdown: () => { this.isHeld_ = true; },
      onpointerup: () => { this.isHeld_ = false; },
      onpointercancel: () => { this.isHeld_ = false; },
      oninput: () => this.step(Number(this.slider_.value))});
    /** @private */
    this.number_ = h('output', {class: 'number', 'data-testid': 'cine-number'});
    /** @private */
    this.when_ = h('span', {class: 'number when', 'data-testid': 'cine-when'});
    /** @private */
    this.rate_ = h('select', {class: 'small', 'aria-label': say`Speed`, 'data-testid': 'cine-rate',
      title: say`Volumes per second, at most`});
    /** @private */
    this.loops_ = h('input', {type: 'checkbox', checked: true, 'data-testid': 'cine-loop'});
    /** @private  What a page needs that may not change anything. */
    this.controls_ = [button('back', say`One volume back`, () => this.step(this.wanted_ - 1)),
      this.play_, button('on', say`One volume on`, () => this.step(this.wanted_ + 1))];
    byId('cine').append(h('div', {class: 'pair'}, ...this.controls_), this.slider_, this.number_,
      this.when_, this.rate_, h('label', {class: 'small'}, this.loops_, ` ${say`loop`}`));
    app.store.subscribe(['volume'], ({volume}) => this.take(volume));
    app.picture.onShown(() => this.waiting_?.());
    app.connection.on('frame', ({header}) => {
      this.arrived_ = header.revision;
      this.waiting_?.();
    });
    document.addEventListener('sliceshown', () => this.waiting_?.());
    // The state may come after its picture. First all parts take it.
    app.store.subscribe(['revision'], () => queueMicrotask(() => this.waiting_?.()));
    document.addEventListener('pauseseries', () => this.pause());
    app.modes.watch(mode => mode && this.pause());  // A click means the picture that is seen.
    app.connection.on('lost', () => this.pause());
    app.connection.on('hello', () => {
      for (const control of [...this.controls_, this.slider_, this.rate_, this.loops_]) {
        control.disabled = app.connection.watches;
      }
    });
  }

  /** @param {VolumeState | null} volume */
  take(volume) {
    const isOther = volume?.series_identity !== this.volume_?.series_identity;
    this.volume_ = volume;
    byId('cine').hidden = !volume || volume.frames < 2;
    if (!volume) {
      this.pause();
      return;
    }
    if (isOther) {
      this.pause();
      this.wanted_ = volume.frame;
      this.slider_.max = String(volume.frames);
      this.offerRates_(volume);
    }
    const {wanted_: wanted} = this, {frames} = volume;
    if (this.playing_ && ![wanted, wanted - 1 || frames].includes(volume.frame)) {
      this.pause();  // Undo, or another viewer, has chosen another one.
    }
    if (this.underWay_ === 0 && !this.playing_) {
      this.wanted_ = volume.frame;
    }
    if (!this.isHeld_) {
      this.slider_.value = String(this.playing_ ? volume.frame : this.wanted_);
    }
    setText(this.number_, `${volume.frame} / ${volume.frames}`);
    const when = frames > 1 && volume.time_ms >= 0 ? `${grouped(volume.time_ms)} ms` : '';
    update(this.slider_, {'aria-valuetext': when
      ? say`${volume.frame} of ${frames}, at ${when}` : say`${volume.frame} of ${frames}`});
    setText(this.when_, this.playing_ ? this.speedText_() : when);
  }

  /**
   * @private
   * @param {VolumeState} volume
   */
  offerRates_({frame_ms}) {
    const isReal = frame_ms > 0 && frame_ms <= REAL_TIME_MS;
    this.rate_.replaceChildren(
      isReal ? h('option', {value: REAL_TIME}, say`real time (${grouped(1000 / frame_ms)}/s)`) : '',
      ...RATES.map(rate => h('option', {value: rate}, `${rate}/s`)),
      h('option', {value: FASTEST}, say`fastest`));
    this.rate_.value = isReal ? REAL_TIME : String(USUAL_RATE);
  }

  /** @private  Least time between two volumes. */
  get apart_ms_() {
    const {value} = this.rate_;
    return value === REAL_TIME ? this.volume_?.frame_ms ?? 0 : value === FASTEST ? 0
      : 1000 / Number(value);
  }

  /** @private */
  speedText_() {
    const times = this.times_;
    const ms = times.length > 2 ? (times[times.length - 1] - times[0]) / (times.length - 1) : 0;
    return ms > 0 ? `${grouped(1000 / ms, 1)}/s` : '';
  }

  /** @param {number} frame  Beyond the ends, the series goes on at the other end. */
  step(frame) {
    this.pause();
    const frames = this.volume_?.frames ?? 1;
    this.wanted_ = (frame + frames - 1) % frames + 1;
    void this.show_(this.wanted_);
  }

  /**
   * @private
   * @param {number} frame
   */
  async show_(frame) {
    this.underWay_ += 1;
    const reply = await this.app_.connection.set({name: 'time', words: [String(frame)]});
    this.underWay_ -= 1;
    if (!reply.ok && !reply.superseded && this.volume_) {
      this.wanted_ = this.volume_.frame;
    }
    return reply;
  }

  pause() {
    if (this.playing_) {
      this.playing_ = 0;
      this.look_();
    }
  }

  /** @private */
  look_() {
    setIcon(this.play_, this.playing_ ? 'pause' : 'play');
    const title = this.playing_ ? say`Pause` : say`Play`;
    update(this.play_, {title, 'aria-label': title});
    this.take(this.volume_);
  }

  /** Shows one volume after the other, each of them, until it ends or is paused. */
  async play() {
    const turn = this.playing_ = ++this.presses_;
    this.times_ = [];
    this.look_();
    this.app_.connection.mark();  // One undo leads back to the volume of before.
    let [due, before] = [performance.now(), 0];
    while (this.playing_ === turn) {
      const frames = this.volume_?.frames ?? 1;
      if (this.wanted_ >= frames && !this.loops_.checked && this.times_.length > 0) {
        break;
      }
      this.wanted_ = this.wanted_ % frames + 1;
      const {ok, revision = 0} = await this.show_(this.wanted_);
      if (!ok) {
        break;  // The page shows the error.
      }
      await this.shown_(revision, before);
      before = revision;
      const now = performance.now();
      this.times_ = [...this.times_.filter(each => now - each < RATE_OVER_MS), now];
      due = Math.max(due + this.apart_ms_, now - this.apart_ms_);  // What is lost stays lost.
      await new Promise(go => { setTimeout(go, Math.max(0, due - now)); });
    }
    if (this.playing_ === turn) {
      this.pause();
    }
  }

  /**
   * Waits until picture and slices of the volume are there, as far as they are on the screen: until
   * its slices are shown, but only so long, and its picture has come. The picture of the volume
   * before must be shown, so that none is left out.
   * @private
   * @param {number} revision  Of the state with the volume.
   * @param {number} before    Of the state with the volume before; 0 for none.
   * @returns {Promise<void>}
   */
  shown_(revision, before) {
    const {picture, lagging, store} = this.app_;
    return new Promise(go => {
      const due = performance.now() + MOST_LAG_MS;
      const isPictureThere = () => picture.stage.hidden ||
        this.arrived_ >= revision && (picture.header?.revision ?? 0) >= before;
      const areSlicesThere = () => (store.state?.revision ?? 0) >= revision &&
        [...lagging].every(isBehind => !isBehind());
      const attempt = () => {
        if (isPictureThere() && (areSlicesThere() || performance.now() >= due)) {
          this.waiting_ = null;
          clearTimeout(timer);
          go();
        }
      };
      this.waiting_ = attempt;
      const timer = setTimeout(attempt, MOST_LAG_MS);
      attempt();
    });
  }
}

/** @param {App} app */
export function createCine(app) {
  return new Cine(app);
}
