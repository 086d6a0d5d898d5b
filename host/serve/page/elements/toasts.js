// Messages for the user. Errors stay until the user closes them, notes for 6 s.
import {say} from '../texts/say.js';
import {h} from './dom.js';

const NOTE_MS = 6000;
const MOST = 4;
/** Subject of errors that disappear after a volume or a session was opened. */
export const OPENING = 'opening';

export class Toasts {
  /** @param {HTMLElement} root */
  constructor(root) {
    /** @private */
    this.root_ = root;
  }

  /**
   * @param {string} text
   * @param {HTMLElement[]} [links]  A note with links stays until the user closes it.
   * @param {import('./dom.js').Attributes} [attributes]  Of the text: ENGLISH, for example.
   */
  info(text, links = [], attributes = {}) {
    const toast = this.add_('info', text, attributes);
    if (links.length === 0) {
      setTimeout(() => toast.remove(), NOTE_MS);
    } else {
      toast.querySelector('p')?.append(' ', ...links);
    }
  }

  /**
   * @param {string} text
   * @param {string} [about]  See forget.
   * @param {import('./dom.js').Attributes} [attributes]  Of the text: ENGLISH, for example.
   */
  error(text, about = '', attributes = {}) {
    this.add_('error', text, attributes).dataset.about = about;
  }

  /**
   * Removes the errors about a subject, for example after a success.
   * @param {string} about
   */
  forget(about) {
    for (const toast of this.root_.querySelectorAll(`.toast[data-about="${about}"]`)) {
      toast.remove();
    }
  }

  /**
   * @private
   * @param {'info' | 'error'} level
   * @param {string} text
   * @param {import('./dom.js').Attributes} attributes
   */
  add_(level, text, attributes) {
    for (const same of this.root_.querySelectorAll('.toast')) {
      if (same.querySelector('p')?.textContent === text) {
        same.remove();
      }
    }
    while (this.root_.childElementCount >= MOST) {
      // A note goes before an error that may not have been read.
      (this.root_.querySelector('.toast.info') ?? this.root_.firstElementChild)?.remove();
    }
    const toast = h('div', {class: `toast ${level}`, 'data-testid': `toast-${level}`},
      h('p', attributes, text));
    toast.append(h('button', {class: 'quiet', 'aria-label': say`Close this message`,
      onclick: () => toast.remove()}, '×'));
    this.root_.append(toast);
    return toast;
  }
}
