// Filled contours and the cuts of planes: the modules that need no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {cutOf} from '../../../host/serve/page/slices/slice_cuts.js';
import {insideOf} from '../../../host/serve/page/slices/slice_fill.js';

const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]];

/** Contours by marching squares, the inside on the right; inside corners across are parted. */
function contours({width, height, values}, isovalue) {
  const segments = [];
  for (let y = 0; y + 1 < height; ++y) {
    for (let x = 0; x + 1 < width; ++x) {
      const at = CORNERS.map(([dx, dy]) => values[(y + dy) * width + x + dx]);
      const inside = at.map(value => value >= isovalue);
      const crossing = side => {
        const [a, b] = [side % 4, (side + 1) % 4];
        const t = (isovalue - at[a]) / (at[b] - at[a]);
        return [x + CORNERS[a][0] + t * (CORNERS[b][0] - CORNERS[a][0]),
          y + CORNERS[a][1] + t * (CORNERS[b][1] - CORNERS[a][1])];
      };
      for (let entry = 0; entry < 4; ++entry) {
        if (!inside[entry] && inside[(entry + 1) % 4]) {
          let exit = entry + 1;
          while (inside[(exit + 1) % 4]) ++exit;
          segments.push(...crossing(exit), ...crossing(entry));
        }
      }
    }
  }
  return new Float32Array(segments);
}

/** Whether a place is inside of closed lines, by the even-odd rule. */
function isInside(lines, x, y) {
  let crossed = 0;
  for (const line of lines) {
    for (let i = 0, j = line.length - 2; i < line.length; j = i, i += 2) {
      const [x0, y0, x1, y1] = [line[j], line[j + 1], line[i], line[i + 1]];
      if (y0 > y !== y1 > y && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0)) ++crossed;
    }
  }
  return crossed % 2 === 1;
}

/** Asserts that exactly the pixels from the isovalue on are inside. */
function checkFilled(field, isovalue, what) {
  const {width, height, values} = field;
  const lines = insideOf({width, height, segments: contours(field, isovalue),
    isInside: values[0] >= isovalue});
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      // A little within the border, on which lines run.
      const [px, py] = [[x, width], [y, height]].map(([at, count]) =>
        Math.min(Math.max(at, 0.01), count - 1.01) + 0.003);
      assert.equal(isInside(lines, px, py), values[y * width + x] >= isovalue,
        `${what}: pixel ${x}, ${y} of ${JSON.stringify(values)}`);
    }
  }
}

test('the inside of contours has the pixels from the isovalue on, and no others', () => {
  let seed = 1;
  const random = count => {  // A fixed sequence (Numerical Recipes).
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return Math.floor(seed / 2 ** 32 * count);
  };
  for (let each = 0; each < 300; ++each) {
    const width = 2 + random(7), height = 2 + random(7), most = 2 + random(3);
    const values = Array.from({length: width * height}, () => random(most));
    checkFilled({width, height, values}, 0.5, `field ${each}`);
  }
});

test('holes stay holes, and a slice without contours is all inside or all outside', () => {
  const width = 9, height = 9;
  const ring = Array.from({length: 81}, (_, i) =>
    Number(Math.abs(Math.hypot(i % 9 - 4, Math.floor(i / 9) - 4) - 2.6) < 0.9));
  checkFilled({width, height, values: ring}, 0.5, 'ring');
  checkFilled({width, height, values: ring.map(value => 1 - value)}, 0.5, 'all but a ring');
  checkFilled({width, height, values: ring.map(() => 1)}, 0.5, 'inside');
  checkFilled({width, height, values: ring.map(() => 0)}, 0.5, 'outside');
});

/** A slice of 5 x 3 voxels of 2 x 3 mm across z, at 10 mm. */
const SLICE = /** @type {any} */ ({width: 5, height: 3, axis: 'z', index: 1, axes: [0, 1, 2],
  flips: [false, true], spacing_mm: [2, 3], places_mm: [null, null]});
/** @type {import('../../../host/serve/page/slices/patient_grid.js').Grid} */
const GRID = {voxel_to_patient: [2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 10, 0, 100, 200, 0, 1],
  slice_places: [], size: [5, 3, 4]};

test('a plane cuts a slice from border to border, and the kept side is told', () => {
  const across = cutOf(SLICE, GRID, [1, 0, 0, -103]);  // Left of 103 mm: 3 mm from the first voxel.
  assert.deepEqual(across?.from, [3, -1.5]);
  assert.deepEqual(across?.to, [3, 7.5]);
  assert.deepEqual(across?.kept, [1, 0]);
  const down = cutOf(SLICE, GRID, [0, -2, 0, 2 * 202]);  // Anterior of 202 mm; rows are flipped.
  assert.deepEqual(down?.from, [-1, 4]);
  assert.deepEqual(down?.to, [9, 4]);
  assert.deepEqual(down?.kept, [0, 1]);
});

test('an oblique plane cuts along a straight line; a parallel or distant one does not', () => {
  // Through (100, 206, 10) and (106, 203, 10): from the top left two rows down to the right.
  const cut = cutOf(SLICE, GRID, [1, 2, 0, -512]);
  for (const [u, v] of [cut?.from ?? [], cut?.to ?? []]) {
    assert.ok(Math.abs(100 + u + 2 * (206 - v) - 512) < 1e-9, `${u}, ${v}`);
  }
  assert.ok(Math.abs(Math.hypot(...cut?.kept ?? []) - 1) < 1e-12);
  assert.ok((cut?.kept[0] ?? 0) > 0 && (cut?.kept[1] ?? 0) < 0);
  assert.equal(cutOf(SLICE, GRID, [0, 0, 1, -5]), null);
  assert.equal(cutOf(SLICE, GRID, [1, 0, 0, -50]), null);
});
