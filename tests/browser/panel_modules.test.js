// The panels' modules that need no browser: places of voxels, slices, the ring's flows.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import test from 'node:test';

import {factsOf} from '../../host/serve/page/machine/model_view.js';
import {belongTo} from '../../host/serve/page/machine/region_map.js';
import {STAGES} from '../../host/serve/page/machine/stage_bars.js';
import {dotsOf, flowsOf, stretchesOf, sumsOf} from '../../host/serve/page/machine/ring_flow.js';
import {nearestVoxel, patientText, toPatient, toVoxel}
  from '../../host/serve/page/slices/patient_grid.js';
import {boxAt, pixelAt, placedIn, sliceAtBox, sliceOf, voxelAt}
  from '../../host/serve/page/slices/slice_pixels.js';
import {planesOf} from '../../host/serve/page/slices/slice_planes.js';
import {changesOf} from '../../host/serve/page/inspect/why_cards.js';
import {outline, roundValues, Scale} from '../../host/serve/page/surfaces/axis.js';

/** @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
function near(a, b, tolerance = 1e-9) {
  assert.equal(a.length, b.length);
  Array.from(a).forEach((value, k) =>
    assert.ok(Math.abs(value - b[k]) <= tolerance, `${Array.from(a)} is not ${Array.from(b)}`));
}

/** A sheared, turned grid, its slices at 0, 1, 4 and 5 (in units of its z axis). */
const GRID = {
  voxel_to_patient: [0, 2, 0, 0, -3, 0, 0.5, 0, 0, 0.25, 4, 0, 10, -20, 30, 1],
  slice_places: [0, 1, 4, 5], size: /** @type {[number, number, number]} */ ([6, 5, 4]),
};

test('a voxel lies where the affine map takes it, its slice at its own place', () => {
  near(toPatient(GRID, [1, 2, 2]), [10 - 6, -20 + 2 + 1, 30 + 1 + 16]);
});

test('to the patient and back is the same voxel, between uneven slices, too', () => {
  for (const z of [0, 0.5, 1, 1.75, 2, 3]) {
    near(toVoxel(GRID, toPatient(GRID, [1.5, 3.25, z])), [1.5, 3.25, z]);
  }
});

test('the nearest voxel is one that is there', () => {
  assert.deepEqual(nearestVoxel(GRID, [-3, 4.6, 1.4]), [0, 4, 1]);
});

test('places are told as radiologists do: LPS', () => {
  assert.equal(patientText([-12.34, 5, -0.06]), 'R 12.3  P 5.0  I 0.1 mm');
});

test('planes of an axial scan, and of one whose slices are sagittal', () => {
  const axial = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1];
  assert.deepEqual(planesOf(axial).map(({plane, axis}) => plane + axis),
    ['Axialz', 'Coronaly', 'Sagittalx']);
  // x runs to posterior, y to inferior, z to the left.
  const sagittal = [0, 1, 0, 0, 0, 0, -1, 0, 3, 0, 0, 0, 0, 0, 0, 1];
  assert.deepEqual(planesOf(sagittal).map(({plane, axis}) => plane + axis),
    ['Axialy', 'Coronalx', 'Sagittalz']);
});

test('planes of an oblique scan use each axis once', () => {
  const c = Math.cos(0.8), n = Math.sin(0.8);
  const oblique = [1, 0, 0, 0, 0, c, n, 0, 0, -n, c, 0, 0, 0, 0, 1];
  assert.equal(new Set(planesOf(oblique).map(({axis}) => axis)).size, 3);
});

/** A slice across y of GRID: x to the right, z downwards and flipped, as the server tells it. */
function answer() {
  const values = new Int16Array(6 * 4).map((_, n) => n - 5);
  const segments = new Float32Array([0, 0, 1, 1, 2, 0.5, 3, 2]);
  const bytes = new ArrayBuffer(48 + 32);
  new Int16Array(bytes).set(values);
  new Float32Array(bytes, 48).set(segments);
  const json = {width: 6, height: 4, type: 'int16', spacing_mm: [2, 8],
    places_mm: [null, [0, 4, 16, 20]], letters: {left: 'A', right: 'P', top: 'S', bottom: 'I'},
    axes: [0, 2, 1], flips: [false, true],
    contours: [{surface: 'a', color: '#fff', first: 0, count: 1},
      {surface: 'b', color: '#000', first: 1, count: 1}]};
  return {json, bytes};
}

test('an answer\'s values and segments are what was sent', () => {
  const slice = sliceOf({axis: 'y', index: 3}, answer());
  assert.equal(slice.values[7], 2);
  assert.deepEqual([...slice.segments.subarray(4, 8)], [2, 0.5, 3, 2]);
});

