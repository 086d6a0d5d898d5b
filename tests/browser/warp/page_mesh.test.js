// The triangles of a picture that is shown from other viewpoints.
import assert from 'node:assert/strict';
import test from 'node:test';
import { coveredCells, maskRowBytes } from '../../../host/serve/page/picture/lean_depths.js';
import { calmBuckets, canShowBlocks, meshOf }
  from '../../../host/serve/page/picture/warp_mesh.js';

const WIDTH = 70, HEIGHT = 45;  // The last cells of rows and columns are narrower.
const ROUNDING = 6;             // Depths by which blocks may differ.
const MOST = 3;

/** A picture of a part of a sphere with a steep slope, a step, a hole and a seam. */
function picture() {
  const columns = Math.ceil(WIDTH / 4) + 1, rows = Math.ceil(HEIGHT / 4) + 1;
  const corners = new Uint16Array(columns * rows);
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      const r = Math.hypot(4 * x - 35, 4 * y - 22) / 150;
      corners[y * columns + x] = Math.round(2000 - 400 * Math.sqrt(1 - r * r))
        + 60 * Math.max(0, x - 11) + (y > 9 ? 1400 : 0);
    }
  }
  const rowBytes = maskRowBytes(WIDTH), mask = new Uint8Array(rowBytes * HEIGHT);
  for (let y = 0; y < HEIGHT; y++) {
    for (let x = 0; x < WIDTH; x++) {
      const shows = Math.hypot(x - 20, y - 20) > 7;
      if (shows) mask[y * rowBytes + (x >> 3)] |= 1 << (x & 7);
    }
  }
  const seam = { cell: 2 * (columns - 1) + 15, near_pixels: 0x3333,
                 near: [900, 900, 900, 900], far: [1900, 1900, 1900, 1900] };
  return { columns, rows, corners, mask, seams: [seam] };
}

const placeOf = ({ columns }, corner) =>
  [Math.min(4 * (corner % columns), WIDTH), Math.min(4 * Math.floor(corner / columns), HEIGHT)];

/** Triangles of the picture's corners: [a, b, c] and, in `at`, their place in the list. */
function* trianglesOf(lean, { triangles }) {
  for (let at = 0; at < triangles.length; at += 3) {
    const all = [...triangles.subarray(at, at + 3)];
    if (all.every(corner => corner < lean.columns * lean.rows)) yield { at, all };
  }
}

function areaOf([[ax, ay], [bx, by], [cx, cy]]) {
  return ((cx - ax) * (by - ay) - (bx - ax) * (cy - ay)) / 2;  // y points down.
}

test('triangles cover each covered cell once, counterclockwise, with and without blocks', () => {
  const lean = picture(), covered = coveredCells(lean, WIDTH, HEIGHT);
  const counts = [true, false].map(hasBlocks => {
    const mesh = meshOf(lean, covered, WIDTH, HEIGHT, hasBlocks);
    const area = new Map();
    for (const { all } of trianglesOf(lean, mesh)) {
      const places = all.map(corner => placeOf(lean, corner)), size = areaOf(places);
      assert.ok(size > 0, `${places}`);
      // A pixel that lies in the triangle tells the cell, or that of a block.
      for (let y = 0; y < HEIGHT; y++) {
        for (let x = 0; x < WIDTH; x++) {
          const [a, b, c] = places, p = [x + 0.5, y + 0.49];
          const parts = [[a, b, p], [b, c, p], [c, a, p]].map(areaOf);
          const pixel = y * WIDTH + x;
          if (parts.every(part => part > 0)) area.set(pixel, (area.get(pixel) ?? 0) + 1);
        }
      }
    }
    let pixels = 0;
    covered.forEach((value, cell) => {
      const left = 4 * (cell % (lean.columns - 1));
      const top = 4 * Math.floor(cell / (lean.columns - 1));
      for (let y = top; y < Math.min(HEIGHT, top + 4); y++) {
        for (let x = left; x < Math.min(WIDTH, left + 4); x++) {
          const expected = value && cell !== lean.seams[0].cell ? 1 : 0;
          assert.equal(area.get(y * WIDTH + x) ?? 0, expected, `pixel ${x} ${y}`);
          pixels += expected;
        }
      }
    });
    assert.ok(pixels > 2500);
    return mesh.triangles.length;
  });
  assert.ok(counts[0] < 0.95 * counts[1], `${counts}`);
});

