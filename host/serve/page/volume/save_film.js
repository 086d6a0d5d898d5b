// The part of the dialog "Save" that makes a film: a turntable, a sweep of an isovalue, or the
// volumes of a time series.
import {DATA, h} from '../elements/dom.js';
import {grouped, short} from '../elements/numbers.js';
import {saveAs} from '../elements/save_file.js';
import {plain, word} from '../link/lines.js';
import {address} from '../link/token.js';
import {plural, say} from '../texts/say.js';
import {FREE, SAMPLES, attempt, baseName, choice, eyeSize, numberInput, sizeChoice, wrongLine}
  from './save_parts.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */

const KINDS = /** @type {const} */ ([['turntable', say`Turntable`],
  ['sweep', say`Sweep of an isovalue`], ['cine', say`Time series`]]);
const SIZES = /** @type {const} */ ([['1', say`as on the screen`], ['1280x720', '1280 × 720'],
  ['1920x1080', '1920 × 1080'], ['3840x2160', '3840 × 2160'], [FREE, say`other size …`]]);
const GROUNDS = /** @type {const} */ ([['shown', say`ground as shown`],
  ['white', say`white ground`], ['black', say`black ground`]]);
const MOST_PICTURES = 10000;
const MOST_RATE = 60;       // Pictures per second.
// Volumes of a series that are so far apart are shown in real time, others at 25 per second.
const REAL_TIME_MS = [1000 / MOST_RATE, 200];
const MOST_DEGREES = 36000;
const MOST_VALUE = 1e9;
const WIDTH = 0.25;     // A sweep goes so far to both sides at first, as a share of all values.

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
export function filmPart(app, dialog) {
  const part = new FilmPart(app, dialog);
  return {element: part.element, refresh: () => part.refresh()};
}

class FilmPart {
  /**
   * @param {App} app
   * @param {HTMLDialogElement} dialog
   */
  constructor(app, dialog) {
    this.app = app;
    this.dialog = dialog;
    this.kind = choice(KINDS, say`Kind of film`, 'film-kind');
    this.size = sizeChoice(SIZES, 'film-size');
    this.samples = choice(SAMPLES, say`Samples per pixel of the film`, 'film-samples');
    this.ground = choice(GROUNDS, say`Ground of the film`, 'film-ground');
    this.surface = choice([], say`Surface`, 'film-surface');
    this.degrees = numberInput(say`Degrees`, {value: 360, low: -MOST_DEGREES,
      high: MOST_DEGREES, isWhole: false}, 'film-degrees');
    const value = {value: 0, low: -MOST_VALUE, high: MOST_VALUE, isWhole: false};
    this.from = numberInput(say`First isovalue`, value, 'film-from');
    this.to = numberInput(say`Last isovalue`, value, 'film-to');
    this.pictures = numberInput(say`Pictures`, {value: 100, low: 2, high: MOST_PICTURES},
      'film-pictures');
    this.rate = numberInput(say`Pictures per second`,
      {value: 25, low: 1, high: MOST_RATE, isWhole: false}, 'film-rate');
    this.wrong = wrongLine('film-wrong');
    this.turn = h('span', {class: 'row'}, say`over`, this.degrees.input, say`degrees`);
    this.range = h('span', {class: 'row wrap', hidden: true}, say`of`, this.surface,
      say`from`, this.from.input, say`to`, this.to.input);
    this.count = h('span', {class: 'row'}, this.pictures.input, say`pictures,`);
    this.duration = h('span', {class: 'muted', 'data-testid': 'film-duration'});
    this.element = h('section', {}, h('h3', {}, say`Film`),
      h('div', {class: 'row wrap'}, this.kind, this.turn, this.range),
      h('div', {class: 'row wrap'}, this.size.list, this.size.free, this.samples, this.ground),
      h('div', {class: 'row wrap'}, this.count, this.rate.input, say`per second`, this.duration,
        h('span', {class: 'grow'}),
        h('button', {class: 'primary', 'data-testid': 'film-go',
          onclick: () => void attempt(app, dialog, this.wrong, () => this.make())},
        say`Make film`)),
      this.wrong);
    this.kind.addEventListener('change', () => {
      const {frame_ms} = this.series(), [least, most] = REAL_TIME_MS;
      if (this.kind.value === 'cine' && frame_ms >= least && frame_ms <= most) {
        this.rate.input.value = plain(1000 / frame_ms);
      }
      this.show();
    });
    this.surface.addEventListener('change', () => this.suggest());
    this.element.addEventListener('input', () => {
      this.wrong.hidden = true;
      this.tellDuration();
    });
    this.tellDuration();
  }

