// The part of the dialog "Save" that saves or copies a picture: of the surfaces, or of a slice.
import {contextOf, pngOf} from '../elements/canvas.js';
import {h} from '../elements/dom.js';
import {paintLegend} from '../elements/legend.js';
import {grouped, short} from '../elements/numbers.js';
import {saveBlob} from '../elements/save_file.js';
import {word} from '../link/lines.js';
import {address} from '../link/token.js';
import {placeWarning, volumeTitle} from '../panel/volume_words.js';
import {plural, say} from '../texts/say.js';
import {FREE, SAMPLES, attempt, baseName, choice, eyeSize, sizeChoice, wrongLine}
  from './save_parts.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/types.js').LegendLine} LegendLine */
/** @typedef {{blob: Blob, name: string, told: string}} Made  told: size and samples. */

const SIZES = /** @type {const} */ ([['1', say`as on the screen`], ['2', say`twice`],
  ['3', say`3 times`], ['4', say`4 times`], ['1920x1080', '1920 × 1080'],
  ['3840x2160', '3840 × 2160'], [FREE, say`other size …`]]);
const FORMATS = /** @type {const} */ ([['png', 'PNG'], ['tif', say`TIFF, no marks`],
  ['exr', say`OpenEXR, no marks`]]);
const GROUNDS = /** @type {const} */ ([['shown', say`ground as shown`],
  ['white', say`white ground`], ['transparent', say`transparent ground`]]);
const PNG = 'image/png';
const LONGEST_DOWNLOAD_MS = 120_000;
const SURFACES = 'surfaces';
const NO_CLIPBOARD = say`This browser copies pictures from pages of https:// or localhost only`;

/**
 * @param {App} app
 * @param {HTMLDialogElement} dialog
 */
export function picturePart(app, dialog) {
  const part = new PicturePart(app, dialog);
  return {element: part.element, refresh: () => part.refresh()};
}

class PicturePart {
  /**
   * @param {App} app
   * @param {HTMLDialogElement} dialog
   */
  constructor(app, dialog) {
    this.app = app;
    this.dialog = dialog;
    this.what = choice([], say`What to save`, 'save-picture-what');
    this.size = sizeChoice(SIZES, 'save-picture-size');
    this.format = choice(FORMATS, say`Format`, 'save-picture-format');
    this.samples = choice(SAMPLES, say`Samples per pixel`, 'save-picture-samples');
    this.ground = choice(GROUNDS, say`Ground`, 'save-picture-ground');
    const mark = (/** @type {string} */ testid) =>
      h('input', {type: 'checkbox', checked: true, 'data-testid': testid});
    this.marks = mark('save-overlay');
    this.legend = mark('save-legend');
    this.wrong = wrongLine('save-picture-wrong');
    const hasClipboard = 'ClipboardItem' in globalThis && Boolean(navigator.clipboard?.write);
    const copy = h('button', {'data-testid': 'picture-copy', disabled: !hasClipboard,
      title: hasClipboard ? say`Copies the picture as PNG` : NO_CLIPBOARD,
      onclick: () => void this.copy()}, say`Copy`);
    this.what.addEventListener('change', () => this.show());
    for (const each of [this.what, this.format, this.size.list]) {
      each.addEventListener('change', () => { this.wrong.hidden = true; });
    }
    this.element = h('section', {}, h('h3', {}, say`Picture`),
      h('div', {class: 'row wrap'}, this.what, this.size.list, this.size.free),
      h('div', {class: 'row wrap'}, this.format, this.samples, this.ground),
      h('div', {class: 'row wrap'},
        h('label', {class: 'row'}, this.marks, say`letters, scale, measurements`),
        h('label', {class: 'row'}, this.legend, say`legend`), h('span', {class: 'grow'}), copy,
        h('button', {class: 'primary', 'data-testid': 'snapshot',
          onclick: () => void this.save()}, say`Save picture`)),
      this.wrong);
  }

  /** Offers the views that are shown now. */
  refresh() {
    const chosen = this.what.value;
    const views = this.app.views.list.filter(view => view.size() !== null);
    this.what.replaceChildren(h('option', {value: SURFACES}, say`Surfaces`),
      ...views.map(({name, title}) => h('option', {value: name}, title)));
    this.what.value = views.some(({name}) => name === chosen) ? chosen : SURFACES;
    this.wrong.hidden = true;
    this.show();
  }

  /** A slice has no samples, and the page writes it as PNG. */
  show() {
    const isSlice = this.what.value !== SURFACES;
    this.format.disabled = this.samples.disabled = isSlice;
  }

  /**
   * Nothing for the surfaces.
   * @param {string} name
   */
  viewOf(name) {
    return this.app.views.list.find(view => view.name === name);
  }

