// One surface in the list: a row, and details if the surface is chosen.
import {DATA, ENGLISH, h, setText, update} from '../elements/dom.js';
import {grouped, percent, rewritten, short} from '../elements/numbers.js';
import {isoCommand, plain, word} from '../link/lines.js';
import {gesture, show, touch} from '../panel/gesture.js';
import {plural, say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */
/** @typedef {import('../state/selection.js').Selection} Selection */

const TABLE_NAMES = new Map([['watertight', say`watertight`], ['lorensen1987', say`tables of 1987`],
  ['asymptotic', say`asymptotic decider`]]);
const LEAST_ML = [0.1, 1, 10, 100];
const ISO_DIGITS = 7;  // Significant digits of an isovalue in its field.

/**
 * Says that a surface has no triangles, and why if its isovalue is outside of the volume's range.
 * @param {number} isovalue
 * @param {import('../link/vocabulary.js').VolumeState | null | undefined} volume
 */
function nothingAt(isovalue, volume) {
  if (!volume || isovalue >= volume.minimum && isovalue <= volume.maximum) {
    return say`No surface at this value.`;
  }
  const low = short(volume.minimum, 3);
  const high = `${short(volume.maximum, 3)} ${volume.unit}`.trimEnd();
  return isovalue < volume.minimum
    ? say`No surface at this value: it is below the range of the volume, ${low} to ${high}.`
    : say`No surface at this value: it is above the range of the volume, ${low} to ${high}.`;
}

/** @param {SurfaceState} surface */
function sizes({triangles, area_mm2, volume_ml, extraction_ms, components}) {
  const mesh = plural(triangles, say`1 triangle`, say`${grouped(triangles)} triangles`);
  const area = grouped(area_mm2 / 100, 1), ml = grouped(volume_ml, 1);
  const ms = grouped(extraction_ms, 0);
  const isFiltered = components !== '' && components !== 'all';
  return isFiltered ? say`${mesh}, ${area} cm², ${ml} ml (all parts), extracted in ${ms} ms`
    : say`${mesh}, ${area} cm², ${ml} ml, extracted in ${ms} ms`;
}

export class SurfaceCard {
  /**
   * @param {App} app
   * @param {Selection} selection
   * @param {string} name
   */
  constructor(app, selection, name) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.name_ = name;
    const set = (/** @type {Record<string, string>} */ options) => {
      void app.connection.set({name: 'surface', words: [name], options});
    };
    const id = `surface-${name}`;
    /** @private */
    this.color_ = h('input', {type: 'color', 'aria-label': say`Color of ${name}`,
      'data-testid': `surface-color-${name}`,
      ...gesture(app.connection, () => set({color: this.color_.value}))});
    /** @private */
    this.visible_ = h('input', {type: 'checkbox', 'aria-label': say`Show ${name}`,
      'data-testid': `surface-visible-${name}`,
      onchange: () => {
        touch(this.visible_);
        app.connection.mark();
        set({visible: this.visible_.checked ? 'yes' : 'no'});
      }});
    /** @private */
    this.iso_ = h('input', {type: 'number', step: 'any', class: 'iso number',
      'aria-label': say`Isovalue of ${name}`, 'data-testid': `iso-${name}`,
      onchange: () => this.typed_(),
      onkeydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.key === 'Enter') {
          this.iso_.blur();
        }
      }});
    /** @private */
    this.title_ = h('button', {class: 'quiet grow name', 'aria-controls': `${id}-more`,
      ...DATA, 'data-testid': `choose-${name}`, onclick: () => selection.choose(name)}, name);
    /** @private */
    this.opacity_ = h('input', {type: 'range', min: 0.0625, max: 1, step: 0.0625,
      'aria-label': say`Opacity of ${name}`, 'data-testid': `surface-opacity-${name}`,
      ...gesture(app.connection, () => set({opacity: this.opacity_.value}))});
    /** @private */
    this.opacityText_ = h('span', {class: 'number muted amount'});
    /** @private */
    this.rim_ = h('input', {type: 'range', min: 0, max: 1, step: 0.0625,
      'aria-label': say`Edge light of ${name}`, 'data-testid': `surface-rim-${name}`,
      ...gesture(app.connection, () => set({rim: this.rim_.value}))});
    /** @private */
    this.rimText_ = h('span', {class: 'number muted amount'});
    /** @private */
    this.parts_ = this.makeParts_();
    /** @private */
    this.facts_ = h('p', {class: 'muted number figures', 'data-testid': `surface-facts-${name}`,
      // Files of an open mesh have no volume, so the card says what it counts.
      title: say`The volume inside the surface, as far as the scan reaches`});
    /** @private */
    this.legend_ = h('p', {class: 'legend', hidden: true, 'data-testid': `surface-legend-${name}`});
    /** @private The tables and colors of the legend, as JSON. */
    this.explained_ = '';
    /** @private Number of cells where the tables differ. */
    this.difference_ = h('span', {'data-testid': `surface-difference-${name}`});
    /** @private */
    this.certificate_ = h('div', {class: 'certificate',
      'data-testid': `surface-certificate-${name}`});
    /** @private The isovalue, the table and the volume of the certificate. */
    this.certified_ = '';
    /** @private Whether the button that checks the mesh is shown. */
    this.offers_ = false;
    /** @private */
    this.compare_ = h('button', {'aria-pressed': false, 'data-testid': `surface-compare-${name}`,
      title: say`Shows only the cells where the watertight tables and the tables of 1987 differ`,
      onclick: () => void this.compareClicked_()}, say`Compare with 1987`);
    /** @private */
    this.more_ = h('div', {class: 'more', id: `${id}-more`},
      h('label', {class: 'row'}, h('span', {class: 'field'}, say`Opacity`), this.opacity_,
        this.opacityText_),
      h('label', {class: 'row',
        title: say`Light at the edges, where the surface turns away (option rim)`},
        h('span', {class: 'field'}, say`Edge light`), this.rim_, this.rimText_),
      h('label', {class: 'row'}, h('span', {class: 'field'}, say`Parts`), this.parts_),
      this.facts_, this.legend_, this.certificate_,
      h('div', {class: 'row'}, this.compare_, h('span', {class: 'grow'}),
        h('button', {class: 'quiet', 'data-testid': `surface-remove-${name}`,
          onclick: () => void app.connection.do(`remove ${word(name)}`)}, say`Remove`)));
    this.root = h('li', {class: 'surface', 'data-testid': id},
      h('div', {class: 'row'}, h('label', {class: 'tick'}, this.visible_), this.color_,
        this.title_, this.iso_), this.more_);
    /** @private  A watcher would keep a removed card in memory. */
    this.unwatch_ = selection.watch(chosen => {
      this.more_.hidden = chosen !== name;
      this.root.classList.toggle('chosen', chosen === name);
      this.title_.setAttribute('aria-expanded', String(chosen === name));
    });
  }

  /** Removes the card from the page for good. */
  remove() {
    this.unwatch_();
    this.root.remove();
  }

  /** @param {SurfaceState} surface */
  show(surface) {
    const volume = this.app_.store.state?.volume ?? null;
    show(this.color_, surface.color);
    show(this.visible_, surface.visible);
    // The field holds about ten characters; the tooltip has the whole value.
    show(this.iso_, plain(Number(surface.isovalue.toPrecision(ISO_DIGITS)), 6));
    update(this.iso_, {title: surface.isovalue});
    show(this.opacity_, String(surface.opacity));
    setText(this.opacityText_, percent(surface.opacity));
    show(this.rim_, String(surface.rim));
    setText(this.rimText_, percent(surface.rim));
    setText(this.facts_, surface.triangles === 0
      ? nothingAt(surface.isovalue, volume) : sizes(surface));
    update(this.title_, {title: surface.table === 'watertight' ? surface.name
      : say`${surface.name}, table ${surface.table}`});
    this.showParts_(surface.components);
    update(this.parts_, {title: this.parts_.value === 'other' ? surface.components : ''});
    const certified = `${surface.isovalue} ${surface.table} ${volume?.identity}`;
    if (certified !== this.certified_) {
      this.certified_ = certified;
      if (!this.offers_) {
        this.offerCertificate_();
      }
    }
    const compared = this.app_.store.state?.surfaces.filter(
      each => each.compared_with === this.name_) ?? [];
    update(this.compare_, {'aria-pressed': String(compared.length > 0)});
    const legend = JSON.stringify(compared.map(({color, table}) => [color, table]));
    if (legend !== this.explained_) {
      this.explained_ = legend;
      this.showLegend_(compared);
    }
  }

  /**
   * Explains the colors of the tables during a comparison.
   * @private
   * @param {SurfaceState[]} compared
   */
  showLegend_(compared) {
    this.legend_.hidden = compared.length === 0;
    this.legend_.replaceChildren(this.difference_, say`Only these cells are shown.
      ${this.name_} is hidden until you end the comparison.`, ...compared.map(each => {
      const swatch = h('span', {class: 'swatch'});
      swatch.style.background = each.color;
      return h('span', {}, swatch, TABLE_NAMES.get(each.table) ?? each.table);
    }));
  }

  /** @private */
  typed_() {
    const value = this.iso_.valueAsNumber;
    if (Number.isFinite(value)) {
      this.app_.connection.mark();
      void this.app_.connection.set(isoCommand(this.name_, value));
    }
  }

  /** @private */
  makeParts_() {
    const select = h('select', {class: 'grow', 'data-testid': `surface-components-${this.name_}`,
      'aria-label': say`Parts of ${this.name_} to draw`},
      h('option', {value: 'show=all'}, say`all`),
      h('option', {value: 'show=largest'}, say`largest only`),
      ...LEAST_ML.map(ml => h('option', {value: `min_ml=${ml}`}, say`at least ${ml} ml`)),
      h('option', {value: 'at'}, say`click to choose …`),
      h('option', {...ENGLISH, value: 'other', hidden: true}, ''));
    select.addEventListener('change', () => {
      if (select.value === 'at') {
        this.askForPart_();
      } else {
        void this.app_.connection.do(`components ${word(this.name_)} ${select.value}`);
      }
      select.blur();
    });
    return select;
  }

  /** @private */
  askForPart_() {
    const {connection, modes} = this.app_;
    modes.enter({name: 'part', surface: this.name_,
      hint: say`Click the part of ${this.name_} to keep.`,
      click: (x, y) => {
        modes.leave('part');
        void connection.do(`components ${word(this.name_)} at=${x},${y}`);
      }});
  }

  /**
   * @private
   * @param {string} words  The state's, '' or 'all' if all are drawn.
   */
  showParts_(words) {
    if (document.activeElement === this.parts_) {
      return;
    }
    const known = words === '' ? 'show=all' : words.includes('=') ? words : `show=${words}`;
    const other = /** @type {HTMLOptionElement} */ (this.parts_.lastElementChild);
    const isKnown = [...this.parts_.options].some(each => each.value === known);
    setText(other, isKnown ? '' : words);
    this.parts_.value = isKnown ? known : 'other';
  }

  /** @private */
  offerCertificate_() {
    this.offers_ = true;
    this.certificate_.replaceChildren(h('button', {
      'data-testid': `surface-certify-${this.name_}`,
      title: say`Checks whether the mesh is closed, manifold and consistently oriented`,
      onclick: () => void this.certify_()}, say`Check mesh`));
  }

  /** @private */
  async certify_() {
    const of = this.certified_;
    this.offers_ = false;
    this.certificate_.replaceChildren(h('span', {class: 'muted'}, say`Checking …`));
    const reply = await this.app_.connection.do(`certificate ${word(this.name_)}`);
    if (of !== this.certified_) {
      return;
    }
    this.offers_ = false;
    const facts = reply.result?.certificates?.[0];
    if (!reply.ok || !facts) {
      this.offerCertificate_();
      return;
    }
    if (facts.triangles === 0) {
      this.certificate_.replaceChildren(h('span', {class: 'muted'}, say`No triangles to check.`));
      return;
    }
    const isSound = facts.closed_but_for_border && facts.manifold && facts.oriented;
    const [first, ...rest] = (reply.text ?? '').split('\n');
    this.certificate_.replaceChildren(h('details', {},
      h('summary', {}, h('span', {class: isSound ? 'seal good' : 'seal bad'},
        isSound ? say`✓ sound` : say`✗ defects`), ` ${rewritten(first.replace(/^[^:]*:\s*/, ''))}`),
      h('p', {class: 'muted report'}, rewritten(rest.map(line => line.trim()).join('\n')))));
  }

  /** @private */
  async compareClicked_() {
    const isOn = this.compare_.getAttribute('aria-pressed') === 'true';
    const reply = await this.app_.connection.do(
      `compare ${word(this.name_)}${isOn ? ' off' : ''}`);
    // The rest of the reply repeats what the card shows.
    const differing = reply.result?.cells_differing;
    this.difference_.textContent = differing === undefined ? ''
      : say`The tables differ in ${grouped(differing)} of ${grouped(reply.result.cells)} cells.`;
    this.difference_.title = reply.text ?? '';
  }
}
