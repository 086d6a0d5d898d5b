// Panel: three slices of the volume, linked to each other and to the picture.
import {h} from '../elements/dom.js';
import {isoCommand, roundIso} from '../link/lines.js';
import {choiceRow, intro, messageLine, numberField} from '../panel/panel_parts.js';
import {nearestVoxel, patientText, toPatient, toVoxel} from './patient_grid.js';
import {CT_WINDOWS, allValues, firstWindow, isHounsfield} from './slice_pixels.js';
import {planesOf} from './slice_planes.js';
import {SliceSource} from './slice_source.js';
import {SliceView} from './slice_view.js';
import {beyond} from './slice_words.js';

/** @typedef {import('./patient_grid.js').Vector} Vector */
/** @typedef {import('./slice_pixels.js').Window} Window */
/** @typedef {import('../link/vocabulary.js').VolumeState} VolumeState */

const PLANES = ['Axial', 'Coronal', 'Sagittal'];
const SELF = 'slices';
const REST_MS = 250;        // A dragged isovalue rests after this time.
const DRAG_ACROSS_RANGE = 400;  // CSS pixels of a window/level drag per 1,000 values.
const LEAST_TILT_DEG = 0.1;  // Smaller angles are rounding errors of the file.
const EMPTY = 'No volume is open. Open a volume to see its slices.';

