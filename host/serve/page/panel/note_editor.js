// A field over a slice or the picture, in which the text of a note is written.
import {h} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {MOST_NOTE} from './measures.js';

/**
 * Asks for a text. Enter or a click elsewhere keeps it, Esc does not.
 * @param {HTMLElement} beside  What gets the focus back. Its parent, which has a position, gets the
 *     field.
 * @param {[number, number]} place  CSS pixels from the upper left corner of the parent.
 * @param {string} text         To begin with.
 * @param {(text: string | null) => void} done  Null: Esc, or no text.
 */
export function editNote(beside, [x, y], text, done) {
  let isDone = false;
  const end = (/** @type {string | null} */ written) => {
    if (!isDone) {
      isDone = true;
      field.remove();
      done(written?.trim() ? written.trim() : null);
    }
  };
  const field = h('input', {type: 'text', class: 'note-editor', value: text, maxlength: MOST_NOTE,
    'aria-label': say`Text of the note`, 'data-testid': 'note-editor',
    onblur: () => end(field.value),
    onpointerdown: (/** @type {Event} */ event) => event.stopPropagation(),
    onkeydown: (/** @type {KeyboardEvent} */ event) => {
      event.stopPropagation();
      if (event.key === 'Enter' || event.key === 'Escape') {
        end(event.key === 'Enter' ? field.value : null);
        beside.focus({preventScroll: true});
      }
    }});
  const around = beside.parentElement ?? beside;
  around.append(field);
  const most = (/** @type {number} */ whole, /** @type {number} */ own) =>
    Math.max(whole - own, 0);
  field.style.left = `${Math.min(Math.max(x, 0), most(around.clientWidth, field.offsetWidth))}px`;
  field.style.top = `${Math.min(Math.max(y, 0), most(around.clientHeight, field.offsetHeight))}px`;
  field.focus();
  field.select();
}
