// Panel: three slices of the volume, linked to each other and to the picture.
import {h, setText, update} from '../elements/dom.js';
import {choiceRow, intro, messageLine} from '../panel/panel_parts.js';
import {say} from '../texts/say.js';
import {SlicesInPicture} from './in_picture.js';
import {ObliquePane} from './oblique_pane.js';
import {nearestVoxel, toPatient, toVoxel} from './patient_grid.js';
import {cutsOf} from './slice_cuts.js';
import {eventsOf} from './slice_events.js';
import {SliceMeasure} from './slice_measure.js';
import {SlicePlace} from './slice_place.js';
import {pictureOf, shownSize} from './slice_picture.js';
import {planesOf} from './slice_planes.js';
import {SliceReadout} from './slice_readout.js';
import {keepInSession} from './slice_session.js';
import {SliceSettings} from './slice_settings.js';
import {SlabControls} from './slice_slab.js';
import {SliceSource} from './slice_source.js';
import {SliceView} from './slice_view.js';
import {TOOLS} from './slice_tools.js';
import {beyond, differing, planeWord, sliceWord} from './slice_words.js';
import {limitedTimes} from './slice_zoom.js';
import {WindowControls} from './window_controls.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

const PLANES = ['Axial', 'Coronal', 'Sagittal'];
const SELF = 'slices';
const REST_MS = 250;        // A dragged isovalue rests after this time.
const EMPTY = say`No volume is open. Open a volume to see its slices.`;

/** @typedef {{view: SliceView, source: SliceSource, element: HTMLElement,
 *   slider: HTMLInputElement, count: HTMLElement}} Pane */

/** @param {Pane} pane */
function isLarge({element}) {
  return element.classList.contains('large');
}