  async save() {
    await attempt(this.app, this.dialog, this.wrong, async () => {
      const {blob, name, told} = await this.made(this.format.value);
      saveBlob(blob, name);
      this.app.toasts.info(say`Saved ${name}, ${told}.`);
    });
  }

  async copy() {
    await attempt(this.app, this.dialog, this.wrong, async () => {
      const made = this.made('png');
      // Browsers allow it only while they handle the click, so they get a promise.
      await navigator.clipboard.write(
        [new ClipboardItem({[PNG]: made.then(({blob}) => blob.slice(0, blob.size, PNG))})]);
      this.app.toasts.info(say`Copied the picture, ${(await made).told}.`);
    });
  }

  /**
   * Makes the picture, and closes the dialog as soon as all choices are right.
   * @param {string} format
   * @returns {Promise<Made>}
   */
  async made(format) {
    const view = this.viewOf(this.what.value);
    if (view) {
      return this.madeOf(view);
    }
    const eye = eyeSize(this.app, this.size), marks = this.marks.checked;
    this.dialog.close();
    const name = `${baseName(this.app)}.${format}`;
    const drawing = await this.drawn(name, eye.join('x'));
    const legend = this.legendOf(null);  // Of the volume that was drawn.
    const blob = format === 'png' && (marks || legend.length > 0)
      ? await this.app.picture.marked(drawing, {eye, marks, legend,
        isLight: this.ground.value === 'white' ? true : null})
      : drawing;
    return {blob, name,
      told: `${sizeText(this.app.picture.wholeSize(eye))}, ${this.samplesText()}`};
  }

  samplesText() {
    const count = Number(this.samples.value);
    return plural(count, say`1 sample per pixel`, say`${grouped(count)} samples per pixel`);
  }

  /**
   * The picture of a slice, which the page paints itself.
   * @param {import('../panel/views.js').View} view
   * @returns {Promise<Made>}
   */
  async madeOf(view) {
    const size = this.size.size(view.size() ?? [1, 1]);
    this.dialog.close();
    const painted = view.painted({size, marks: this.marks.checked,
      ground: this.ground.value === 'shown' ? '' : this.ground.value});
    paintLegend(contextOf(painted.canvas), this.app.picture.overlay, this.legendOf(painted),
      painted.scale);
    return {blob: await pngOf(painted.canvas), told: sizeText(size),
      name: `${baseName(this.app)}-${view.name}.png`};
  }

  /**
   * @param {import('../panel/views.js').Painted | null} slice  Null: the surfaces.
   * @returns {LegendLine[]}
   */
  legendOf(slice) {
    const {state} = this.app.store, hasLegend = this.legend.checked;
    const warning = placeWarning(state?.volume ?? null);
    return [
      // The first line of a slice has the zoom.
      ...slice && this.marks.checked ? [line(' ')] : [],
      ...warning && (hasLegend || this.marks.checked) ? [line(warning)] : [],
      ...hasLegend ? [line(state?.volume ? volumeTitle(state.volume) : state?.archive ?? '')] : [],
      ...hasLegend && slice ? [line(slice.caption)] : [],
      ...hasLegend && (slice?.hasSurfaces ?? true) ? surfaceLines(state) : [],
    ];
  }

  /**
   * The machine's picture.
   * @param {string} name
   * @param {string} size  WIDTHxHEIGHT, of one eye's picture.
   * @returns {Promise<Blob>}
   * @throws {Error} with the server's sentence
   */
  async drawn(name, size) {
    const {ok, result, error} = await this.app.connection.do(`snapshot download:${word(name)} `
      + `size=${size} samples=${this.samples.value} overlay=off ground=${this.ground.value}`,
    {quiet: true});
    if (!ok || !result?.download) {
      throw new Error(error ?? say`The picture was not drawn.`);
    }
    const response = await fetch(address(result.download).href,
      {signal: AbortSignal.timeout(LONGEST_DOWNLOAD_MS)});
    if (!response.ok) {
      throw new Error(
        say`The server answered ${response.status} instead of the picture. Save again.`);
    }
    return response.blob();
  }
}

/** @param {number[]} size */
function sizeText([width, height]) {
  return say`${width} × ${height} pixels`;
}

/** @param {string} text */
function line(text) {
  return {color: '', text};
}

/**
 * The visible surfaces.
 * @param {import('../link/vocabulary.js').State | null} state
 * @returns {LegendLine[]}
 */
function surfaceLines(state) {
  const unit = state?.volume?.unit ?? '';
  return (state?.surfaces ?? []).filter(({visible}) => visible).map(({color, name, isovalue}) =>
    ({color, text: `${name}  ${short(isovalue, 3)} ${unit}`.trim()}));
}