test('an answer with too few bytes is refused with both counts', () => {
  const {json, bytes} = answer();
  assert.throws(() => sliceOf({axis: 'y', index: 3}, {json, bytes: bytes.slice(0, 79)}),
    /79 bytes came, its description needs 80/);
});

test('a pixel of a slice is a voxel, and back', () => {
  const slice = sliceOf({axis: 'y', index: 3}, answer());
  assert.deepEqual(voxelAt(slice, GRID.size, 2, 0), [2, 3, 3]);
  assert.deepEqual(pixelAt(slice, GRID.size, [2, 3, 3]), [2, 0]);
});

test('unevenly spaced rows keep their positions, with equal scales across and down', () => {
  const slice = sliceOf({axis: 'y', index: 3}, answer());
  const placed = placedIn(slice, 1000, 240);
  // 24 mm down: from 2 mm above the first row's middle to 2 below the last one's.
  assert.equal(placed.scale, 10);
  near([placed.left, placed.top, placed.width, placed.height], [440, 0, 120, 240]);
  near(boxAt(slice, placed, 0, 0), [450, 20]);
  near(boxAt(slice, placed, 5, 2), [550, 20 + 160]);
  near(sliceAtBox(slice, placed, ...boxAt(slice, placed, 3.25, 1.5)), [3.25, 1.5]);
});

test('the page has words for each stage that nodes report', () => {
  const files = ['ringbus/stage_clock.hpp', 'gp_firmware/node/stages.hpp',
    'renderer_firmware/node.hpp', 'host/frame_buffer/node.hpp'];
  const stages = files.flatMap(file => {
    const text = readFileSync(new URL(`../../${file}`, import.meta.url), 'utf8');
    const [, list] = text.match(/namespace (?:\w+::)*stage \{(.*?)\n\}/s) ?? [];
    assert.ok(list, file);
    return [...list.matchAll(/string_view \w+ = "(\w+)"/g)].map(([, name]) => name);
  });
  assert.deepEqual(stages.toSorted(), [...STAGES.keys()].toSorted());
});

/** @param {string} name @param {any[]} sent */
const node = (name, ...sent) => ({name, role: '', busy: 0, stages: [], memory_bytes: 0, queue: 0,
  sent: sent.map(([to, channel, messages]) => ({to, kind: 'k', channel, messages, bytes: 1}))});

test('messages pass every stretch from their sender to their destination, around the end, too',
  () => {
    const nodes = [node('a', ['c', 1, 3]), node('b'), node('c', ['b', 0, 2])];
    const flows = flowsOf(nodes);
    assert.deepEqual(flows.map(({from, hops}) => [from, hops]), [[0, 2], [2, 2]]);
    assert.deepEqual(stretchesOf(flows, 3, 2), [[2, 0, 2], [3, 3, 0]]);
  });

test('a message to a node that is not there is left out', () => {
  assert.deepEqual(flowsOf([node('a', ['gone', 0, 5])]), []);
});

test('dots are in proportion and at most as many as allowed', () => {
  const flows = flowsOf([node('a', ['b', 0, 300]), node('b', ['a', 1, 100])]);
  const {each, dots} = dotsOf(flows, 48);
  assert.equal(each, 10);
  assert.equal(dots.length, 40);
  assert.equal(dots.filter(({channel}) => channel === 0).length, 30);
});

test('many flows of one message each have dots, too', () => {
  const many = Array.from({length: 100}, (_, n) => node(`n${n}`, [`n${(n + 1) % 100}`, 0, 1]));
  const {each, dots} = dotsOf(flowsOf(many), 48);
  assert.equal(each, 5);
  assert.equal(dots.length, 20);
});

test('what a node sent on several channels is one sum for each destination and kind', () => {
  const rows = [['a', 'x', 3, 1, 10], ['b', 'x', 0, 2, 90], ['a', 'x', 0, 4, 20],
    ['a', 'y', 0, 1, 1]];
  const sent = rows.map(([to, kind, channel, messages, bytes]) => /** @type {any} */ (
    {to, kind, channel, messages, bytes}));
  assert.deepEqual(sumsOf(sent).map(each => Object.values(each)),
    [['b', 'x', [0], 2, 90], ['a', 'x', [0, 3], 5, 30], ['a', 'y', [0], 1, 1]]);
});