  /** Offers the surfaces of the scene. */
  refresh() {
    const names = this.offered().map(({name}) => name), chosen = this.surface.value;
    this.surface.replaceChildren(...names.map(name => h('option', {...DATA, value: name}, name)));
    this.wrong.hidden = true;
    if (names.includes(chosen)) {
      this.surface.value = chosen;
    } else {
      this.surface.value = names.includes(this.app.selection.name) ? this.app.selection.name
        : names[0] ?? '';
      this.suggest();
    }
    const cine = this.kind.options[KINDS.length - 1], {frames} = this.series();
    cine.hidden = cine.disabled = frames < 2;
    if (cine.hidden && this.kind.value === 'cine') {
      this.kind.value = 'turntable';
    }
    this.show();
  }

  /** The time series that is open; one volume if none is. */
  series() {
    return this.app.store.state?.volume ?? {frames: 1, frame_ms: 0};
  }

  /** The surfaces that a sweep can change: of a volume, and no part of a comparison. */
  offered() {
    const {state} = this.app.store;
    return (state?.volume ? state.surfaces : []).filter(({compared_with}) => compared_with === '');
  }

  show() {
    this.turn.hidden = this.kind.value !== 'turntable';
    this.range.hidden = this.kind.value !== 'sweep';
    this.count.hidden = this.kind.value === 'cine';
    this.tellDuration();
  }

  /** Suggests a range around the isovalue, within the values of the volume. */
  suggest() {
    const {volume} = this.app.store.state ?? {};
    const surface = this.offered().find(({name}) => name === this.surface.value);
    if (!volume || !surface) {
      return;
    }
    const reach = (volume.maximum - volume.minimum) * WIDTH;
    this.from.input.value = plain(Math.max(volume.minimum, surface.isovalue - reach));
    this.to.input.value = plain(Math.min(volume.maximum, surface.isovalue + reach));
  }

  tellDuration() {
    const count = this.kind.value === 'cine' ? this.series().frames
      : Number(this.pictures.input.value);
    const seconds = count / Number(this.rate.input.value);
    this.duration.textContent = Number.isFinite(seconds) ? `${short(seconds)} s` : '';
  }

  /** Makes the film, and closes the dialog as soon as all choices are right. */
  async make() {
    const {app} = this, isSweep = this.kind.value === 'sweep';
    if (isSweep && this.surface.value === '') {
      throw new Error(say`There is no surface to sweep. Add a surface first.`);
    }
    const name = `${baseName(app)}-${this.kind.value}.webm`, isCine = this.kind.value === 'cine';
    const pictures = isCine ? this.series().frames : this.pictures.value();
    const what = isCine ? `cine download:${word(name)}`
      : isSweep ? `sweep ${word(this.surface.value)} ${this.from.value()} ${this.to.value()} `
      + `${pictures} download:${word(name)}`
      : `orbit ${pictures} download:${word(name)} degrees=${this.degrees.value()}`;
    const line = `${what} rate=${this.rate.value()} size=${eyeSize(app, this.size).join('x')} `
      + `samples=${this.samples.value} ground=${this.ground.value}`;
    this.dialog.close();
    const {ok, result, error} = await app.connection.do(line, {quiet: true});
    if (!ok || !result?.download) {
      throw new Error(error ?? say`The film was not made.`);
    }
    saveAs(address(result.download).href, name);
    const count = plural(pictures, say`1 picture`, say`${grouped(pictures)} pictures`);
    app.toasts.info(say`Saved ${name}, ${count}, ${short(result.duration_s)} s.`);
  }
}
