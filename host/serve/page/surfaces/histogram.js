// The histogram of the volume. Each surface is a handle that the user drags.
import {remPx} from '../elements/canvas.js';
import {DATA, h, s, setText, update} from '../elements/dom.js';
import {short} from '../elements/numbers.js';
import {isoCommand, roundIso} from '../link/lines.js';
import {say} from '../texts/say.js';
import {drawAxis, outline, Scale} from './axis.js';
import {drawBands, mayBeHounsfield} from './bands.js';
import {Zoom} from './zoom.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/vocabulary.js').SurfaceState} SurfaceState */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */
/** @typedef {import('../state/selection.js').Selection} Selection */

// Lengths in rem, so that they grow with the text on large screens.
const HEIGHT = 11.4;
const TOP = 2.6;           // Room for the handles' grips, in two rows.
const BOTTOM = 1.6;        // Room for the axis.
const SIDE = 1.4;           // Room for half a number of the axis.
const GRIP = 0.85;
const LETTER = 0.55;        // Width of a letter of a band's name.
// Distance from a handle's line at which a mouse or a finger grabs the handle; CSS pixels.
const MOUSE_REACH = 12, FINGER_REACH = 22;
const FINE = 0.1;          // Fraction of the pointer's motion, with Shift.
const COARSE = 10;         // Steps per arrow key with Shift.
const REST_MS = 300;       // Without another volume of the series, until it is counted.
const KEY_STEPS = 500;     // Arrow keys cross the range in this many steps.

/** @typedef {{first: number, width: number, counts: number[]}} Counts */

/**
 * An isovalue that the state does not have yet.
 * @typedef {object} Ahead
 * @property {number} value
 * @property {number} underWay    Number of settings without a reply.
 * @property {number} revision    Revision of the last reply. The state arrives later.
 */

