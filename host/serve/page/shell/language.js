// The language of the page: as the browser prefers, or as the user chooses.
import {h} from '../elements/dom.js';
import {choiceRow} from '../panel/panel_parts.js';
import {changeLanguage, language, LANGUAGES, say} from '../texts/say.js';

/** @returns {HTMLElement} the choice of the language, which the browser keeps */
export function createLanguage() {
  const codes = /** @type {import('../texts/say.js').Language[]} */ (Object.keys(LANGUAGES));
  const row = choiceRow(say`Language`, codes.map(name => ({name, title: LANGUAGES[name],
    help: say`Language of this page. Messages of the machine are in English.`})), changeLanguage);
  row.show(language);
  row.element.setAttribute('translate', 'no');
  return h('div', {class: 'row languages'}, h('span', {class: 'muted'}, say`Language`),
    row.element);
}
