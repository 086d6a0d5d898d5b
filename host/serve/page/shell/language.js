// The language of the page: as the browser prefers, or as the user chooses.
import {h} from '../elements/dom.js';
import {ask} from '../elements/question.js';
import {choiceRow} from '../panel/panel_parts.js';
import {changeLanguage, language, LANGUAGES, say} from '../texts/say.js';

/**
 * @param {import('../panel/app.js').App} app
 * @returns {HTMLElement} the choice of the language, which the browser keeps
 */
export function createLanguage(app) {
  const codes = /** @type {import('../texts/say.js').Language[]} */ (Object.keys(LANGUAGES));
  const row = choiceRow(say`Language`, codes.map(name => ({name, title: LANGUAGES[name],
    help: say`Language of this page. Messages of the machine are in English.`})), async name => {
    if (name === language) {
      return;
    }
    // The page is loaded again.
    if (app.measures.list.length === 0 || await ask(say`Your measurements would be lost. Save the
      session to keep them. Change the language now?`, say`Change the language`)) {
      changeLanguage(name);
    } else {
      row.show(language);
      /** @type {HTMLElement | null} */ (row.element.querySelector('[aria-checked=true]'))?.focus();
    }
  });
  row.show(language);
  row.element.setAttribute('translate', 'no');
  return h('div', {class: 'row languages'}, h('span', {class: 'muted'}, say`Language`),
    row.element);
}
