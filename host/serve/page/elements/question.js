// A question that is answered before the page goes on, in the language of the page.
import {say} from '../texts/say.js';
import {closeBeside} from './dialog.js';
import {h} from './dom.js';

/**
 * Asks whether something is to be done. Esc and a click beside the dialog mean no. The focus is on
 * "Cancel", and afterwards where it was before.
 * @param {string} question
 * @param {string} yes      What is done: the text of the button.
 * @returns {Promise<boolean>}
 */
export function ask(question, yes) {
  return new Promise(answer => {
    const dialog = h('dialog', {class: 'question', role: 'alertdialog', 'aria-label': yes,
      'aria-describedby': 'question-text', 'data-testid': 'question'},
    h('p', {id: 'question-text', 'data-testid': 'question-text'}, question),
    h('div', {class: 'dialog-buttons'},
      h('button', {type: 'button', 'data-testid': 'question-yes',
        onclick: () => dialog.close('yes')}, yes),
      h('button', {type: 'button', autofocus: true, 'data-testid': 'question-no',
        onclick: () => dialog.close()}, say`Cancel`)));
    closeBeside(dialog);
    dialog.addEventListener('close', () => {
      dialog.remove();
      answer(dialog.returnValue === 'yes');
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
