// Tooltips that appear with the focus, too: a browser shows titles to a mouse only.
import {byId, h, setText} from '../elements/dom.js';

const GAP_PX = 6;           // Between the control and its tooltip.

/** The tooltip of the rail, for one control at a time. Escape hides it. */
export class Tips {
  constructor() {
    /** @private */
    this.tip_ = h('div', {id: 'tip', role: 'tooltip', 'data-testid': 'tip', hidden: true});
    /** @private @type {HTMLElement | null} */
    this.of_ = null;
    byId('rail').append(this.tip_);
    this.tip_.addEventListener('pointerleave', () => this.hide_());
    document.addEventListener('keydown', event => {
      if (event.key === 'Escape') {
        this.hide_();
      }
    });
  }

  /**
   * @param {HTMLElement} control
   * @param {string} text
   */
  add(control, text) {
    control.addEventListener('pointerenter', event => {
      if (event.pointerType === 'mouse') {
        this.show_(control, text);
      }
    });
    // A pointer may go on to the tooltip.
    control.addEventListener('pointerleave', event => {
      if (event.relatedTarget !== this.tip_) {
        this.hide_();
      }
    });
    control.addEventListener('pointerdown', () => this.hide_());
    control.addEventListener('focus', () => {
      if (control.matches(':focus-visible')) {
        this.show_(control, text);
      }
    });
    control.addEventListener('blur', () => this.hide_());
  }

  /**
   * Shows it at the left of a control in a column, and above others.
   * @private
   * @param {HTMLElement} control
   * @param {string} text
   */
  show_(control, text) {
    this.hide_();
    this.of_ = control;
    setText(this.tip_, text);
    this.tip_.hidden = false;
    control.setAttribute('aria-describedby', this.tip_.id);
    const box = control.getBoundingClientRect(), own = this.tip_.getBoundingClientRect();
    const isBeside = control.closest('[aria-orientation=vertical]') !== null;
    const left = isBeside ? box.left - GAP_PX - own.width
      : Math.max(0, Math.min(innerWidth - own.width, box.left + (box.width - own.width) / 2));
    const top = isBeside ? box.top + (box.height - own.height) / 2 : box.top - GAP_PX - own.height;
    Object.assign(this.tip_.style, {left: `${left}px`, top: `${top}px`});
  }

  /** @private */
  hide_() {
    this.of_?.removeAttribute('aria-describedby');
    this.of_ = null;
    this.tip_.hidden = true;
  }
}