test('neighbors share their corners, and blocks differ little from the depths', () => {
  const lean = picture(), covered = coveredCells(lean, WIDTH, HEIGHT);
  const mesh = meshOf(lean, covered, WIDTH, HEIGHT);
  const sides = new Set(), used = new Set();
  for (const { all } of trianglesOf(lean, mesh)) {
    all.forEach((a, k) => sides.add(`${a} ${all[(k + 1) % 3]}`));
    all.forEach(corner => used.add(corner));
  }
  let long = 0;
  for (const side of sides) {
    const [a, b] = side.split(' ').map(Number);
    const [[ax, ay], [bx, by]] = [a, b].map(corner => placeOf(lean, corner));
    if (Math.abs(ax - bx) !== 8 && Math.abs(ay - by) !== 8) continue;
    ++long;
    // No other triangle ends in the middle of a long side.
    assert.ok(sides.has(`${b} ${a}`), `${[ax, ay]} to ${[bx, by]} has no neighbor`);
    const middle = (a + b) / 2;
    if (used.has(middle)) continue;
    const depth = (lean.corners[a] + lean.corners[b]) / 2;
    assert.ok(Math.abs(depth - lean.corners[middle]) <= ROUNDING);
  }
  assert.ok(long > 30, `${long}`);
});

/** How much longer a triangle becomes at most if a warp moves it. */
function stretchOf(lean, corners, warp, [width, height]) {
  const [a, b, c] = corners.map(corner => placeOf(lean, corner));
  const [p, q, r] = corners.map(corner => {
    const [x, y] = placeOf(lean, corner), z = (lean.corners[corner] - 0.5) / 4095 * 2 - 1;
    const clip = [x / WIDTH * 2 - 1, 1 - y / HEIGHT * 2, z, 1];
    const [X, Y, , W] = [0, 1, 2, 3].map(row =>
      clip.reduce((sum, each, k) => sum + warp[4 * k + row] * each, 0));
    return [X / W * width / 2, -Y / W * height / 2];
  });
  const [[ux, uy], [vx, vy]] = [[b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]];
  const det = ux * vy - uy * vx;
  const column = (k, s, t) => ((q[k] - p[k]) * s + (r[k] - p[k]) * t) / det;
  const [m00, m01] = [column(0, vy, -uy), column(0, -vx, ux)];
  const [m10, m11] = [column(1, vy, -uy), column(1, -vx, ux)];
  const sum = m00 ** 2 + m01 ** 2 + m10 ** 2 + m11 ** 2, area = m00 * m11 - m01 * m10;
  return Math.sqrt((sum + Math.sqrt(Math.max(0, sum ** 2 - 4 * area ** 2))) / 2);
}

/** A turn about the vertical axis, with perspective if `w` is above 0; column by column. */
function turnOf(degrees, w, zoom) {
  const [c, s] = [Math.cos(degrees * Math.PI / 180), Math.sin(degrees * Math.PI / 180)];
  return new Float32Array([zoom * c, 0, -s, -w * s, 0, zoom, 0, 0, zoom * s, 0, c, w * c,
                           0, 0, 0, 1]);
}

/** The depth that the triangles show at a place; undefined if none is there. */
function depthAt(lean, mesh, x, y) {
  for (const { all } of trianglesOf(lean, mesh)) {
    const [a, b, c] = all.map(corner => placeOf(lean, corner)), p = [x, y];
    const parts = [[b, c, p], [c, a, p], [a, b, p]].map(areaOf);
    if (parts.every(part => part >= 0)) {
      const sum = parts[0] + parts[1] + parts[2];
      return all.reduce((depth, corner, k) => depth + lean.corners[corner] * parts[k] / sum, 0);
    }
  }
  return undefined;
}

