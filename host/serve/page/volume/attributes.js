// The DICOM attributes of the open scan's middle file, in a dialog with a filter.
import {closeBeside} from '../elements/dialog.js';
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';
import {UPLOAD} from './words.js';

/** @typedef {import('../panel/app.js').App} App */
/**
 * Group, element, depth in sequences, keyword, representation, value, whether the value was cut.
 * @typedef {[number, number, number, string, string, string, boolean]} Attribute
 */

/**
 * "(0010,0020)"
 * @param {number} group
 * @param {number} element
 */
export function tagText(group, element) {
  const hex = (/** @type {number} */ each) => each.toString(16).padStart(4, '0');
  return `(${hex(group)},${hex(element)})`;
}

/**
 * Whether the tag, keyword or value contains each word of the filter.
 * @param {Attribute} attribute
 * @param {string} filter
 */
export function isFound([group, element, , keyword, vr, value], filter) {
  const text = `${tagText(group, element)} ${keyword} ${vr} ${value}`.toLowerCase();
  return filter.toLowerCase().split(/\s+/).every(word => text.includes(word));
}

/**
 * @param {App} app
 * @returns {HTMLButtonElement} shows the dialog
 */
export function createAttributes(app) {
  const rows = h('tbody');
  const table = h('table', {class: 'attributes', 'data-testid': 'attributes-table'},
    h('thead', {}, h('tr', {}, ...[say`Tag`, say`Attribute`, say`VR`, say`Value`].map(
      name => h('th', {scope: 'col'}, name)))), rows);
  const told = h('p', {class: 'muted told', role: 'status', 'data-testid': 'attributes-told'});
  const filter = h('input', {type: 'text', class: 'grow', autocomplete: 'off',
    spellcheck: 'false', 'data-testid': 'attributes-filter', oninput: () => draw()});
  const dialog = h('dialog', {id: 'attributes', 'aria-label': say`DICOM attributes`,
    'data-testid': 'attributes'},
    h('div', {class: 'row spread'}, h('h2', {}, say`DICOM attributes`),
      h('button', {class: 'quiet icon', 'aria-label': say`Close`, onclick: () => dialog.close()},
        '×')),
    h('label', {class: 'row'}, say`Filter`, filter), told,
    h('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': say`Attributes`}, table));
  closeBeside(dialog);
  document.body.append(dialog);
  /** @type {{file: string, attributes: Attribute[], is_whole: boolean} | null} */
  let answer = null;
  const draw = () => {
    if (!answer) {
      return;
    }
    const found = answer.attributes.filter(each => isFound(each, filter.value.trim()));
    rows.replaceChildren(...found.map(rowOf));
    told.textContent = countText(found.length, answer.attributes.length,
      answer.file.split('/').at(-1) ?? '')
      + (answer.is_whole ? '' : ` ${say`The file has more, which are not listed.`}`);
  };
  const show = async () => {
    answer = null;
    rows.replaceChildren();
    told.textContent = say`Reading …`;
    dialog.showModal();
    filter.focus();
    try {
      answer = (await app.connection.ask({ask: 'attributes'})).json;
      draw();
    } catch (error) {
      told.textContent = /** @type {Error} */ (error).message.replace(UPLOAD, '');
    }
  };
  return h('button', {'data-testid': 'attributes-show', onclick: () => void show()},
    say`DICOM attributes …`);
}

/**
 * @param {number} found
 * @param {number} all
 * @param {string} file
 */
function countText(found, all, file) {
  return plural(all, say`${grouped(found)} of 1 attribute of the middle slice, ${file}.`,
    say`${grouped(found)} of ${grouped(all)} attributes of the middle slice, ${file}.`);
}

/** @param {Attribute} attribute */
function rowOf([group, element, depth, keyword, vr, value, isCut]) {
  return h('tr', {},
    h('td', {class: 'mono'}, `${'› '.repeat(depth)}${tagText(group, element)}`),
    h('td', {}, ...keyword ? words(keyword) : [group % 2 === 1 ? say`private` : '']),
    h('td', {}, vr),
    h('td', {class: 'value'}, value, isCut && h('span', {class: 'muted'}, ` ${say`… (cut)`}`)));
}

/**
 * "PatientName", with a place between its words where a narrow window may break it.
 * @param {string} keyword
 */
function words(keyword) {
  return keyword.split(/(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])/).flatMap((word, at) =>
    at === 0 ? [word] : [h('wbr'), word]);
}
