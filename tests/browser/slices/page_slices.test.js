// Windows, colors and zoom of the slices: the modules that need no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {placedIn} from '../../../host/serve/page/slices/slice_pixels.js';
import {WHOLE, movedTo, revealed, zoomedAt}
  from '../../../host/serve/page/slices/slice_zoom.js';
import {allValues, firstWindow, isHounsfield, mostValues, ownWindows, paintValues}
  from '../../../host/serve/page/slices/windows.js';

test('a window is black up to its lower end, white from its upper end on, even between', () => {
  const rgba = new Uint8ClampedArray(20);
  paintValues([-1000, -100, -36, 155, 900], {window: 255, level: 27.5}, rgba);
  assert.deepEqual([0, 4, 8, 12, 16].map(at => rgba[at]), [0, 0, 64, 255, 255]);
  assert.deepEqual([...rgba.slice(8, 12)], [64, 64, 64, 255]);
});

test('color maps begin and end with their colors, and pass through those between', () => {
  /** @param {import('../../../host/serve/page/slices/windows.js').ColorMap} map */
  const colors = map => {
    const rgba = new Uint8ClampedArray(12);
    paintValues([0, 127.5, 255], {window: 255, level: 127.5}, rgba, map);
    return [0, 4, 8].map(at => [...rgba.slice(at, at + 3)]);
  };
  assert.deepEqual(colors('gray'), [[0, 0, 0], [128, 128, 128], [255, 255, 255]]);
  assert.deepEqual(colors('inverted'), [[255, 255, 255], [127, 127, 127], [0, 0, 0]]);
  assert.deepEqual(colors('hot')[0], [0, 0, 0]);
  assert.deepEqual(colors('hot')[1], [255, 1, 0]);
  assert.deepEqual(colors('hot')[2], [255, 255, 255]);
  assert.deepEqual(colors('viridis')[0], [68, 1, 84]);
  assert.deepEqual(colors('viridis')[2], [253, 231, 37]);
});

test('values of a file that states no modality are taken for CT by air and bone alone', () => {
  assert.ok(isHounsfield({modality: '', minimum: -1000, maximum: 1494}));
  assert.ok(!isHounsfield({modality: '', minimum: 0, maximum: 255}));
  assert.ok(!isHounsfield({modality: 'MR', minimum: -1000, maximum: 1494}));
});

test('the first window of other scans has most values, if the histogram is known', () => {
  const volume = {modality: 'US', minimum: 0, maximum: 255, windows: [], suv_per_value: 0};
  assert.deepEqual(firstWindow(volume, null), {window: 255, level: 127.5});
  assert.deepEqual(firstWindow(volume, null), allValues(volume));
  const counts = {first: 0, width: 1, counts: Array.from({length: 100}, () => 10)};
  assert.deepEqual(firstWindow(volume, counts), {window: 96, level: 50});
  const ct = {modality: 'CT', minimum: -1024, maximum: 3000, windows: [], suv_per_value: 0};
  assert.deepEqual(firstWindow(ct, counts), {window: 400, level: 40});
});

test('a scan begins with its own window, and PET with uptake values from 0 to 10', () => {
  const lung = {name: 'lung', window: 1500, level: -600};
  const second = {name: '', window: 400, level: 40};
  const ct = {modality: 'CT', minimum: -1024, maximum: 3000, windows: [lung, second],
    suv_per_value: 0};
  assert.deepEqual(firstWindow(ct, null), {window: 1500, level: -600});
  assert.deepEqual(ownWindows(ct).map(({name}) => name), ['lung', 'File 2']);
  const pet = {...ct, modality: 'PT', windows: [second], suv_per_value: 0.001};
  assert.deepEqual(firstWindow(pet, null), {window: 10_000, level: 5000});
  assert.deepEqual(ownWindows(pet), [{name: 'SUV 0 to 5', window: 5000, level: 2500},
    {name: 'SUV 0 to 10', window: 10_000, level: 5000}, {name: 'File', window: 400, level: 40}]);
});

test('a window of most values leaves out air around a patient, and single bright voxels', () => {
  const counts = [9000, ...Array.from({length: 98}, () => 10), 1];
  const {window, level} = mostValues({first: -0.5, width: 2, counts});
  assert.ok(Math.abs(level - window / 2 - 5.5) < 0.6, `from ${level - window / 2}`);
  assert.ok(Math.abs(level + window / 2 - 193.5) < 0.6, `to ${level + window / 2}`);
});

test('a window of most values exists for any histogram', () => {
  for (const counts of [[5], [0, 0, 7, 0], [1, 1], [0]]) {
    const {window, level} = mostValues({first: 10, width: 4, counts});
    assert.ok(window > 0 && Number.isFinite(level), JSON.stringify({counts, window, level}));
  }
});

/** A slice of 200 x 100 mm in pixels of 1 mm. */
const SLICE = /** @type {any} */ ({width: 200, height: 100, spacing_mm: [1, 1]});

test('zooming around a place keeps the place where it is', () => {
  const before = placedIn(SLICE, 400, 400);
  assert.deepEqual([before.left, before.top, before.scale], [0, 100, 2]);
  const zoom = zoomedAt(WHOLE, 8, [0.3, 0.6]);
  const now = placedIn(SLICE, 400, 400, zoom);
  assert.equal(now.scale, 16);
  for (const [side, start, length] of /** @type {const} */ ([[0.3, 'left', 'width'],
    [0.6, 'top', 'height']])) {
    assert.ok(Math.abs(now[start] + side * now[length] -
      (before[start] + side * before[length])) < 1e-9, start);
  }
});

test('the middle of the view always shows the slice, and a whole slice does not move', () => {
  assert.deepEqual(movedTo({times: 4, center: [0.5, 0.5]}, [-0.5, 1.5]),
    {times: 4, center: [0, 1]});
  assert.deepEqual(movedTo(WHOLE, [0.2, 0.2]), WHOLE);
  assert.deepEqual(zoomedAt({times: 4, center: [0, 1]}, 1, [0, 0]), WHOLE);
});

test('a place outside of the view is brought into it by the least move', () => {
  assert.equal(revealed(0.5, 0.25, 0.55), 0.5);
  const center = revealed(0.5, 0.25, 0.7);
  assert.ok(center > 0.5 && center < 0.7 && 0.7 - center < 0.125, String(center));
  assert.ok(Math.abs(revealed(0.5, 0.25, 0) - 0.105) < 1e-9);
});