test('blocks show each place at nearly the depth of its cell', () => {
  const lean = { ...picture(), seams: [] }, { columns } = lean;
  lean.mask.fill(0xff);
  // The diagonals of one cell are far apart: of the upper left one, of the lower right one.
  [[0, 6, 0, 6, -6, 0, 0, 0, 0], [0, 0, 0, 0, -6, 6, 0, 6, 0]].forEach((rough, block) => {
    for (let i = 0; i < 9; i++) {
      const corner = (2 + Math.floor(i / 3)) * columns + 2 + 4 * block + i % 3;
      lean.corners[corner] = 1000 + rough[i];
    }
  });
  const covered = coveredCells(lean, WIDTH, HEIGHT);
  const [blocks, cells] = [true, false].map(hasBlocks =>
    meshOf(lean, covered, WIDTH, HEIGHT, hasBlocks));
  assert.ok(blocks.triangles.length < cells.triangles.length);
  for (let y = 0.5; y < HEIGHT - 5; y += 1.5) {
    for (let x = 0.5; x < WIDTH - 6; x += 1.5) {
      const difference = depthAt(lean, blocks, x, y) - depthAt(lean, cells, x, y);
      assert.ok(Math.abs(difference) <= ROUNDING + 1e-9, `${x} ${y}: ${difference}`);
    }
  }
});

test('calm cells become at most three times longer, whatever the warp', () => {
  const lean = picture(), covered = coveredCells(lean, WIDTH, HEIGHT);
  let calmest = 0, torn = 0, partial = 0;
  for (const hasBlocks of [true, false]) {
    const mesh = meshOf(lean, covered, WIDTH, HEIGHT, hasBlocks);
    for (const degrees of [0, 2, 10, 25, -40, 70]) {
      for (const w of [0, 0.2, 0.5]) {
        for (const [zoom, ...viewport] of [[1, WIDTH, HEIGHT], [2, 2 * WIDTH, 2 * HEIGHT]]) {
          const warp = turnOf(degrees, w, zoom), scale = zoom * viewport[0] / WIDTH;
          const calm = calmBuckets(warp, { width: WIDTH, height: HEIGHT },
                                   { width: viewport[0], height: viewport[1] }, MOST * scale);
          const end = calm > 0 ? mesh.fullEnds[calm - 1] : 0;
          calmest = Math.max(calmest, end);
          for (const { at, all } of trianglesOf(lean, mesh)) {
            const stretch = stretchOf(lean, all, warp, viewport) / scale;
            torn += stretch > MOST ? 1 : 0;
            const isCalm = at < end || at >= mesh.partialEnds[calm];
            if (isCalm) assert.ok(stretch <= MOST + 1e-6, `${degrees} ${w}: ${stretch}`);
            partial += at >= mesh.partialEnds[calm] ? 1 : 0;
          }
        }
      }
    }
  }
  assert.ok(calmest > 1000 && torn > 100 && partial > 100, `${calmest} ${torn} ${partial}`);
});

test('cells that show the background lie behind the others, the steepest first', () => {
  const lean = picture(), covered = coveredCells(lean, WIDTH, HEIGHT), { columns } = lean;
  const mesh = meshOf(lean, covered, WIDTH, HEIGHT, false), found = new Set();
  for (let calm = 1; calm < 14; calm++) {
    let expected = 0;
    covered.forEach((value, cell) => {
      const [x, y] = [cell % (columns - 1), Math.floor(cell / (columns - 1))];
      const isNarrow = 4 * (x + 1) > WIDTH || 4 * (y + 1) > HEIGHT;
      const depths = [0, 1, columns, columns + 1].map(k => lean.corners[y * columns + x + k]);
      const range = Math.max(...depths) - Math.min(...depths);
      const isCalm = !isNarrow && range < 2 ** (calm - 1);
      expected += value === 1 && cell !== lean.seams[0].cell && isCalm ? 2 : 0;
    });
    assert.equal((mesh.triangles.length - mesh.partialEnds[calm]) / 3, expected, `${calm}`);
    found.add(expected);
  }
  assert.ok(found.size > 2, `${[...found]}`);
});

test('blocks are shown only if they move nothing by more than half a pixel', () => {
  const size = { width: 512, height: 512 };
  assert.ok(canShowBlocks(turnOf(0, 0, 1), size));
  assert.ok(canShowBlocks(turnOf(20, 0, 1), size));
  // Half a pixel: 256 sin(a) 2 x 6 / 4095 is 0.5 at 41.8 degrees.
  assert.ok(canShowBlocks(turnOf(41, 0, 1), size));
  assert.ok(!canShowBlocks(turnOf(43, 0, 1), size));
  assert.ok(!canShowBlocks(turnOf(20, 0, 2), { width: 1024, height: 1024 }));
});
