// Texts of the page: how a text is said, and that each language has all of them, and no other.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import { kindWord } from '../../../host/serve/page/panel/measure_words.js';
import { CATALOGS, keyOf, LANGUAGES, plural, say } from '../../../host/serve/page/texts/say.js';
import { keysByRoom, keysIn, keysOfIndex, pageFolder, plainErrors, plainErrorsIn }
  from './said.js';

/** The numbers of the parts in a text, each once, in order. */
function partsOf(text) {
  return [...new Set(text.match(/\{\d+\}/g) ?? [])].sort().join(' ');
}

test('English is the text in the code, with its parts', () => {
  const [name, count] = ['bone', 3];
  assert.equal(say`Nothing to undo`, 'Nothing to undo');
  assert.equal(say`Undo: ${name} (key U)`, 'Undo: bone (key U)');
  assert.equal(say`${count} of ${count} in ${name}`, '3 of 3 in bone');
  assert.equal(say`${'{1}'} and $& of ${'$1'}`, '{1} and $& of $1', 'parts are no templates');
  assert.equal(say`A long text
    in two lines`, 'A long text in two lines');
  for (const each of [1, 2]) assert.equal(say`${each} nodes`, `${each} nodes`);
});

test('a part that ends in a full stop has no second one behind it', () => {
  const end = why => say`It ends: ${why}. Go on.`;
  assert.equal(end('the file is short'), 'It ends: the file is short. Go on.');
  assert.equal(end('The file is short.'), 'It ends: The file is short. Go on.');
  assert.equal(say`${'A.'}.`, 'A.');
  assert.equal(say`${'A'}, ${'B.'}.`, 'A, B.');
  assert.equal(say`${'A.'} ${2}.`, 'A. 2.');
});

test('soft hyphens are in texts for narrow places alone', async () => {
  const wrong = [];
  for (const [code, load] of Object.entries(CATALOGS)) {
    for (const [key, text] of Object.entries((await load()).default)) {
      const isNarrow = key.endsWith('|with soft hyphens');
      if (text.includes('\u00ad') && !isNarrow) wrong.push(`${code}: ${key}`);
    }
  }
  assert.deepEqual(wrong, []);
});

test('a meaning behind a word is not shown', () => {
  assert.equal(say`note|finding`, 'note');
});

test('a kind of measurement has one word in each language', async () => {
  const kinds = ['distance', 'angle', 'path', 'ellipse', 'rectangle', 'part', 'note'];
  for (const kind of kinds) assert.equal(kindWord(kind), kind);
  for (const [code, load] of Object.entries(CATALOGS)) {
    const { default: texts } = await load();
    const titles = kinds.map(kind => texts[kind[0].toUpperCase() + kind.slice(1)]);
    assert.deepEqual(kinds.map(kind => texts[kind].toLowerCase()),
                     titles.map(title => title.toLowerCase()), code);
  }
});

test('the key of a template has numbers for its parts', () => {
  assert.equal(keyOf(['Undo: ', ' (key U)']), 'Undo: {0} (key U)');
  assert.equal(keyOf(['', ' of ', '']), '{0} of {1}');
  assert.equal(keyOf(['a\n      b', ' c\n d']), 'a b{0} c d');
  assert.deepEqual(keysIn('a.js', 'say`A`;\nf(say`B ${g(say`C`)} d`); tell`E`; `F`'),
                   [{ key: 'A', line: 1 }, { key: 'B {0} d', line: 2 }, { key: 'C', line: 2 }]);
});

test('one thing has a text of its own', () => {
  const text = count => plural(count, 'one', 'other');
  assert.deepEqual([0, 1, 2, 21].map(text), ['other', 'one', 'other', 'other']);
});

test('the sentence of each error is translated', () => {
  const found = text => plainErrorsIn('a.js', text).length;
  for (const plain of ["'A'", '`A ${b}`', "b ? say`A` : 'B'", "say`A` + ' B'", "(b ?? 'A')"]) {
    assert.equal(found(`throw new Error(${plain});`), 1, plain);
  }
  for (const good of ['say`A ${b}`', 'b.error ?? say`A`', 'b ? say`A` : say`B`', 'b']) {
    assert.equal(found(`throw new Error(${good});`), 0, good);
  }
  assert.deepEqual(plainErrors(), []);
});

test('index.html has texts', () => {
  const keys = keysOfIndex();
  for (const key of ['Connection lost', 'Panels']) assert.ok(keys.includes(key), `${keys}`);
});

test('the page has the texts of all tissues that the machine knows', () => {
  const table = readFileSync(path.join(pageFolder, '../../commands/text/tissues.cpp'), 'utf8');
  const rows = [...table.matchAll(/\{"(\w+)", [-\d.]+, \{[^}]*\}, "([^"]+)"\}/g)];
  assert.equal(rows.length, Number(/std::array<Tissue, (\d+)>/.exec(table)[1]));
  const keys = keysByRoom().get('surfaces');
  for (const text of rows.flatMap(([, name, help]) => [name, help])) {
    assert.ok(keys.has(text), `surfaces/surfaces.js does not say '${text}'`);
  }
});

test('each language has a file for each room, with the room\'s texts and no others', async () => {
  const wrong = [];
  const rooms = keysByRoom();
  assert.ok(rooms.get('shell').size > 50, `${rooms.get('shell').size} texts`);
  for (const code of Object.keys(LANGUAGES).filter(each => each !== 'en')) {
    const folder = path.join(pageFolder, 'texts', code);
    const files = readdirSync(folder).map(name => path.parse(name).name).sort();
    assert.deepEqual(files, [...rooms.keys()].sort(), `files of ${folder}`);
    const all = (await CATALOGS[code]()).default;
    for (const [room, keys] of rooms) {
      const file = `texts/${code}/${room}.js`;
      const { default: texts } = await import(path.join(folder, `${room}.js`));
      for (const [key, place] of keys) {
        const text = texts[key];
        if (text === undefined) wrong.push(`${place}: ${file} has no '${key}'`);
        else if (partsOf(text) !== partsOf(key)) wrong.push(`${file}: other parts: '${key}'`);
        else if (text !== text.trim() || text === '') wrong.push(`${file}: '${key}': '${text}'`);
        else if (all[key] !== text) wrong.push(`${file}: another room has another '${key}'`);
        if (key !== key.trim()) wrong.push(`${place}: spaces at the ends of '${key}'`);
      }
      for (const key of Object.keys(texts)) {
        if (!keys.has(key)) wrong.push(`${file}: no module says '${key}'`);
      }
    }
  }
  assert.deepEqual(wrong, []);
});