export class SlicesPanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    this.root = root;
    /** @type {VolumeState | null} */ this.volume = null;
    /** Surfaces whose contours are incomplete, by plane. @type {string[][]} */
    this.leftOut = PLANES.map(() => []);
    /** Zoom of all slices. */ this.times = 1;
    /** @type {Vector} */ this.voxel = [0, 0, 0];
    /** @type {ReturnType<typeof planesOf>} */ this.planes = [];
    /** Number of opened volumes. */ this.opened = 0;
    /** The planes whose lines the views have, as JSON. */ this.lines = '';
    /** The settings that the contours depend on, as JSON. */ this.contours = '';
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.resting = undefined;
    this.visible = false;
    this.stale = true;
    this.skew = 0;
    this.message = messageLine('slices-message');
    this.readout = new SliceReadout();
    this.notes = h('p', {class: 'legend', 'data-testid': 'slices-notes'});
    this.beyond = h('p', {class: 'legend', 'data-testid': 'slices-beyond'});
    this.inPicture = new SlicesInPicture(app, PLANES, () => this.volume && {planes: this.planes,
      voxel: this.voxel, through: this.window.through});
    this.panes = PLANES.map((_, number) => this.pane(number));
    this.oblique = new ObliquePane(app.connection,
      new SliceView('Oblique', eventsOf(this, PLANES.length)), {changed: () => this.cut(),
        shown: slice => {
          this.show(this.oblique.view, slice);
          this.tell(PLANES.length, slice);
        },
        failed: sentence => this.message.fail(sentence)});
    this.grid = h('div', {class: 'slice-grid'}, ...this.panes.map(pane => pane.element));
    this.target = h('select', {'aria-label': say`Surface to adjust`, hidden: true,
      'data-testid': 'slices-surface', onchange: () => app.selection.choose(this.target.value)});
    /** @type {import('./slice_input.js').Tool}  The chosen tool. A mode may replace it. */
    this.tool = 'point';
    this.window = new WindowControls(through => {
      this.views().forEach(view => view.repaint(through));
      this.inPicture.follow();
    });
    this.slabs = new SlabControls(PLANES, () => this.refresh());
    this.settings = new SliceSettings(look => this.look(look), by => this.zoom(by),
      [this.slabs.element, this.window.more]);
    this.measure = new SliceMeasure(app, this.message, {changed: () => this.mark(),
      point: voxel => this.point(voxel),
      views: () => [...this.panes].sort((a, b) => Number(isLarge(b)) - Number(isLarge(a)))
        .map(({view}) => view)});
    this.build();
    this.listen();
  }

  build() {
    this.tools = choiceRow(say`Tool for the slices`, TOOLS, tool => {
      this.tool = tool;
      this.app.modes.leave('tissue');
      this.takeTool();
    });
    this.root.append(
      intro(say`Three slices of the scan. Lines show the surfaces.`),
      h('div', {class: 'tool-row'}, this.tools.element, this.target, this.measure.kind,
        this.measure.done),
      this.window.fields, this.window.presets, this.settings.element, this.message.element,
      this.beyond, this.grid, this.readout.element, this.oblique.element, this.notes,
      this.measure.list.element);
    const panes = this.panes.map(({element}) => element);
    const parts = {grid: this.grid, readout: this.readout.element, panes};
    this.place = new SlicePlace(this.app, this.root, parts, isSeen => {
      this.visible = isSeen;
      if (isSeen && this.stale) {
        this.refresh();
      }
    });
  }

  /** A click sets an isovalue while the tissue mode is on. */
  takeTool() {
    const tool = this.app.modes.current?.value ? 'tissue' : this.tool;
    this.views().forEach(view => view.setTool(tool));
    this.measure.show(tool === 'measure');
    this.tools?.show(tool);
    this.target.hidden = tool !== 'tissue';
  }

  /** All views, the oblique one last. */
  views() {
    return [...this.panes.map(({view}) => view), this.oblique.view];
  }

  /**
   * @param {SliceView} view
   * @param {import('./slice_pixels.js').Slice} slice
   */
  show(view, slice) {
    if (this.volume?.frame === slice.frame) {  // Else the state of that volume follows.
      view.show(slice, this.volume.size, this.window.through);
      view.setCrosshair(this.voxel);
      this.tellValue();
      document.dispatchEvent(new Event('sliceshown'));
    }
  }

  /** Whether a slice on the screen still is one of another volume of the series. */
  get isBehind() {
    return this.visible && this.panes.some(({view}) => view.isOld);
  }

  /** Shows where clip planes and the oblique slice cut the slices. */
  cut() {
    const {volume} = this, clips = this.app.store.state?.clips.map(({plane}) => plane) ?? [];
    const other = this.oblique.equation, lines = JSON.stringify([this.opened, clips, other]);
    if (lines !== this.lines) {  // Painting all slices takes long.
      this.lines = lines;
      this.views().forEach(view =>
        view.setCuts(slice => volume ? cutsOf(slice, volume, clips, other) : []));
    }
  }

  /**
   * @param {number} number  Index of the plane.
   * @returns {Pane}
   */
  pane(number) {
    const view = new SliceView(PLANES[number], eventsOf(this, number));
    const source = new SliceSource(this.app.connection, {
      slice: slice => {
        if (this.volume) {
          this.show(view, slice);
          setText(count, `${slice.index + 1} / ${this.volume.size[slice.axes[2]]}`);
          this.tell(number, slice);
        }
      },
      failed: sentence => this.message.fail(sentence),
    });
    this.app.views.add({name: PLANES[number].toLowerCase(), title: sliceWord(PLANES[number]),
      size: () => shownSize(view.all), painted: painting => pictureOf(view.all, painting)});
    const slider = h('input', {type: 'range', min: 0, max: 0, value: 0,
      'aria-label': sliceWord(PLANES[number]), 'data-testid': `slice-index-${number}`,
      oninput: () => this.step(number, Number(slider.value) - Math.round(
        this.voxel[this.planes[number].number]))});
    const count = h('span', {class: 'slice-count', 'data-testid': `slice-count-${number}`});
    const enlarge = h('button', {type: 'button', class: 'quiet', title: say`Enlarge this slice`,
      onclick: () => this.place?.enlarge(number)}, planeWord(PLANES[number]));
    const element = h('div', {class: number === 0 ? 'slice-pane large' : 'slice-pane'},
      h('div', {class: 'slice-head'}, enlarge, count, this.inPicture.buttons[number]),
      view.canvas, slider);
    return {view, source, element, slider, count};
  }

  listen() {
    const {store, connection, modes, selection, session} = this.app;
    keepInSession(session, this);
    this.app.lagging.add(() => this.isBehind);
    modes.watch(() => this.takeTool());
    this.app.measures.watch(() => this.mark());
    selection.watch(name => { this.target.value = name; });
    // Requests that the lost connection dropped are sent again.
    connection.on('hello', () => this.refresh());
    store.subscribe(['volume'], state => this.open(state.volume));
    store.subscribe(['surfaces', 'clips'], state => setText(this.beyond, beyond(state)));
    store.subscribe(['clips'], () => this.cut());
    // The lines of a slice that is asked for now are those of the newest state.
    store.subscribe(['surfaces'], ({surfaces}) => {
      this.contours = JSON.stringify(surfaces.map(({name, isovalue, color, visible}) =>
        [name, isovalue, color, visible]));
    });
    let drawn = '';
    store.follow(['surfaces'], ({surfaces}) => {
      const names = surfaces.filter(each => each.compared_with === '').map(({name}) => name);
      const listed = [...this.target.options].map(({value}) => value);
      if (JSON.stringify(names) !== JSON.stringify(listed)) {  // A name may have a comma.
        this.target.replaceChildren(...names.map(name => h('option', {value: name}, name)));
        this.target.value = selection.name;
      }
      // During a drag only the large slice is updated; the small slices follow at rest.
      if (drawn !== this.contours) {
        drawn = this.contours;
        this.refresh(isLarge);
        clearTimeout(this.resting);
        this.resting = setTimeout(() => this.refresh(), REST_MS);
      }
    });
    document.addEventListener('place', event => {
      const {p_mm, from} = /** @type {CustomEvent} */ (event).detail;
      if (this.volume && from !== SELF) {
        this.move(nearestVoxel(this.volume, toVoxel(this.volume, p_mm)));
      }
    });
    document.addEventListener('counts', event => {
      const {identity, counts} = /** @type {CustomEvent} */ (event).detail;
      if (identity === this.volume?.identity) {
        this.window.count(counts);
      }
    });
  }

  /** @param {boolean} isOpen  Whether another volume follows. */
  clear(isOpen) {
    this.root.classList.toggle('empty', !isOpen);
    this.message.say(isOpen ? '' : EMPTY);
    this.notes.textContent = '';
    this.readout.clear();
    this.leftOut = PLANES.map(() => []);
    this.times = 1;
    this.settings.tellTimes(1);
    this.panes.forEach(({view}) => view.clear());
    this.panes.forEach(({count}) => { count.textContent = ''; });
  }

  /** @param {VolumeState | null} volume  Another volume of the series keeps place and window. */
  open(volume) {
    const same = volume !== null && volume.series_identity === this.volume?.series_identity;
    this.volume = volume;
    ++this.opened;
    this.panes.forEach(({source}) => source.forget());
    this.measure.forget();  // No measurement joins points of two volumes.
    this.views().forEach(view => view.outdate());
    if (!same) {
      this.clear(volume !== null);
    }
    this.oblique.open(volume, same);
    if (!volume) {
      return;
    }
    this.planes = planesOf(volume.voxel_to_patient);
    this.inPicture.whileOpening(() => {
      this.window.open(volume, same);
      this.move(same ? this.voxel : this.inPicture.firstVoxel(volume, this.window));
    });
  }

  /**
   * Reports where the slices differ from the scan.
   * @param {number} number  Index of the plane; the oblique one is the last.
   * @param {import('./slice_pixels.js').Slice} slice
   */
  tell(number, {contours, skew_deg}) {
    this.leftOut[number] =
      contours.filter(({left_out}) => left_out).map(({surface}) => surface);
    this.skew = skew_deg ?? this.skew;  // The oblique slice has none.
    const left = [...PLANES, 'Oblique'].map((plane, each) => this.leftOut[each]?.length > 0
      ? say`${planeWord(plane)}: too many lines. Contours of ${this.leftOut[each].join(', ')} are
        incomplete.`
      : '');
    this.notes.textContent = [...left, differing(this.volume, this.skew)].filter(Boolean).join(' ');
  }

  /**
   * Requests the slices that may have changed.
   * @param {(pane: Pane) => boolean} [which]  All, if not given.
   */
  refresh(which = () => true) {
    this.stale = !this.visible;
    const volume = this.volume;
    if (!volume || !this.visible) {
      return;
    }
    const of = `${this.opened} ${this.contours}`;
    this.oblique.refresh(of);
    this.panes.forEach((pane, number) => {
      const {source, slider} = pane;
      const {axis, number: through} = this.planes[number];
      const index = Math.round(this.voxel[through]);
      update(slider, {max: volume.size[through] - 1});
      slider.value = String(index);
      if (which(pane)) {
        source.want({axis, index, count: volume.size[through],
          slab: this.slabs.slabs[number]}, of);
      }
    });
  }

  /** @param {Vector} voxel  The crosshair goes there. */
  move(voxel) {
    this.voxel = voxel;
    this.panes.forEach(({view}) => view.setCrosshair(voxel));
    this.oblique.move(voxel);
    this.inPicture.follow();
    this.tellValue();
    this.refresh();
  }

  /**
   * Zooms all slices, one of them around a place, the others around the crosshair.
   * @param {number} by           0: shows whole slices.
   * @param {number} [number]     Index of the plane.
   * @param {[number, number] | null} [at]  CSS pixels of its view.
   */
  zoom(by, number, at = null) {
    this.times = by === 0 ? 1 : limitedTimes(this.times * by);
    this.views().forEach((view, each) => view.zoomTo(this.times, each === number ? at : null));
    this.settings.tellTimes(this.times);
  }

  /** Shows the measurements. */
  mark() {
    const marks = this.volume ? this.measure.marks(this.volume) : [];
    this.views().forEach(view => view.setMarks(marks));
  }

  /** @param {import('./slice_settings.js').Look} look */
  look(look) {
    this.views().forEach(view => view.setLook(look, this.window.through));
  }

  /** @param {Vector} voxel */
  point(voxel) {
    const volume = this.volume;
    if (volume) {
      const held = nearestVoxel(volume, voxel);
      this.move(held);
      document.dispatchEvent(new CustomEvent('place',
        {detail: {p_mm: toPatient(volume, held), from: SELF}}));
    }
  }

  /**
   * @param {number} number  Index of the plane.
   * @param {number} by      Slices.
   */
  step(number, by) {
    const plane = this.planes[number];
    if (!plane) {
      this.point(this.oblique.stepped(by));
      return;
    }
    /** @type {Vector} */
    const voxel = [...this.voxel];
    voxel[plane.number] += by;
    this.point(voxel);
  }

  /** Tells the value under the pointer, or under the crosshair. */
  tellValue() {
    if (!this.views().some(view => view.hover())) {
      this.hover(null, 0);
    }
  }

  /**
   * Tells the value under the pointer; without a pointer, the crosshair's.
   * @param {import('./slice_input.js').Under | null} under
   * @param {number} number  Index of the plane with the pointer.
   */
  hover(under, number) {
    this.readout.show(this.volume, this.panes.map(({view}, each) => ({plane: PLANES[each], view})),
      {under, number, crosshair: this.voxel});
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new SlicesPanel(root, app);
}
