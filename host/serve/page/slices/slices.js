// Panel: three slices of the volume, linked to each other and to the picture.
import {h} from '../elements/dom.js';
import {isoCommand, roundIso} from '../link/lines.js';
import {choiceRow, intro, messageLine} from '../panel/panel_parts.js';
import {nearestVoxel, toPatient, toVoxel} from './patient_grid.js';
import {SliceMeasure} from './slice_measure.js';
import {SlicePlace} from './slice_place.js';
import {pictureOf, shownSize} from './slice_picture.js';
import {planesOf} from './slice_planes.js';
import {SliceReadout} from './slice_readout.js';
import {SliceSettings} from './slice_settings.js';
import {SlabControls} from './slice_slab.js';
import {SliceSource} from './slice_source.js';
import {SliceView} from './slice_view.js';
import {beyond, differing} from './slice_words.js';
import {limitedTimes} from './slice_zoom.js';
import {WindowControls} from './window_controls.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

const PLANES = ['Axial', 'Coronal', 'Sagittal'];
const SELF = 'slices';
const REST_MS = 250;        // A dragged isovalue rests after this time.
const EMPTY = 'No volume is open. Open a volume to see its slices.';

/** @typedef {{view: SliceView, source: SliceSource, element: HTMLElement,
 *   slider: HTMLInputElement, count: HTMLElement}} Pane */

/** @param {Pane} pane */
function isLarge({element}) {
  return element.classList.contains('large');
}

class SlicesPanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    this.root = root;
    /** @type {VolumeState | null} */
    this.volume = null;
    /** Surfaces whose contours are incomplete, by plane. @type {string[][]} */
    this.leftOut = PLANES.map(() => []);
    /** Zoom of all slices. */
    this.times = 1;
    /** @type {Vector} */
    this.voxel = [0, 0, 0];
    /** @type {ReturnType<typeof planesOf>} */
    this.planes = [];
    /** Number of opened volumes. */
    this.opened = 0;
    /** The settings that the contours depend on, as JSON. */
    this.contours = '';
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.resting = undefined;
    this.visible = false;
    this.stale = true;
    this.message = messageLine('slices-message');
    this.readout = new SliceReadout();
    this.notes = h('p', {class: 'legend', 'data-testid': 'slices-notes'});
    this.beyond = h('p', {class: 'legend', 'data-testid': 'slices-beyond'});
    this.panes = PLANES.map((_, number) => this.pane(number));
    this.grid = h('div', {class: 'slice-grid'}, ...this.panes.map(pane => pane.element));
    this.target = h('select', {'aria-label': 'Surface to adjust', hidden: true,
      'data-testid': 'slices-surface', onchange: () => app.selection.choose(this.target.value)});
    /** @type {import('./slice_input.js').Tool}  The chosen tool. A mode may replace it. */
    this.tool = 'point';
    this.window = new WindowControls(through =>
      this.panes.forEach(({view}) => view.repaint(through)));
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
    this.tools = choiceRow('Tool for the slices', [
      {name: 'point', title: 'Point', help: 'Move the crosshair, here and in the picture'},
      {name: 'move', title: 'Move', help: 'Drag a zoomed slice (with any tool: middle button). ' +
        'Ctrl and the wheel zoom'},
      {name: 'measure', title: 'Measure', help: 'Distances, angles and paths; areas and values ' +
        'of regions'},
      {name: 'window', title: 'Window', help: 'Drag across for contrast, down for brightness ' +
        '(with any tool: right button or Shift)'},
      {name: 'tissue', title: 'Tissue', help: 'Set the isovalue to the value under the pointer'},
    ], tool => {
      this.tool = tool;
      this.app.modes.leave('tissue');
      this.takeTool();
    });
    this.root.append(
      intro('Three slices of the scan. Lines show the surfaces.'),
      h('div', {class: 'tool-row'}, this.tools.element, this.target, this.measure.kind,
        this.measure.done),
      this.window.fields, this.window.presets, this.settings.element, this.message.element,
      this.beyond, this.grid, this.readout.element, this.notes, this.measure.list.element);
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
    for (const {view} of this.panes) {
      view.setTool(tool);
    }
    this.measure.show(tool === 'measure');
    this.tools?.show(tool);
    this.target.hidden = tool !== 'tissue';
  }

  /**
   * @param {number} number  Index of the plane.
   * @returns {Pane}
   */
  pane(number) {
    const view = new SliceView(PLANES[number], {
      point: voxel => this.point(voxel),
      measure: (phase, voxel) => this.volume && this.measure.take(phase, voxel, view, this.volume),
      end: (phase, end, voxel) =>
        this.volume && this.measure.drag(phase, end, voxel, view, this.volume),
      tissue: value => this.tissue(value),
      hover: under => this.hover(under, number),
      step: by => this.step(number, by),
      window: (across, down) => this.window.drag(across, down),
      zoom: (by, at) => this.zoom(by, number, at),
    });
    const source = new SliceSource(this.app.connection, {
      slice: slice => {
        if (this.volume) {
          view.show(slice, this.volume.size, this.window.through);
          view.setCrosshair(this.voxel);
          this.tellValue();
          count.textContent = `${slice.index + 1} / ${this.volume.size[slice.axes[2]]}`;
          this.tell(number, slice);
        }
      },
      failed: sentence => this.message.fail(sentence),
    });
    this.app.views.add({title: `${PLANES[number]} slice`, size: () => shownSize(view.all),
      painted: painting => pictureOf(view.all, painting)});
    const slider = h('input', {type: 'range', min: 0, max: 0, value: 0,
      'aria-label': `${PLANES[number]} slice`, 'data-testid': `slice-index-${number}`,
      oninput: () => this.step(number, Number(slider.value) - Math.round(
        this.voxel[this.planes[number].number]))});
    const count = h('span', {class: 'slice-count', 'data-testid': `slice-count-${number}`});
    const enlarge = h('button', {type: 'button', class: 'quiet', title: 'Enlarge this slice',
      onclick: () => this.place?.enlarge(number)}, PLANES[number]);
    const element = h('div', {class: number === 0 ? 'slice-pane large' : 'slice-pane'},
      h('div', {class: 'slice-head'}, enlarge, count), view.canvas, slider);
    return {view, source, element, slider, count};
  }

  listen() {
    const {store, connection, modes, selection, session} = this.app;
    session.add('window', {save: () => this.volume && this.window.through,
      restore: through => this.window.look(through)});
    session.add('slices', {save: () => this.volume && this.settings.look,
      restore: look => { this.settings.setLook(look); this.look(this.settings.look); }});
    session.add('slabs', {save: () => this.volume && this.slabs.slabs,
      restore: slabs => this.slabs.setSlabs(slabs)});
    session.add('crosshair', {save: () => this.volume && this.voxel,
      restore: voxel => this.point(voxel)});
    modes.watch(() => this.takeTool());
    this.app.measures.watch(() => this.mark());
    selection.watch(name => { this.target.value = name; });
    // Requests that the lost connection dropped are sent again.
    connection.on('hello', () => this.refresh());
    store.subscribe(['volume'], state => this.open(state.volume));
    store.subscribe(['surfaces', 'clips'], state => { this.beyond.textContent = beyond(state); });
    store.subscribe(['surfaces'], ({surfaces}) => {
      this.target.replaceChildren(...surfaces.filter(each => each.compared_with === '')
        .map(({name}) => h('option', {value: name}, name)));
      this.target.value = selection.name;
      // During a drag only the large slice is updated; the small slices follow at rest.
      const contours = JSON.stringify(surfaces.map(({name, isovalue, color, visible}) =>
        [name, isovalue, color, visible]));
      if (contours !== this.contours) {
        this.contours = contours;
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

  /** @param {VolumeState | null} volume */
  open(volume) {
    const same = volume !== null && volume.identity === this.volume?.identity;
    this.volume = volume;
    ++this.opened;
    this.measure.forget();
    this.root.classList.toggle('empty', volume === null);
    this.message.say(volume ? '' : EMPTY);
    this.notes.textContent = '';
    this.readout.clear();
    this.leftOut = PLANES.map(() => []);
    this.times = 1;
    this.settings.tellTimes(1);
    for (const {view, source, count} of this.panes) {
      source.forget();
      view.clear();
      count.textContent = '';
    }
    if (!volume) {
      return;
    }
    this.planes = planesOf(volume.voxel_to_patient);
    this.window.open(volume, same);
    if (!same) {
      this.move(/** @type {Vector} */ (volume.size.map(count => Math.floor(count / 2))));
    } else {
      this.refresh();
    }
  }

  /**
   * Reports where the slices differ from the scan.
   * @param {number} number  Index of the plane.
   * @param {import('./slice_pixels.js').Slice} slice
   */
  tell(number, {contours, skew_deg = 0}) {
    this.leftOut[number] =
      contours.filter(({left_out}) => left_out).map(({surface}) => surface);
    const left = PLANES.map((plane, each) => this.leftOut[each].length > 0
      ? `${plane}: too many lines. Contours of ${this.leftOut[each].join(', ')} are incomplete.`
      : '');
    this.notes.textContent = [...left, differing(this.volume, skew_deg)].filter(Boolean).join(' ');
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
    this.panes.forEach((pane, number) => {
      const {source, slider} = pane;
      const {axis, number: through} = this.planes[number];
      const index = Math.round(this.voxel[through]);
      slider.max = String(volume.size[through] - 1);
      slider.value = String(index);
      if (which(pane)) {
        source.want(axis, index, this.slabs.slabs[number], `${this.opened} ${this.contours}`);
      }
    });
  }

  /** @param {Vector} voxel  The crosshair goes there. */
  move(voxel) {
    this.voxel = voxel;
    this.panes.forEach(({view}) => view.setCrosshair(voxel));
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
    this.panes.forEach(({view}, each) => view.zoomTo(this.times, each === number ? at : null));
    this.settings.tellTimes(this.times);
  }

  /** Shows the measurements. */
  mark() {
    const marks = this.volume ? this.measure.marks(this.volume) : [];
    this.panes.forEach(({view}) => view.setMarks(marks));
  }

  /** @param {import('./slice_settings.js').Look} look */
  look(look) {
    this.panes.forEach(({view}) => view.setLook(look, this.window.through));
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
    if (!this.volume) {
      return;
    }
    /** @type {Vector} */
    const voxel = [...this.voxel];
    voxel[this.planes[number].number] += by;
    this.point(voxel);
  }

  /** @param {number} value */
  tissue(value) {
    const {connection, modes, selection} = this.app;
    if (modes.current?.value) {
      modes.current.value(value);
    } else if (selection.name === '') {
      this.message.fail('There is no surface to adjust. Add a surface first.');
    } else if (this.volume) {
      connection.mark();
      void connection.set(isoCommand(selection.name, roundIso(value, this.volume)));
    }
  }

  /** Tells the value under the pointer, or under the crosshair. */
  tellValue() {
    if (!this.panes.some(({view}) => view.hover())) {
      this.hover(null, 0);
    }
  }

  /**
   * Tells the value under the pointer; without a pointer, the crosshair's.
   * @param {import('./slice_view.js').Under | null} under
   * @param {number} number  Index of the plane with the pointer.
   */
  hover(under, number) {
    const shown = this.panes.map(({view}, each) => ({plane: PLANES[each], slab: view.slab,
      at: under ? each === number ? under : null : view.valueAt(this.voxel)}));
    const own = shown.find(({at}) => at)?.at;
    if (!this.volume || !own) {
      this.readout.clear();
      return;
    }
    this.readout.tell(this.volume, own.voxel, own.own, !under, shown.flatMap(
      ({plane, slab, at}) => slab && at ? [{plane, slab, value: at.value}] : []));
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new SlicesPanel(root, app);
}
