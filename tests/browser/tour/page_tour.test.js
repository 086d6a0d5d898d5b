// Parts of the tour that need no browser: addresses, the arithmetic of a pixel processor, the
// choice of a pixel; and the one way to write numbers.
import assert from 'node:assert/strict';
import test from 'node:test';

import {duration, grouped, percent, rewritten, short, significant}
  from '../../../host/serve/page/elements/numbers.js';
import {hashOf, stepOf} from '../../../host/serve/page/tour/address.js';
import {candidates} from '../../../host/serve/page/tour/find_pixel.js';
import {STEPS} from '../../../host/serve/page/tour/texts.js';
import {depthOf} from '../../../host/serve/page/tour/tree.js';

test('numbers have commas, a point, and no minus before zero', () => {
  assert.equal(grouped(48884), '48,884');
  assert.equal(grouped(-1234567), '-1,234,567');
  assert.equal(grouped(1213.25, 1), '1,213.3');
  assert.equal(grouped(5, 2), '5.00');
  assert.equal(grouped(-0.2), '0');
  assert.equal(grouped(9007199254740993n), '9,007,199,254,740,993');
  assert.equal(short(250.5, 3), '250.5');
  assert.equal(short(-1000, 3), '-1,000');
  assert.equal(short(0.12345), '0.12');
  assert.equal(short(-0.001), '0');
  assert.equal(significant(0.0123456, 3), '0.0123');
  assert.equal(significant(1234567, 3), '1,230,000');
});

test('units stand after a space', () => {
  assert.equal(duration(0.4249), '0.425 ms');
  assert.equal(duration(999.4), '999 ms');
  assert.equal(duration(999.9), '1 s');
  assert.equal(duration(4_321_000), '4,320 s');
  assert.equal(percent(0.946), '95 %');
});

test('texts of the command line are rewritten, and words with digits are not', () => {
  assert.equal(rewritten('42900 triangles, area 215736.1 mm2'),
               '42,900 triangles, area 215,736.1 mm²');
  assert.equal(rewritten('-12345 to 1234567; 12 cm3'), '-12,345 to 1,234,567; 12 cm³');
  for (const same of ['gp-1234', '/tmp/uploads/4711/a.nrrd', '0.12345', '1,234', 'lorensen1987',
    '12 m 2 s', '20261126T080000Z-4711']) {
    assert.equal(rewritten(same), same);
  }
});

test('the tour names the units of the model as the panel does', () => {
  const use = {unit: 'ring', mean: 0.25, busiest: 0.5, index: 3};
  const frame = {primitives: 1, samples: 1, frames_per_s: 24, latency_ms: 41, limit: 'ring',
    use: [use]};
  const modelled = {machine: 'paper', gps: 2, renderers: 2, frame_buffers: 1, surfaces: [], frame};
  const facts = /** @type {any} */ ({modelled, frame: null, watches: false});
  const text = STEPS[5].text(facts).join(' ');
  assert.match(text, /The limit is the unit “ring channels”: 50 % busy\./);
});

test('the address of a step names it again', () => {
  assert.deepEqual(stepOf('#tour=3'), {step: 3, pixel: null});
  const pixel = {x: 256, y: 0};
  assert.deepEqual(stepOf(hashOf(6, pixel)), {step: 6, pixel});
  assert.deepEqual(stepOf(hashOf(1, null)), {step: 1, pixel: null});
  for (const other of ['', '#', '#tour', '#tour=0', '#tour=7', '#tour=1.5', '#tour=x', '#step=3']) {
    assert.equal(stepOf(other), null, other);
  }
  for (const wrong of ['1', '1,2,3', '-1,2', 'a,b', '1234567,1']) {
    assert.equal(stepOf(`#tour=2&pixel=${wrong}`)?.pixel, null, wrong);
  }
});

/** A visit whose second instruction writes the depth `z`. */
function visitWith(instruction, z) {
  const state = {enabled: true, surface_field: 0, z: 5, normal: [0, 0, 0], rgb: 0};
  return {writes: [{at: 7, instruction: 'CLEARMEM m64:24', before: state, after: state},
    {at: 9, instruction, before: state, after: {...state, z}}]};
}

test('a pixel processor computes A x + B y + C, without the lowest bits', () => {
  // 3 * 10 - 5 * 20 + 4166 = 4096; without 8 bits 16.
  const found = depthOf(visitWith('TREEintoMEM m8:24 >>8  3 -5 4166', 16), {x: 10, y: 20});
  assert.deepEqual(found, {at: 9, instruction: 'TREEintoMEM m8:24 >>8  3 -5 4166',
    terms: [3n, -5n, 4166n], sum: 4096n, bits: 24, shift: 8, z: 16});
  // A negative value keeps its lowest 24 bits: -1 becomes all ones.
  assert.equal(depthOf(visitWith('TREEintoMEM m8:24  0 0 -1', 2 ** 24 - 1), {x: 1, y: 1})?.z,
               16777215);
});

test('a depth that the machine computed in another way is not explained', () => {
  assert.equal(depthOf(visitWith('TREEintoMEM m8:24 >>8  3 -5 4166', 17), {x: 10, y: 20}), null);
  assert.equal(depthOf(visitWith('CONSTintoMEM m8:24  16', 16), {x: 10, y: 20}), null);
  assert.equal(depthOf({writes: []}, {x: 0, y: 0}), null);
});

test('candidates for the pixel are places without the background, the middle first', () => {
  const [width, height] = [48, 48], data = new Uint8ClampedArray(4 * width * height);
  for (const [x, y] of [[2, 40], [26, 22]]) data.set([200, 180, 160, 255], 4 * (y * width + x));
  data.set([20, 20, 20, 255], 4 * (24 * width + 24));  // Nearly the background.
  const found = candidates({ width, height, data }, [0, 0, 0]).map(({ x, y }) => [x, y]);
  assert.deepEqual(found, [[26, 22], [2, 40]]);
});
