// The texts of measurements avoid each other and the ends: a module that needs no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {labelsOf, overlap} from '../../../host/serve/page/panel/labels.js';

const BOUNDS = {left: 0, top: 0, width: 400, height: 300};
const widthOf = (/** @type {string} */ text) => 7 * text.length;

/** @param {any[]} drawn  @returns {import('../../../host/serve/page/panel/labels.js').Label[]} */
function labels(drawn, bounds = BOUNDS) {
  return /** @type {any[]} */ (labelsOf(drawn, bounds, 12, widthOf));
}

const line = (/** @type {number} */ y) =>
  ({kind: 'distance', places: [[150, y], [250, y]], text: '1: 12.3 mm'});

test('a text stands above the middle of its line', () => {
  const [{box, lines}] = labels([line(100)]);
  assert.equal(box.left + box.width / 2, 200);
  assert.ok(box.top + box.height <= 100 && box.top + box.height > 90, JSON.stringify(box));
  assert.deepEqual(lines.map(({text, x}) => [text, x]), [['1: 12.3 mm', 200]]);
  assert.ok(lines[0].y > box.top && lines[0].y < box.top + box.height);
});

test('texts of near measurements overlap neither each other nor an end', () => {
  const drawn = [line(100), line(104), line(96),
    {kind: 'angle', places: [[200, 60], [200, 92], [240, 92]], text: '4: 90.0°'},
    {kind: 'note', places: [[200, 88]], text: 'a rather long note about this place'}];
  const found = labels(drawn);
  const ends = drawn.flatMap(({places}) => places);
  found.forEach(({box}, k) => {
    found.slice(k + 1).forEach(other => assert.equal(overlap(box, other.box), 0, `label ${k}`));
    for (const [x, y] of ends) {
      assert.ok(x <= box.left || x >= box.left + box.width || y <= box.top ||
        y >= box.top + box.height, `label ${k} covers the end ${x}, ${y}`);
    }
  });
});

test('a text stays in the picture', () => {
  for (const [x, y] of [[2, 2], [398, 2], [2, 298], [398, 298]]) {
    for (const kind of ['distance', 'note']) {
      const [{box}] = labels([{kind, places: [[x, y]], text: 'some words'}]);
      assert.ok(box.left >= 0 && box.top >= 0 && box.left + box.width <= 400 &&
        box.top + box.height <= 300, JSON.stringify(box));
    }
  }
});

test('a note has lines of few letters, and an arrow from its text to its point', () => {
  const [{box, lines, arrow}] = labels([{kind: 'note', places: [[200, 150]],
    text: 'the fracture begins here, below the joint'}]);
  assert.deepEqual(lines.map(({text}) => text), ['the fracture begins here,', 'below the joint']);
  const [[from, tip], head] = arrow;
  assert.deepEqual(tip, [200, 150]);
  assert.deepEqual(head[1], tip);
  assert.ok(Math.hypot(from[0] - 200, from[1] - 150) > 10, 'the shaft is seen');
  assert.ok(from[0] >= box.left && from[0] <= box.left + box.width);
});

test('what is being made has no text', () => {
  assert.deepEqual(labels([{kind: 'path', places: [[1, 1]], text: ''}]), [null]);
});
