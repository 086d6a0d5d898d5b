// The texts that the page's code has for people: those behind say`...`, and those of index.html.
import { readdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { keyOf } from '../../../host/serve/page/texts/say.js';

export const pageFolder = fileURLToPath(new URL('../../../host/serve/page', import.meta.url));
const require = createRequire(path.join(process.env.PXPL5_NODE_MODULES, 'here.js'));
const ts = require('typescript');

/** All modules of the page, below its folder. */
function modules() {
  return readdirSync(pageFolder, { recursive: true }).map(String)
    .filter(name => name.endsWith('.js'));
}

/** The room of a module: its folder, 'index' for main.js. */
function roomOf(name) {
  return name.includes(path.sep) ? name.split(path.sep)[0] : 'index';
}

/** The key of a template behind `say`, as say() makes it. */
function keyOfTemplate(template) {
  return keyOf(ts.isNoSubstitutionTemplateLiteral(template) ? [template.text]
    : [template.head.text, ...template.templateSpans.map(span => span.literal.text)]);
}

/**
 * The keys in a module's text.
 * @returns {{key: string, line: number}[]}
 */
export function keysIn(name, text) {
  const source = ts.createSourceFile(name, text, ts.ScriptTarget.Latest, true);
  const found = [];
  const visit = node => {
    if (ts.isTaggedTemplateExpression(node) && node.tag.getText(source) === 'say') {
      const { line } = source.getLineAndCharacterOfPosition(node.getStart());
      found.push({ key: keyOfTemplate(node.template), line: line + 1 });
    }
    ts.forEachChild(node, visit);
  };
  visit(source);
  return found;
}

/** Whether an expression is text in the code, other than behind `say`. */
function isPlain(node) {
  if (ts.isConditionalExpression(node)) return isPlain(node.whenTrue) || isPlain(node.whenFalse);
  if (ts.isBinaryExpression(node)) return isPlain(node.left) || isPlain(node.right);
  if (ts.isParenthesizedExpression(node)) return isPlain(node.expression);
  return ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node) ||
    ts.isTemplateExpression(node);
}

/**
 * The errors in a module's text whose sentence is not translated. A mistake of a programmer is a
 * ReferenceError, and needs no translation.
 * @returns {string[]} each with its line
 */
export function plainErrorsIn(name, text) {
  const source = ts.createSourceFile(name, text, ts.ScriptTarget.Latest, true);
  const found = [];
  const visit = node => {
    if (ts.isNewExpression(node) && node.expression.getText(source) === 'Error' &&
        (node.arguments ?? []).some(isPlain)) {
      const { line } = source.getLineAndCharacterOfPosition(node.getStart());
      found.push(`${name}:${line + 1}: ${node.getText(source)}`);
    }
    ts.forEachChild(node, visit);
  };
  visit(source);
  return found;
}

/** The errors of all modules whose sentence is not translated. */
export function plainErrors() {
  return modules().flatMap(name =>
    plainErrorsIn(name, readFileSync(path.join(pageFolder, name), 'utf8')));
}

/** The texts of index.html that people read or hear. */
export function keysOfIndex() {
  const body = readFileSync(path.join(pageFolder, 'index.html'), 'utf8').split('<body>')[1];
  const attributes = [...body.matchAll(/(?:aria-label|title|alt)="([^"]+)"/g)];
  const texts = [...body.matchAll(/>([^<>]*[A-Za-z][^<>]*)</g)];
  return [...attributes, ...texts].map(match => match[1].trim());
}

/**
 * The keys of each room, with the first place of each.
 * @returns {Map<string, Map<string, string>>}
 */
export function keysByRoom() {
  const rooms = new Map();
  const add = (room, key, place) => {
    if (!rooms.has(room)) rooms.set(room, new Map());
    if (!rooms.get(room).has(key)) rooms.get(room).set(key, place);
  };
  for (const name of modules().sort()) {
    const text = readFileSync(path.join(pageFolder, name), 'utf8');
    for (const { key, line } of keysIn(name, text)) add(roomOf(name), key, `${name}:${line}`);
  }
  for (const key of keysOfIndex()) add('index', key, 'index.html');
  return rooms;
}
