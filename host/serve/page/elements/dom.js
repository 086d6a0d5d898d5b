// Makes elements. Text never becomes markup, so texts of the server cannot add tags.

const SVG = 'http://www.w3.org/2000/svg';

/** @typedef {string | number | Node | null | undefined | false} Child */
/** @typedef {Record<string, any>} Attributes  `on...` are listeners; false omits an attribute. */

/** Attributes of elements whose text is data, the same in each language: names and paths. */
export const DATA = Object.freeze({translate: 'no'});
/** Attributes of elements whose text was written by the machine, in English. */
export const ENGLISH = Object.freeze({lang: 'en'});

/**
 * @param {Element} element
 * @param {Attributes} attributes
 * @param {Child[]} children
 */
function fill(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) {
      element.addEventListener(key.slice(2), value);
    } else if (key === 'value' && 'value' in element) {
      element.value = value;
    } else if (value === true) {
      element.setAttribute(key, '');
    } else if (value !== false && value !== undefined && value !== null) {
      element.setAttribute(key, String(value));
    }
  }
  const shown = children.filter(child => child !== null && child !== undefined && child !== false);
  element.append(.../** @type {(string | Node)[]} */ (
    shown.map(child => typeof child === 'number' ? String(child) : child)));
}

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  fill(element, attributes, children);
  return element;
}

/**
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function s(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, tag);
  fill(element, attributes, children);
  return element;
}

/**
 * The element of index.html with that id.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) {
    throw new ReferenceError(`index.html has no element '${id}'`);
  }
  return element;
}

/**
 * Sets the text of an element if it differs, to avoid needless layout.
 * @param {Element} element
 * @param {string} text
 */
export function setText(element, text) {
  if (element.textContent !== text) {
    element.textContent = text;
  }
}

/**
 * Sets the text of a message.
 * @param {HTMLElement} element
 * @param {string} text
 * @param {boolean} isOwn  Whether the page wrote it, in its language; else the machine did.
 */
export function setMessage(element, text, isOwn) {
  element.textContent = text;
  update(element, {lang: isOwn ? null : ENGLISH.lang});
}

/**
 * Sets only attributes that differ, to avoid needless layout.
 * @param {Element} element
 * @param {Record<string, string | number | null>} attributes  null removes.
 */
export function update(element, attributes) {
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null) {
      element.removeAttribute(key);
    } else if (element.getAttribute(key) !== String(value)) {
      element.setAttribute(key, String(value));
    }
  }
}
