// Triangles that the page fills itself, as WebGL would.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Raster } from '../../../host/serve/page/picture/raster.js';
import { clippedWalls } from '../../../host/serve/page/picture/warp_walls.js';

const SIZE = 16, ALL = SIZE * SIZE;
const BACKGROUND = 0xff000000;

/** A picture of pixels that all differ, each with a surface. */
const source = { words: Uint32Array.from({ length: ALL }, (_, at) => 0xff000000 | at * 257 + 1),
                 first: 0, width: SIZE, height: SIZE,
                 mask: new Uint8Array(ALL / 8).fill(255) };

/** Corners of a square at x, y: on the canvas, and at the same place of the picture. */
function square(x, y, size, depthAt) {
  const corners = [[x, y], [x, y + size], [x + size, y], [x + size, y + size]];
  return { places: Float64Array.from(corners.flatMap(([x, y]) => [x, y, depthAt(x, y)])),
           sources: Float32Array.from(corners.flat()),
           seams: Uint32Array.from(corners.flatMap(() => [0xffff, 0])) };
}
const halves = Uint32Array.of(0, 1, 2, 2, 1, 3);

function cleared() {
  const raster = new Raster(SIZE, SIZE);
  raster.clear(BACKGROUND);
  return raster;
}
/** The numbers of the pixels that are drawn. */
function drawn({ colors }) {
  return [...colors.keys()].filter(at => colors[at] !== BACKGROUND);
}

test('two halves fill a square with the colors of the picture', () => {
  for (const fill of ['plain', 'masked']) {
    const raster = cleared();
    raster[fill](source, square(0, 0, SIZE, () => 0), halves, raster.colors);
    assert.deepEqual([...raster.colors], [...source.words], fill);
  }
});

test('the nearer one of two surfaces is seen, whatever is drawn first', () => {
  for (const depths of [[-0.5, 0.5], [0.5, -0.5]]) {
    const raster = cleared();
    depths.forEach((depth, at) =>
      raster.plain({ ...source, words: source.words.map(() => at + 1) },
                   square(2, 2, 8, () => depth), halves));
    assert.deepEqual(drawn(raster).map(at => raster.colors[at]),
                     Array(64).fill(depths[0] < depths[1] ? 1 : 2));
  }
});

test('the planes cut a surface where it is, not where a layer is drawn', () => {
  const least = -0.95, slope = 0.1;
  const layer = square(0, 0, 8, x => least + slope * x);
  const before = square(0, 0, 8, x => -1.33 + slope * x);
  const behind = square(0, 0, 8, x => 0.67 + slope * x);
  for (const fill of ['plain', 'masked']) {
    for (const offset of [0, 4]) {
      const counts = [layer, before, behind].map(vertices => {
        const raster = cleared();
        raster.offset_px = offset;
        raster[fill](source, vertices, halves, raster.colors);
        return drawn(raster).length;
      });
      assert.deepEqual(counts, [64, 40, 24], `${fill}, ${offset} px nearer`);
    }
  }
});

test('only rows and places that are wanted are drawn', () => {
  const raster = cleared();
  raster.parity = 1;
  raster.clip = { left: 3, top: 2, right: 7, bottom: 9 };
  raster.plain(source, square(0, 0, SIZE, () => 0), halves);
  const wanted = [3, 5, 7].flatMap(row => [3, 4, 5, 6].map(x => row * SIZE + x));
  assert.deepEqual(drawn(raster), wanted);
});

test('from behind, and behind the eye, a triangle is not seen', () => {
  const raster = cleared(), vertices = square(0, 0, SIZE, () => 0);
  raster.plain(source, vertices, Uint32Array.of(0, 2, 1, 2, 3, 1));
  vertices.places.fill(NaN, 0, 3);
  raster.plain(source, vertices, Uint32Array.of(0, 1, 2));
  assert.deepEqual(drawn(raster), []);
});

test('a wall that reaches behind the eye is cut off before it', () => {
  // Along the upper edge of a picture of 8 x 8, far to both sides: bits ACROSS, BEYOND and LONG.
  const texels = Uint32Array.of((1 | 4 | 8) << 26, 2048 | 2048 << 16);
  const identity = Float32Array.of(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
  const whole = clippedWalls({ texels, count: 1, rows: 1 }, { width: 8, height: 8 }, identity);
  assert.equal(whole.length, 6 * 3);
  const turned = Float32Array.from(identity);
  turned[3] = 0.5;  // w = 1 + x / 2: the left end, at x = -3, is behind the eye.
  const cut = clippedWalls({ texels, count: 1, rows: 1 }, { width: 8, height: 8 }, turned);
  const ws = cut.filter((_, at) => at % 3 === 2);
  assert.ok(ws.length >= 3 && ws.every(w => w > 0 && w < 4), `${ws}`);
  assert.ok(Math.min(...ws) < 0.01, `${ws}`);
});