/** @typedef {{view: SliceView, source: SliceSource, element: HTMLElement,
 *   slider: HTMLInputElement, count: HTMLElement}} Pane */

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
    /** @type {Window} */
    this.through = {window: 1, level: 0};
    /** @type {Vector} */
    this.voxel = [0, 0, 0];
    /** @type {ReturnType<typeof planesOf>} */
    this.planes = [];
    /** The first end of a length, in mm. @type {Vector | null} */
    this.first = null;
    /** Number of opened volumes. */
    this.opened = 0;
    /** The settings that the contours depend on, as JSON. */
    this.contours = '';
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.resting = undefined;
    this.visible = false;
    this.stale = true;
    this.message = messageLine('slices-message');
    this.readout = h('p', {class: 'readout', 'data-testid': 'slices-readout'});
    this.notes = h('p', {class: 'legend', 'data-testid': 'slices-notes'});
    this.beyond = h('p', {class: 'legend', 'data-testid': 'slices-beyond'});
    this.panes = PLANES.map((_, number) => this.pane(number));
    this.grid = h('div', {class: 'slice-grid'}, ...this.panes.map(pane => pane.element));
    this.target = h('select', {'aria-label': 'Surface to adjust', hidden: true,
      'data-testid': 'slices-surface', onchange: () => app.selection.choose(this.target.value)});
    /** @type {import('./slice_view.js').Tool}  The chosen tool. A mode may replace it. */
    this.tool = 'point';
    this.window = numberField('Window', 'slices-window', window =>
      this.look({...this.through, window: Math.max(window, 1e-6)}));
    this.level = numberField('Level', 'slices-level', level => this.look({...this.through, level}));
    this.presets = this.presetRow();
    this.build();
    this.listen();
  }

  build() {
    this.tools = choiceRow('Tool for the slices', [
      {name: 'point', title: 'Point', help: 'Move the crosshair, here and in the picture'},
      {name: 'measure', title: 'Measure', help: 'Distance between two clicks, in any slices'},
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
      h('div', {class: 'tool-row'}, this.tools.element, this.target),
      h('div', {class: 'tool-row'}, this.window.element, this.level.element), this.presets,
      this.message.element, this.beyond, this.grid, this.readout, this.notes);
  }

  /** A click sets an isovalue while the tissue mode is on. */
  takeTool() {
    const tool = this.app.modes.current?.value ? 'tissue' : this.tool;
    for (const {view} of this.panes) {
      view.setTool(tool);
    }
    this.first = null;
    this.tools?.show(tool);
    this.target.hidden = tool !== 'tissue';
  }

  presetRow() {
    const chips = CT_WINDOWS.map(({name, window, level}) => h('button', {type: 'button',
      class: 'chip hounsfield', 'data-testid': `window-${name}`,
      onclick: () => this.look({window, level})}, name));
    const full = h('button', {type: 'button', class: 'chip', 'data-testid': 'window-full',
      title: 'Full range of values', onclick: () => this.volume &&
        this.look(allValues(this.volume))}, 'All values');
    return h('div', {class: 'presets'}, ...chips, full);
  }

  /**
   * @param {number} number  Index of the plane.
   * @returns {Pane}
   */
  pane(number) {
    const view = new SliceView(PLANES[number], {
      point: voxel => this.point(voxel),
      measure: voxel => void this.measure(voxel),
      tissue: value => this.tissue(value),
      hover: (voxel, value) => this.hover(voxel, value),
      step: by => this.step(number, by),
      window: (across, down) => this.drag(across, down),
    });
    const source = new SliceSource(this.app.connection, {
      slice: slice => {
        if (this.volume) {
          view.show(slice, this.volume.size, this.through);
          view.setCrosshair(this.voxel);
          count.textContent = `${slice.index + 1} / ${this.volume.size[slice.axes[2]]}`;
          this.tell(slice);
        }
      },
      failed: sentence => this.message.fail(sentence),
    });
    const slider = h('input', {type: 'range', min: 0, max: 0, value: 0,
      'aria-label': `${PLANES[number]} slice`, 'data-testid': `slice-index-${number}`,
      oninput: () => this.step(number, Number(slider.value) - Math.round(
        this.voxel[this.planes[number].number]))});
    const count = h('span', {class: 'slice-count', 'data-testid': `slice-count-${number}`});
    const enlarge = h('button', {type: 'button', class: 'quiet', title: 'Enlarge this slice',
      onclick: () => this.enlarge(number)}, PLANES[number]);
    const element = h('div', {class: number === 0 ? 'slice-pane large' : 'slice-pane'},
      h('div', {class: 'slice-head'}, enlarge, count), view.canvas, slider);
    return {view, source, element, slider, count};
  }

  /** @param {number} chosen */
  enlarge(chosen) {
    this.panes.forEach(({element}, number) => element.classList.toggle('large', number === chosen));
    this.grid.prepend(this.panes[chosen].element);
  }

  listen() {
    const {store, connection, modes, selection, session} = this.app;
    session.add('window', {save: () => this.volume && this.through,
      restore: through => this.look(through)});
    session.add('crosshair', {save: () => this.volume && this.voxel,
      restore: voxel => this.point(voxel)});
    modes.watch(() => this.takeTool());
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
        this.refresh(({element}) => element.classList.contains('large'));
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
    this.root.addEventListener('panelshow', () => {
      this.visible = true;
      if (this.stale) {
        this.refresh();
      }
    });
    this.root.addEventListener('panelhide', () => { this.visible = false; });
  }

  /** @param {VolumeState | null} volume */
  open(volume) {
    const same = volume !== null && volume.identity === this.volume?.identity;
    this.volume = volume;
    ++this.opened;
    this.first = null;
    this.root.classList.toggle('empty', volume === null);
    this.message.say(volume ? '' : EMPTY);
    this.notes.textContent = '';
    this.readout.textContent = '';
    for (const {view, source, count} of this.panes) {
      source.forget();
      view.clear();
      count.textContent = '';
    }
    if (!volume) {
      return;
    }
    this.planes = planesOf(volume.voxel_to_patient);
    for (const chip of this.presets.querySelectorAll('.hounsfield')) {
      chip.toggleAttribute('hidden', !isHounsfield(volume));
    }
    if (!same) {
      this.look(firstWindow(volume));
      this.move(/** @type {Vector} */ (volume.size.map(count => Math.floor(count / 2))));
    } else {
      this.refresh();
    }
  }

  /**
   * Reports where a slice differs from the scan.
   * @param {import('./slice_pixels.js').Slice} slice
   */
  tell({contours, skew_deg = 0}) {
    const left = contours.filter(({left_out}) => left_out).map(({surface}) => surface);
    this.message.say(left.length > 0
      ? `Too many lines in this slice: contours of ${left.join(', ')} are incomplete.` : '');
    const gaps = this.volume?.gaps ?? 0;
    const isTilted = Math.abs(skew_deg) >= LEAST_TILT_DEG;
    const isGantry = this.volume?.modality === 'CT';
    this.notes.textContent = [
      gaps > 0 ? `Slices are missing in ${gaps} ${gaps === 1 ? 'place' : 'places'}: rows beside ` +
        'a gap are taller.' : '',
      isTilted ? `The ${isGantry ? 'gantry was tilted' : 'slices are sheared'} by ` +
        `${Math.abs(skew_deg).toFixed(1)}°. Slices across the ${isGantry ? 'tilt' : 'shear'} ` +
        'are drawn without shear.' : '',
    ].filter(Boolean).join(' ');
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
        source.want(axis, index, `${this.opened} ${this.contours}`);
      }
    });
  }

  /** @param {Vector} voxel  The crosshair goes there. */
  move(voxel) {
    this.voxel = voxel;
    this.panes.forEach(({view}) => view.setCrosshair(voxel));
    this.refresh();
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

  /** @param {Vector} voxel  An end of a length, not rounded. */
  async measure(voxel) {
    const volume = this.volume, first = this.first;
    if (!volume) {
      return;
    }
    const p_mm = toPatient(volume, voxel);
    this.first = first ? null : p_mm;
    if (!first) {
      this.message.say('Click the second point, in any slice.');
      return;
    }
    const {ok, error = '', result} = await this.app.connection.do(
      `measure ${first.join(',')} ${p_mm.join(',')}`, {quiet: true});
    if (!ok) {
      this.message.fail(error);
      return;
    }
    this.message.say(`${result.distance_mm.toFixed(1)} mm. The tab Measure lists all distances.`);
    document.dispatchEvent(new CustomEvent('distance', {detail: result}));
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

  /**
   * @param {Vector | null} voxel
   * @param {number | null} value
   */
  hover(voxel, value) {
    const volume = this.volume;
    if (!volume || !voxel || value === null) {
      this.readout.textContent = '';
      return;
    }
    const [x, y, z] = nearestVoxel(volume, voxel);
    const shown = `${Number(value.toPrecision(6))} ${volume.unit}`.trim();
    this.readout.replaceChildren(h('b', {}, shown), ` at voxel ${x}, ${y}, ${z}`,
      h('span', {}, patientText(toPatient(volume, voxel))));
  }

  /**
   * Changes the window by a drag, as on workstations: across widens, down darkens.
   * @param {number} across
   * @param {number} down
   */
  drag(across, down) {
    const range = this.volume ? this.volume.maximum - this.volume.minimum : 1;
    const each = Math.min(range, 1000) / DRAG_ACROSS_RANGE;
    this.look({
      window: Math.max(this.through.window + 2 * across * each, each),
      level: this.through.level + down * each,
    });
  }

  /** @param {Window} through */
  look(through) {
    this.through = through;
    this.window.input.value = String(Number(through.window.toPrecision(4)));
    this.level.input.value = String(Number(through.level.toPrecision(4)));
    this.panes.forEach(({view}) => view.repaint(through));
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new SlicesPanel(root, app);
}
