// Lengths, angles, regions and their files: the modules that need no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {sliceOf, valuesIn} from '../../../host/serve/page/slices/slice_pixels.js';
import {checked} from '../../../host/serve/page/panel/measure_check.js';
import {csvOf, jsonOf} from '../../../host/serve/page/panel/measure_files.js';
import {partText, valuesText} from '../../../host/serve/page/panel/measure_words.js';
import {angleOf, lengthOf, valuesOf} from '../../../host/serve/page/panel/measure_math.js';
import {MOST_MEASURES, Measures, Points, measureText}
  from '../../../host/serve/page/panel/measures.js';

/** @param {number} a @param {number} b */
const near = (a, b) =>
  assert.ok(Math.abs(a - b) < 1e-9 * Math.max(1, Math.abs(b)), `${a}, not ${b}`);

test('the length of a path is the sum of its lines', () => {
  assert.equal(lengthOf([[0, 0, 0], [3, 4, 0], [3, 4, 12]]), 17);
  assert.equal(lengthOf([[1, 2, 3]]), 0);
});

test('angles are exact, also the small and the straight ones', () => {
  near(angleOf([[1, 0, 0], [0, 0, 0], [0, 5, 0]]), 90);
  near(angleOf([[1, 0, 0], [0, 0, 0], [-2, 0, 0]]), 180);
  near(angleOf([[1, 0, 0], [0, 0, 0], [1, 1e-7, 0]]), 1e-7 * 180 / Math.PI);
  near(angleOf([[10, 0, 1], [10, 0, 0], [11, 0, 1]]), 45);
  assert.throws(() => angleOf([[1, 2, 3], [1, 2, 3], [0, 0, 0]]), /same/);
});

test('values have the deviation of a sample', () => {
  assert.deepEqual(valuesOf([2, 4, 4, 4, 5, 5, 7, 9]),
    {voxels: 8, mean: 5, deviation: Math.sqrt(32 / 7), least: 2, most: 9});
  assert.equal(valuesOf([3]).deviation, null);
  assert.throws(() => valuesOf([]), /no voxel/);
});

/** A slice of 6 x 5 pixels of 2 x 3 mm with values 0 to 29. */
function slice(more = {}) {
  const bytes = new ArrayBuffer(64);
  new Int16Array(bytes).set(Array.from({length: 30}, (_, k) => k));
  return sliceOf({axis: 'z', index: 1}, {json: {type: 'int16', width: 6, height: 5,
    spacing_mm: [2, 3], letters: {}, axes: [0, 1, 2], flips: [false, false], contours: [],
    ...more}, bytes});
}

test('a rectangle has the pixels whose middles are inside, and its own area', () => {
  const {values, area_mm2} = valuesIn(slice(), 'rectangle', [3.4, 0.6], [0.6, 2.4]);
  assert.deepEqual(values, [7, 8, 9, 13, 14, 15]);
  near(area_mm2, 2.8 * 2 * 1.8 * 3);
});

test('an ellipse leaves out the corners of its box', () => {
  const {values, area_mm2} = valuesIn(slice(), 'ellipse', [0, 0], [4, 4]);
  assert.deepEqual(values, [2, 7, 8, 9, 12, 13, 14, 15, 16, 19, 20, 21, 26]);
  near(area_mm2, Math.PI * 4 * 6);
});

test('uneven rows and sheared slices have their true area', () => {
  const uneven = valuesIn(slice({places_mm: [null, [0, 3, 12, 15, 18]]}), 'rectangle', [0, 0],
    [5, 2]);
  near(uneven.area_mm2, 10 * 12);
  assert.equal(uneven.values.length, 18);
  near(valuesIn(slice({skew_deg: 60}), 'rectangle', [0, 0], [1, 1]).area_mm2, 3);
});

test('a region without the middle of a voxel has no values', () => {
  assert.deepEqual(valuesIn(slice(), 'rectangle', [0.1, 0.1], [0.4, 0.4]).values, []);
  assert.deepEqual(valuesIn(slice(), 'ellipse', [1, 1], [1, 1]).values, []);
});

const REGION = /** @type {any} */ ({kind: 'ellipse', points_mm: [[0, 0, 5], [10, 20, 5]],
  value: 157.08, slice: {axis: 'z', index: 4},
  values: {voxels: 1234, mean: 41.23456, deviation: 8, least: -12, most: 60}});

const PART = /** @type {any} */ ({kind: 'part', points_mm: [[4, 5, 6]], value: 42.5,
  part: {surface: 'bone', isovalue: 250.5, cavity: true, closed: false, area_mm2: 12345}});