test('regions belong to a picture of as many columns and rows', () => {
  const regions = {columns: 5, rows: 4, renderer: [], cycles: []};
  assert.ok(belongTo(regions, {width: 640, height: 512}));
  assert.ok(belongTo(regions, {width: 513, height: 385}));
  assert.ok(!belongTo(regions, {width: 641, height: 512}));
  assert.ok(!belongTo(regions, {width: 640, height: 384}));
});

test('a pixel\'s changes are all its stores, in order', () => {
  const at = (/** @type {number[]} */ ...all) => all.map(each => ({at: each}));
  const why = /** @type {any} */ ({prologue: at(0, 2), visits: [{writes: at(70, 74)}, {writes: []},
    {writes: at(40)}], doors: [], end_of_region: at(90)});
  assert.deepEqual(changesOf(why), [0, 2, 40, 70, 74, 90]);
});

test('modelled times are told in three digits, with what limits them', () => {
  const use = [{unit: 'host link', mean: 0.9, busiest: 0.9, index: 0},
    {unit: 'GP', mean: 0.5, busiest: 0.754, index: 3}];
  const surface = {name: 'bone', triangles: 12345, ms: 1234.5, limit: 'GP', use};
  const frame = {primitives: 1, samples: 1, frames_per_s: 24.0961, latency_ms: 41.54, limit: 'GP',
    use};
  const whole = {machine: 'paper-1993', gps: 36, renderers: 16, frame_buffers: 1,
    load: {ms: 999.9, limit: 'host link', use}, surfaces: [surface], frame};
  assert.deepEqual(factsOf(whole), [
    ['Machine', 'paper-1993\n36 GPs, 16 Renderers\n1 frame buffer'],
    ['Load time', '1 s\nLimit: host link, 90 % busy'],
    ['Surface bone', 'extracted in 1.23 s\n12,345 triangles\nLimit: GPs, 75 % busy'],
    ['Frames', '24.1 frames/s\nlatency 41.5 ms\n' +
      '1 primitive\n1 sample per pixel\nLimit: GPs, 75 % busy']]);
  const idle = {...surface, limit: 'waiting'};
  assert.match(factsOf({...whole, surfaces: [idle]})[2][1], /Limit: waiting, host link 90 % busy/);
  const smooth = {...whole, load: undefined, surfaces: [], frame: {...frame, samples: 16}};
  assert.equal(factsOf(smooth).length, 2);
  assert.match(factsOf(smooth)[1][1], /\n16 samples per pixel\n/);
});

test('an axis has round values, about as many as wished', () => {
  for (const [low, high, count, values, digits] of [
    [-1024, 3071, 5, [-1000, 0, 1000, 2000, 3000], 0],
    [0, 1, 4, [0, 0.2, 0.4, 0.6, 0.8, 1], 1],
    [-0.37, 0.37, 3, [-0.2, 0, 0.2], 1],
    [0, 0.0005, 5, [0, 0.0001, 0.0002, 0.0003, 0.0004, 0.0005], 4],
    [0, 95, 10, [0, 10, 20, 30, 40, 50, 60, 70, 80, 90], 0],
    [32, 33, 3, [32, 32.5, 33], 1],
    [0, 65535, 8, [0, 10000, 20000, 30000, 40000, 50000, 60000], 0],
  ]) {
    assert.deepEqual(roundValues(low, high, count), {values, digits}, `${low} to ${high}`);
  }
  // Every step is 1, 2 or 5 times a power of ten, and all multiples in the range are there.
  for (let k = 1; k < 400; ++k) {
    const low = -(k ** 2) * 0.37, high = k ** 3 * 0.011 + 0.5;
    const {values} = roundValues(low, high, 6);
    const step = values[1] - values[0], mantissa = step / 10 ** Math.floor(Math.log10(step) + 1e-6);
    assert.ok([1, 2, 5].some(each => Math.abs(each - mantissa) < 1e-6), `${step}`);
    assert.ok(values.length >= 3 && values.length <= 10, `${values}`);
    assert.ok(values[0] >= low && values[0] - step < low, `${values[0]} after ${low}`);
    assert.ok(values.at(-1) <= high && values.at(-1) + step > high, `${values.at(-1)}, ${high}`);
  }
});

test('a scale leads from values to pixels and back, also beyond its ends', () => {
  const scale = new Scale(-100, 300, 20, 420);
  assert.deepEqual([-100, 0, 300, 500].map(value => scale.at(value)), [20, 120, 420, 620]);
  assert.deepEqual([20, 120, 420, 0].map(x => scale.valueAt(x)), [-100, 0, 300, -120]);
  assert.equal(outline([3, 1], 10, k => 5 * k), 'M0 10V3H5V1H10V10Z');
});