export class Histogram {
  /**
   * @param {HTMLElement} root
   * @param {App} app
   * @param {Selection} selection
   */
  constructor(root, app, selection) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.selection_ = selection;
    /** @private @type {Counts | null} */
    this.counts_ = null;
    /** @private  The time series, or the volume, of the counts. */
    this.series_ = '';
    /** @private @type {ReturnType<typeof setTimeout> | undefined} */
    this.resting_ = undefined;
    /** @private Whether the counts are known, and not only the axis. */
    this.isCounted_ = false;
    /** @private @type {Map<string, Ahead>} isovalues ahead of the state */
    this.ahead_ = new Map();
    /** @private */
    this.scale_ = new Scale();
    /** @private Pixels of a rem. */
    this.rem_ = 13;
    /** @private Width of the histogram, CSS pixels. */
    this.width_ = 0;
    /** @private @type {Map<string, SVGGElement>} */
    this.handles_ = new Map();
    /** @private Clips the outline to the shown values. */
    this.plot_ = s('rect', {y: 0});
    /** @private */
    this.area_ = s('path', {class: 'area', 'clip-path': 'url(#histogram-plot)'});
    /** @private */
    this.bands_ = s('g', {class: 'bands'});
    /** @private */
    this.bandNames_ = s('g', {class: 'bands', 'aria-hidden': 'true'});
    /** @private */
    this.axis_ = s('g', {class: 'axis'});
    /** @private */
    this.handleGroup_ = s('g');
    /** @private */
    this.svg_ = s('svg', {id: 'histogram', 'data-testid': 'histogram',
      role: 'group', 'aria-label': say`Histogram of the volume, with a handle for each surface`},
      s('clipPath', {id: 'histogram-plot'}, this.plot_), this.bands_, this.area_,
      this.bandNames_, this.axis_, this.handleGroup_);
    /** @private */
    this.zoom_ = new Zoom(this.svg_, {
      valueAt: x => this.scale_.valueAt(x),
      chosen: () => selection.name === '' ? null : this.valueOf_(selection.name),
      draw: () => this.draw_(),
    });
    /** @private */
    this.message_ = h('p', {class: 'muted'}, say`Open a volume to see its histogram.`);
    root.append(h('h2', {class: 'spread'},
      h('span', {title: say`Number of voxels per value, on a logarithmic scale`}, say`Histogram`),
      this.zoom_.buttons), this.svg_, this.message_);
    new ResizeObserver(() => this.draw_()).observe(root);
    app.store.subscribe(['volume'], ({volume}) => this.open_(volume));
    app.store.subscribe(['surfaces', 'volume'], () => this.follow_());
    app.store.subscribe(['revision'], () => {
      if (this.ahead_.size > 0) {
        this.follow_();
      }
    });
    // A restarted server begins again at 1.
    app.connection.on('lost', () => this.ahead_.forEach(ahead => { ahead.revision = 0; }));
    selection.watch(() => this.drawHandles_());
    app.connection.on('hello', () => {
      // The connection may have been lost before the counts arrived.
      const volume = app.store.state?.volume ?? null;
      if (volume && !this.isCounted_) {
        void this.load_(volume);
      }
    });
  }

  /**
   * While a time series plays, the counts of its last volume stay.
   * @private
   * @param {VolumeState | null} volume
   */
  open_(volume) {
    clearTimeout(this.resting_);
    if (volume && volume.series_identity === this.series_ && this.counts_) {
      this.resting_ = setTimeout(() => void this.load_(volume), REST_MS);
      return;
    }
    this.series_ = volume?.series_identity ?? '';
    this.counts_ = null;
    this.draw_();
    void this.load_(volume);
  }

  /**
   * @private
   * @param {VolumeState | null} volume
   */
  async load_(volume) {
    if (!volume) {
      return;
    }
    const {watches} = this.app_.connection;
    const reply = watches ? {ok: false, error: ''}
      : await this.app_.connection.do('histogram', {quiet: true});
    if (JSON.stringify(volume) !== JSON.stringify(this.app_.store.state?.volume)) {
      return;  // Another volume was opened in the meantime and requests its own counts.
    }
    this.isCounted_ = reply.ok;
    const reduction = reply.ok ? reply.result.reduction : 1;
    this.message_.textContent = watches ? say`No histogram: a view-only page cannot request it.`
      : !reply.ok ? say`No histogram: ${reply.error ?? ''}`
      : reduction > 1 ? say`Counts one voxel in ${reduction} along each axis.` : '';
    // The handles need an axis even without counts. A volume with a single value gets an axis of
    // length 1.
    const hasCounts = reply.ok && reply.result.counts.length > 0 && reply.result.width > 0;
    if (hasCounts) {
      document.dispatchEvent(new CustomEvent('counts',
        {detail: {identity: volume.identity, counts: reply.result}}));
    }
    /** @type {Counts} */
    const known = hasCounts ? reply.result
      : {first: volume.minimum, width: volume.maximum - volume.minimum || 1, counts: [0]};
    const {first, width, counts} = this.counts_ = known;
    this.zoom_.setAll({low: first, high: first + width * counts.length}, width);
    this.draw_();
  }

  /** @private */
  draw_() {
    const counts = this.counts_;
    this.svg_.classList.toggle('empty', !counts);
    const width = this.svg_.clientWidth;
    if (!counts || width === 0) {
      return;
    }
    this.width_ = width;
    this.rem_ = remPx();
    const [side, top, base] = [SIDE, TOP, HEIGHT - BOTTOM].map(each => each * this.rem_);
    update(this.svg_, {height: HEIGHT * this.rem_});
    update(this.axis_, {transform: `translate(0 ${base})`});
    update(this.plot_, {x: side, width: Math.max(0, width - 2 * side), height: base});
    const {low, high} = this.zoom_.shown;
    const scale = this.scale_ = new Scale(low, high, side, width - side);
    const left = (/** @type {number} */ k) => counts.first + k * counts.width;
    const shown = counts.counts.filter((_, k) => left(k + 1) > low && left(k) < high);
    const most = Math.log1p(Math.max(...shown, 1));
    // Bins beside the shown ones may be higher. They are clipped.
    const tops = counts.counts.map(n => base - Math.log1p(n) / most * (base - top));
    update(this.area_, {d: outline(tops, base, k => scale.at(left(k)))});
    const volume = this.app_.store.state?.volume;
    const display = volume && mayBeHounsfield(volume) ? '' : 'none';
    this.bands_.style.display = this.bandNames_.style.display = display;
    drawBands(this.bands_, this.bandNames_, scale, top, base, this.rem_ * LETTER,
      volume?.modality === 'CT');
    drawAxis(this.axis_, scale, Math.max(3, Math.round(width / (5 * this.rem_))));
    this.drawHandles_();
  }

  /** @private */
  drawHandles_() {
    const surfaces = this.app_.store.state?.surfaces ?? [];
    const named = new Set(surfaces.map(({name}) => name));
    for (const [name, handle] of this.handles_) {
      if (!named.has(name) || !this.counts_) {
        handle.remove();
        this.handles_.delete(name);
      }
    }
    if (this.counts_) {
      surfaces.filter(each => each.compared_with === '')
        .forEach((surface, row) => this.drawHandle_(surface, row));
    }
  }

  /**
   * @private
   * @param {SurfaceState} surface
   * @param {number} row
   */
  drawHandle_(surface, row) {
    const handle = this.handles_.get(surface.name) ?? this.makeHandle_(surface.name);
    const value = this.valueOf_(surface.name);
    const {low, high} = this.scale_;
    const x = this.scale_.at(Math.max(low, Math.min(high, value)));
    const unit = this.app_.store.state?.volume?.unit ?? '';
    const isChosen = surface.name === this.selection_.name;
    update(handle, {
      transform: `translate(${x.toFixed(1)} 0)`, 'aria-valuemin': this.zoom_.all.low,
      'aria-valuemax': this.zoom_.all.high, 'aria-valuenow': value,
      'aria-valuetext': `${short(value, 4)} ${unit}`,
      class: `handle${isChosen ? ' chosen' : ''}${surface.visible ? '' : ' hid'}`,
    });
    const [line, grip, label, reach, , beyond] = handle.children;
    const [size, base] = [GRIP, HEIGHT - BOTTOM].map(each => each * this.rem_);
    const far = Math.max(matchMedia('(pointer: coarse)').matches ? FINGER_REACH : MOUSE_REACH,
      size);
    const top = row % 2 === 0 ? 2 : 2 + size * 1.3;
    update(line, {y1: top + size, y2: base, stroke: surface.color});
    update(grip, {x: -size / 2, y: top, width: size, height: size, fill: surface.color});
    update(reach, {x: -far, width: 2 * far, height: base});
    // An arrow at the axis that points towards a value out of range.
    const way = value < low ? -1 : value > high ? 1 : 0;
    const foot = base - size / 2;
    update(beyond, {visibility: way === 0 ? 'hidden' : 'visible',
      d: `M${way * size * 1.2} ${foot}L${way * 3} ${foot - size / 2}V${foot + size / 2}Z`});
    setText(label, `${surface.name} ${short(value, 3)}`);
    const isLeft = x < this.width_ / 2;
    update(label, {x: isLeft ? size : -size, y: top + size - 1,
      'text-anchor': isLeft ? 'start' : 'end'});
    // The chosen handle is on top. Moving a focused handle would drop the focus and block Tab.
    if (isChosen && handle !== document.activeElement && handle !== this.handleGroup_.lastChild) {
      this.handleGroup_.append(handle);
    }
  }

  /**
   * @private
   * @param {string} name
   */
  makeHandle_(name) {
    const handle = s('g', {role: 'slider', tabindex: 0, 'aria-label': say`Isovalue of ${name}`,
      'data-testid': `handle-${name}`},
      s('line'), s('rect', {rx: 3}),
      s('text', {...DATA, class: 'handle-text'}),
      s('rect', {class: 'reach'}),
      s('title', {}, say`${name}: drag (slower with Shift), or use the arrow keys`),
      s('path', {class: 'beyond', 'data-testid': `handle-beyond-${name}`}));
    handle.addEventListener('focus', () => this.selection_.choose(name));
    handle.addEventListener('keydown', event => this.key_(event, name));
    handle.addEventListener('pointerdown', event => this.grab_(event, handle, name));
    this.handles_.set(name, handle);
    this.handleGroup_.append(handle);
    return handle;
  }

  /**
   * @private
   * @param {PointerEvent} event
   * @param {SVGGElement} handle
   * @param {string} name
   */
  grab_(event, handle, name) {
    if (this.app_.connection.watches || event.button !== 0) {
      return;
    }
    event.preventDefault();
    handle.focus();
    const left = this.svg_.getBoundingClientRect().left;
    const drawn = Math.max(this.scale_.low, Math.min(this.scale_.high, this.valueOf_(name)));
    let before = event.clientX, x = this.scale_.at(drawn);
    const move = (/** @type {PointerEvent} */ moved) => {
      x = moved.shiftKey ? x + (moved.clientX - before) * FINE : moved.clientX - left;
      before = moved.clientX;
      const {low, high} = this.zoom_.shown;
      this.setTo(name, Math.max(low, Math.min(high, this.scale_.valueAt(x))));
    };
    const end = () => {
      this.svg_.removeEventListener('pointermove', move);
      this.svg_.removeEventListener('pointerup', end);
      this.svg_.removeEventListener('pointercancel', end);
    };
    this.app_.connection.mark();
    this.svg_.setPointerCapture(event.pointerId);
    this.svg_.addEventListener('pointermove', move);
    this.svg_.addEventListener('pointerup', end);
    this.svg_.addEventListener('pointercancel', end);
  }

  /**
   * @private
   * @param {string} name
   */
  valueOf_(name) {
    return this.ahead_.get(name)?.value
      ?? this.app_.store.state?.surfaces.find(each => each.name === name)?.isovalue ?? 0;
  }

  /**
   * Sets the isovalue of a surface, newest only. The handle moves before the reply arrives.
   * @param {string} name
   * @param {number} wished
   */
  setTo(name, wished) {
    const volume = this.app_.store.state?.volume;
    if (!volume) {
      return;
    }
    const {low, high} = this.zoom_.all;
    const value = roundIso(Math.max(low, Math.min(high, wished)), volume);
    const ahead = this.ahead_.get(name) ?? {value: NaN, underWay: 0, revision: 0};
    if (value === ahead.value) {
      return;
    }
    ahead.value = value;
    ahead.underWay += 1;
    this.ahead_.set(name, ahead);
    this.drawHandles_();
    void this.app_.connection.set(isoCommand(name, value)).then(({revision = 0}) => {
      ahead.underWay -= 1;
      ahead.revision = Math.max(ahead.revision, revision);
      this.follow_();
    });
  }

  /**
   * Drops values that the state has reached. The reply arrives before the state: without the wait,
   * an arrow key between the two would start from the former value.
   * @private
   */
  follow_() {
    const {revision} = this.app_.store.state ?? {revision: 0};
    for (const [name, ahead] of this.ahead_) {
      if (ahead.underWay === 0 && revision >= ahead.revision) {
        this.ahead_.delete(name);
      }
    }
    this.drawHandles_();
  }

  /**
   * @private
   * @param {KeyboardEvent} event
   * @param {string} name
   */
  key_(event, name) {
    if (this.app_.connection.watches || event.ctrlKey || event.metaKey) {
      return;
    }
    const {low, high} = this.zoom_.all;
    const step = (high - low >= KEY_STEPS ? 1 : (high - low) / KEY_STEPS)
      * (event.shiftKey ? COARSE : 1);
    const now = this.valueOf_(name);
    const values = new Map([['ArrowLeft', now - step], ['ArrowDown', now - step],
      ['ArrowRight', now + step], ['ArrowUp', now + step], ['PageDown', now - COARSE * step],
      ['PageUp', now + COARSE * step], ['Home', low], ['End', high]]);
    const value = values.get(event.key);
    if (value !== undefined) {
      event.preventDefault();
      event.stopPropagation();
      this.setTo(name, value);
      this.zoom_.follow(this.valueOf_(name));
    }
  }
}