test('the last point makes the measurement; a path ends when the user says so', () => {
  const angle = new Points('angle');
  assert.equal(angle.take([1, 0, 0]), null);
  assert.equal(angle.sentence, 'Click the second point.');
  assert.equal(angle.take([0, 0, 0]), null);
  assert.equal(angle.sentence, 'Click the third point.');
  assert.equal(angle.take([0, 1, 0])?.value, 90);
  assert.equal(angle.sentence, '');
  angle.take([1, 0, 0]);
  assert.equal(angle.end(), null, 'an angle that is not whole is forgotten');
  assert.deepEqual(angle.list, []);
  const path = new Points('path');
  assert.equal(path.take([0, 0, 0]), null);
  assert.equal(path.end(), null);
  path.take([0, 0, 0]);
  path.take([0, 3, 4]);
  assert.equal(path.sentence, '5.0 mm so far.');
  assert.deepEqual(path.end(), {kind: 'path', points_mm: [[0, 0, 0], [0, 3, 4]], value: 5});
  assert.deepEqual(path.list, []);
});

test('measurements are told in words', () => {
  assert.equal(measureText({kind: 'distance', value: 12.345}), '12.3 mm');
  assert.equal(measureText({kind: 'path', value: 123.45}), '123 mm');
  assert.equal(measureText({kind: 'angle', value: 123.45}), '123.5°');
  assert.equal(measureText(REGION), '157 mm²');
  assert.equal(valuesText(REGION.values, 'HU'),
    'mean 41.23, deviation 8, -12 to 60 HU, 1,234 voxels');
  assert.equal(measureText(PART), '42.5 ml');
  assert.equal(partText(PART.part, 'HU'),
    'cavity in bone at 250.5 HU, 123.5 cm², closed by the faces of the scan');
  assert.match(partText({...PART.part, area_mm2: 2.345}, ''), /, 0\.023 cm²/);
  assert.equal(partText({...PART.part, cavity: false, closed: true}, ''),
    'bone at 250.5, 123.5 cm²');
  assert.equal(measureText({kind: 'rectangle', value: 0.0432}), '0.043 mm²');
  // Least and most are values that voxels have.
  assert.equal(valuesText(valuesOf([12345, 30001, 32767]), ''),
    'mean 25,040, deviation 11,080, 12,345 to 32,767, 3 voxels');
  assert.equal(valuesText(valuesOf([7]), 'HU'), 'mean 7, 7 to 7 HU, 1 voxel');
});

test('files have every number in full', () => {
  const measures = new Measures();
  measures.add({kind: 'distance', points_mm: [[0, 0, 0], [0, 0, 12.5]], value: 12.5});
  measures.add(REGION);
  measures.add({...REGION, slice: {axis: 'z', index: 4, slab_mm: 7.5, slab_kind: 'max'}});
  measures.add({kind: 'note', points_mm: [[1, 2, 3]], value: 0, text: 'a "cyst", old'});
  measures.add(PART);
  const csv = csvOf(measures.list, {name: 'a, "b"', unit: 'HU'});
  const [head, first, second, third, note, part, end] = csv.split('\r\n');
  assert.equal(head.split(',').length, 23);
  const name = '"a, ""b"""';
  assert.equal(first, `${name},1,distance,12.5,mm,0 0 0; 0 0 12.5,,,,,,,,,,,,,,,,,`);
  assert.equal(second,
    `${name},2,ellipse,157.08,mm2,0 0 5; 10 20 5,z,4,1234,41.23456,8,-12,60,HU,,,,,,,,,`);
  assert.ok(third.endsWith('-12,60,HU,7.5,max,,,,,,,'), third);
  assert.equal(note, `${name},4,note,,,1 2 3,,,,,,,,,,,"a ""cyst"", old",,,,,,`);
  assert.equal(part, `${name},5,part,42.5,ml,4 5 6,,,,,,,,,,,,bone,250.5,yes,no,12345,`);
  assert.equal(end, '');
  const json = JSON.parse(jsonOf(measures.list, {name: 'a "scan"', unit: 'HU'}));
  assert.equal(json.volume, 'a "scan"');
  assert.deepEqual(json.measurements.slice(0, 3).map(each => each.unit), ['mm', 'mm2', 'mm2']);
  assert.deepEqual(json.measurements[3],
    {name: '4', kind: 'note', points_mm: [[1, 2, 3]], text: 'a "cyst", old'});
  assert.deepEqual(json.measurements[4], {name: '5', ...PART, unit: 'ml'});
  assert.deepEqual(json.measurements[1].values, REGION.values);
  assert.equal(json.measurements[1].voxel_index, 4);
  assert.ok(!('slab_mm' in json.measurements[1]));
  assert.deepEqual([json.measurements[2].slab_mm, json.measurements[2].slab_kind], [7.5, 'max']);
});

