// Slices in the picture of the surfaces: the machine draws them, and they follow the crosshair.
import {h} from '../elements/dom.js';
import {icon} from '../elements/icons.js';
import {toLine} from '../link/lines.js';
import {say} from '../texts/say.js';
import {sliceWord} from './slice_words.js';

/** @typedef {import('../link/lines.js').Command} Command */

const AXES = 'xyz';

/**
 * @typedef {object} Now  What the panel shows.
 * @property {{plane: string, number: number}[]} planes  The voxel axis across each plane.
 * @property {number[]} voxel                            The crosshair.
 * @property {import('./windows.js').Window} through     The window.
 */

/** A button for each slice. */
export class SlicesInPicture {
  /**
   * @param {import('../panel/app.js').App} app
   * @param {string[]} planes     As the keys of sliceWord().
   * @param {() => Now | null} now  Null without a volume.
   */
  constructor(app, planes, now) {
    /** @private */ this.app_ = app;
    /** @private */ this.now_ = now;
    /** @private Voxel axes whose slices the picture shows. @type {Set<number>} */
    this.axes_ = new Set();
    /** @private The newest line that was sent, or that the state stands for. */ this.sent_ = '';
    /** @private Lines without an answer. */ this.unanswered_ = 0;
    /** @private */ this.isOpening_ = false;
    /** A button for the head of each slice. */
    this.buttons = planes.map((plane, number) => h('button', {type: 'button',
      class: 'icon quiet drives', 'aria-pressed': 'false', 'data-testid': `in-picture-${number}`,
      'aria-label': say`${sliceWord(plane)} in the picture`,
      title: say`The picture shows this slice, too`, onclick: () => this.toggle_(number)},
    icon('picture')));
    app.store.subscribe(['planes', 'volume'], () => this.show());
  }

  /** Shows which slices are in the picture. */
  show() {
    const {state} = this.app_.store;
    if (state && this.unanswered_ === 0) {  // Undo, a script or another page may have changed it.
      this.axes_ = new Set(state.planes.map(({axis}) => AXES.indexOf(axis)));
      this.sent_ = toLine({name: 'planes', options: {
        ...Object.fromEntries(state.planes.map(({axis, index}) => [axis, index])),
        window: state.planes_window, level: state.planes_level}});
    }
    const now = this.now_();
    this.buttons.forEach((button, number) => {
      button.setAttribute('aria-pressed',
        String(now !== null && this.axes_.has(now.planes[number]?.number)));
      button.hidden = !state?.volume;
    });
  }

  /**
   * @private
   * @param {number} number  Index of the plane.
   */
  toggle_(number) {
    const now = this.now_(), axis = now?.planes[number]?.number;
    if (!now || axis === undefined) {
      return;
    }
    this.app_.connection.mark();
    if (this.axes_.delete(axis)) {
      void this.send_({name: 'planes', options: {[AXES[axis]]: 'off'}});
    } else {
      this.axes_.add(axis);
      void this.send_(placed([axis], now));
    }
  }

  /** @param {() => void} open  Opens a volume. What it changes is not sent. */
  whileOpening(open) {
    this.isOpening_ = true;
    open();
    this.isOpening_ = false;
    this.show();
  }

  /**
   * The first crosshair of a volume: in the middle, or on slices that the picture shows already.
   * Then their window becomes that of the panel.
   * @param {import('../link/vocabulary.js').VolumeState} volume
   * @param {{look: (through: import('./windows.js').Window) => void}} controls
   * @returns {import('./patient_grid.js').Vector}
   */
  firstVoxel({size}, controls) {
    const {state} = this.app_.store, planes = state?.planes ?? [];
    if (state && planes.length > 0) {
      controls.look({window: state.planes_window, level: state.planes_level});
    }
    return /** @type {import('./patient_grid.js').Vector} */ (size.map((count, axis) =>
      planes.find(plane => plane.axis === AXES[axis])?.index ?? Math.floor(count / 2)));
  }

  /** The crosshair or the window has changed. */
  follow() {
    const now = this.now_();
    if (this.axes_.size > 0 && now && !this.isOpening_ && !this.app_.connection.watches) {
      const command = placed([...this.axes_].sort(), now);
      if (toLine(command) !== this.sent_) {
        void this.send_(command);
      }
    }
  }

  /**
   * @private
   * @param {Command} command
   */
  async send_(command) {
    this.sent_ = toLine(command);
    ++this.unanswered_;
    const {ok} = await this.app_.connection.set(command);
    --this.unanswered_;
    if (!ok && this.unanswered_ === 0) {
      this.show();  // Nothing has changed.
    }
  }
}

/**
 * The command that shows slices.
 * @param {number[]} axes  Voxel axes across which there is a slice, ascending.
 * @param {Now} now
 * @returns {Command}
 */
function placed(axes, {voxel, through}) {
  return {name: 'planes', options: {
    ...Object.fromEntries(axes.map(axis => [AXES[axis], Math.round(voxel[axis])])), ...through}};
}
