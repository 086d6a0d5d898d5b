// Where the slices are: in their panel, or beside the picture.
import {byId} from '../elements/dom.js';

/** @typedef {import('../panel/app.js').App} App */

export class SlicePlace {
  /**
   * @param {App} app
   * @param {HTMLElement} root    The panel.
   * @param {{grid: HTMLElement, readout: HTMLElement, panes: HTMLElement[]}} parts
   * @param {(isSeen: boolean) => void} tell  Called when the slices come into sight or leave it.
   */
  constructor(app, root, {grid, readout, panes}, tell) {
    /** @private */ this.layout_ = app.layout;
    /** @private */ this.grid_ = grid;
    /** @private */ this.panes_ = panes;
    let isShown = false;
    const look = () => tell(isBeside() || isShown && app.layout.now.right);
    const isBeside = () => app.layout.now.name !== 'picture';
    const home = document.createComment('slices');
    grid.before(home);
    app.layout.watch(() => {
      const focused = document.activeElement;
      if (isBeside() && grid.parentElement === root) {
        byId('panes').append(grid);
        byId('panes').after(readout);
      } else if (!isBeside() && grid.parentElement !== root) {
        home.after(grid, readout);
      }
      this.order_();
      if (focused instanceof HTMLElement && grid.contains(focused)) {
        focused.focus();  // A move drops the focus.
      }
      look();
    });
    root.addEventListener('panelshow', () => { isShown = true; look(); });
    root.addEventListener('panelhide', () => { isShown = false; look(); });
    // What is clicked on the picture must be in sight.
    app.modes.watch(mode => {
      if (mode && !mode.value && app.layout.now.name === 'slices') {
        app.layout.change({name: 'four'});
      }
    });
  }

  /** @param {number} chosen  Beside the picture, a large slice takes the place of the picture. */
  enlarge(chosen) {
    this.panes_.forEach((pane, number) => pane.classList.toggle('large', number === chosen));
    if (['beside', 'four'].includes(this.layout_.now.name)) {
      this.layout_.change({name: 'slices'});
    }
    this.order_();
  }

  /** The large slice is first, unless all have one size. @private */
  order_() {
    const isEven = ['beside', 'four'].includes(this.layout_.now.name);
    const large = this.panes_.find(pane => pane.classList.contains('large'));
    const wished = isEven || !large ? this.panes_
      : [large, ...this.panes_.filter(pane => pane !== large)];
    if (wished.some((pane, at) => this.grid_.children[at] !== pane)) {
      this.grid_.append(...wished);
    }
  }
}