test('a measurement belongs to the volume of a time series that it was made in', () => {
  const measures = new Measures();
  const volume = (frame, frames = 3) => /** @type {any} */ ({frame, frames});
  const distance = /** @type {any} */ ({kind: 'distance', points_mm: [[0, 0, 0], [0, 0, 2]],
    value: 2});
  measures.show(volume(1, 1));
  measures.add(distance);
  assert.ok(!('frame' in measures.list[0]), 'a single volume has no number');
  measures.show(volume(2));
  measures.add(distance);
  assert.equal(measures.list[1].frame, 2);
  assert.deepEqual(measures.seen.map(({name}) => name), ['1', '2']);
  measures.show(volume(3));
  assert.deepEqual(measures.seen.map(({name}) => name), ['1']);
  const [, , second] = csvOf(measures.list, {name: 'a', unit: ''}).split('\r\n');
  assert.ok(second.endsWith(',2'), second);
  assert.equal(JSON.parse(jsonOf(measures.list, {name: 'a', unit: ''})).measurements[1].frame, 2);
  const {list, errors} = checked(JSON.parse(JSON.stringify(measures.list)));
  assert.deepEqual([list, errors], [measures.list, []]);
  const wrong = checked([{...measures.list[1], frame: 0}]).errors;
  assert.match(wrong[0], /frame is 0, but the number of a volume, from 1 is needed/);
  measures.show(null);
  assert.deepEqual(measures.seen.map(({name}) => name), ['1']);
});

test('sessions are restored, also those that had distances alone', () => {
  const measures = new Measures();
  const old = checked([{name: '3', a_mm: [0, 0, 0], b_mm: [0, 3, 4], distance_mm: 5}]);
  assert.deepEqual(old.errors, []);
  measures.restore(old.list);
  assert.deepEqual(measures.list, [{name: '3', kind: 'distance', points_mm: [[0, 0, 0], [0, 3, 4]],
    value: 5}]);
  measures.add(REGION);
  assert.equal(measures.list[1].name, '4');
  const again = new Measures();
  measures.add({kind: 'note', points_mm: [[1, 2, 3]], value: 0, text: 'old'});
  measures.add(PART);
  const saved = checked(JSON.parse(JSON.stringify(measures.list)));
  assert.deepEqual(saved.errors, []);
  again.restore(saved.list);
  assert.deepEqual(again.list, measures.list);
});

test('more measurements than the limit are refused, and none is lost', () => {
  const measures = new Measures();
  for (let k = 0; k < MOST_MEASURES; ++k) {
    assert.equal(measures.add(REGION), '');
  }
  assert.match(measures.add(REGION), /100 measurements.*Delete/);
  assert.equal(measures.list[0].name, '1');
});

test('a wrong measurement of a session is named with its field, and the others are kept', () => {
  const right = {name: '1', kind: 'distance', points_mm: [[0, 0, 0], [0, 3, 4]], value: 5};
  for (const [wrong, says] of /** @type {[any, RegExp][]} */ ([
    [{name: ''}, /number 2 was left out: name is ""/],
    [{name: '1'}, /Measurement 1 .*name is "1"/],
    [{kind: 'volume'}, /Measurement 2 .*kind is "volume", but one of distance, angle/],
    [{points_mm: [[0, 0, 0]]}, /points_mm is \[\[0,0,0\]\], but a list of 2 points with 3 numbers/],
    [{points_mm: [[0, 0, 0], [0, '3', 4]]}, /points_mm/],
    [{points_mm: {length: 2}}, /points_mm is \{"length":2\}/],
    [{value: '5'}, /value is "5", but a number/],
    [{value: null}, /value is null/],
    [{kind: 'note', points_mm: [[1, 2, 3]]}, /text is missing, but a text with at most 200/],
    [{...PART, part: {...PART.part, surface: ''}}, /part\.surface is "", but the name of a/],
    [{...PART, part: {...PART.part, closed: 1}}, /part\.closed is 1, but true or false is needed/],
    [{...PART, part: {...PART.part, area_mm2: -1}}, /area_mm2 is -1, but a number of 0 or more/],
    [{...PART, part: undefined}, /part\.surface is missing/],
    [{...REGION, slice: {axis: 'w', index: 4}}, /slice is \{"axis":"w","index":4\}/],
    [{...REGION, slice: {axis: 'z', index: 4.5}}, /slice/],
    [{...REGION, values: {...REGION.values, mean: 'x'}}, /values\.mean is "x", but a number/],
    [{slice: {axis: 'z', index: 4}}, /slice is .*but none for this kind/],
  ])) {
    const {list, errors} = checked([right, {...right, name: '2', ...wrong}, {...right, name: '3'}]);
    assert.deepEqual(list.map(({name}) => name), ['1', '3'], String(says));
    assert.equal(errors.length, 1);
    assert.match(errors[0], says);
  }
  assert.match(checked([right, 7]).errors[0], /number 2 was left out: it is 7, but an object/);
  assert.match(checked('none').errors[0], /measurements is "none", but a list/);
  const many = Array.from({length: MOST_MEASURES + 1}, (_, k) => ({...right, name: String(k)}));
  assert.equal(checked(many).list.length, MOST_MEASURES);
  assert.match(checked(many).errors[0], /101 measurements, but at most 100/);
});
