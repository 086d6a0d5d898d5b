// Colors that mean something differ for all eyes: charts of the machine, contours of tissues, marks
// over slices. Differences are CIEDE2000; 2 is just visible, side by side.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';
import { contrast, difference, least, over, parsed } from './colors.js';

const ROOT = new URL('../../../', import.meta.url);
const CHART_DIFFERENCE = 12, MARK_DIFFERENCE = 10, TISSUE_DIFFERENCE = 8;
const GRAPHIC_CONTRAST = 3;  // WCAG 1.4.11.

const read = name => readFileSync(new URL(name, ROOT), 'utf8');

/** Colors that a style sheet names, and those of `below` that it does not. */
function namedIn(sheet, below = {}) {
  return { ...below, ...Object.fromEntries([...read(`host/serve/page/${sheet}`)
    .matchAll(/--([\w-]+): (#[0-9a-f]{3,8});/g)].map(([, name, hex]) => [name, parsed(hex)])) };
}

const dark = namedIn('tokens.css'), light = namedIn('light.css', dark);
const HUES = [...Array(8).keys()].map(number => `hue-${number}`);

/** The colors of surfaces, which the host gives: those of tissues by name, and the others. */
function colorsOfSurfaces() {
  const tissues = [...read('host/commands/text/tissues.cpp')
    .matchAll(/\{"(\w+)", -?[\d.]+, \{(\d+), (\d+), (\d+)\}/g)];
  const others = [...read('host/commands/command_surface.cpp')
    .matchAll(/Color\{(\d+), (\d+), (\d+)\}/g)];
  const color = parts => parts.map(each => Number(each) / 255);
  return { tissues: Object.fromEntries(tissues.map(([, name, ...rgb]) => [name, color(rgb)])),
           others: Object.fromEntries(
             others.map(([, ...rgb], at) => [`color_${at}`, color(rgb)])) };
}

/** Pairs that differ by less than `wanted`, as sentences. */
function alike(colors, wanted) {
  const all = Object.entries(colors);
  return all.flatMap(([name, color], at) => all.slice(at + 1).flatMap(([other, its]) => {
    const { value, eyes } = least(color, its);
    return value < wanted ? [`${name} and ${other} differ by ${value.toFixed(1)}: ${eyes}`] : [];
  }));
}

test('CIEDE2000 has the values of Sharma, Wu and Dalal', () => {
  for (const [a, b, wanted] of [
    [[50, 2.6772, -79.7751], [50, 0, -82.7485], 2.0425], [[50, 0, 0], [50, -1, 2], 2.3669],
    [[50, 2.49, -0.001], [50, -2.49, 0.0011], 7.2195], [[50, 2.5, 0], [73, 25, -18], 27.1492],
    [[22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373],
    [[2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082]]) {
    assert.ok(Math.abs(difference(a, b) - wanted) < 5e-5, `${difference(a, b)}, not ${wanted}`);
  }
});

for (const [theme, colors] of Object.entries({ dark, light })) {
  test(`the colors of charts differ for all eyes and from the ground, ${theme} theme`, () => {
    const hues = Object.fromEntries(HUES.map(name => [name, colors[name]]));
    assert.deepEqual(alike(hues, CHART_DIFFERENCE), []);
    for (const ground of ['raised', 'panel']) {
      for (const name of HUES) {
        const value = contrast(colors[name], colors[ground]);
        assert.ok(value >= GRAPHIC_CONTRAST, `${name} on ${ground}: ${value.toFixed(2)}`);
      }
    }
    // The model's bar: the mean of all nodes, and the rest of the busiest (panels.css).
    const opacity = Number(/\.use-busiest \{[^}]*opacity: ([\d.]+)/.exec(
      read('host/serve/page/panels.css'))[1]);
    const mean = colors['hue-0'], rest = over([...mean.slice(0, 3), opacity], colors.raised);
    assert.deepEqual(alike({ mean, rest, ground: colors.raised }, MARK_DIFFERENCE), []);
  });
}

test('marks over slices differ from each other for all eyes', () => {
  const { 'over-ink': letters, 'over-accent': crosshair, 'over-warn': measurement } = dark;
  assert.deepEqual(alike({ letters, crosshair, measurement }, MARK_DIFFERENCE), []);
});

test('contours stand out from every gray by their color or their edge', () => {
  const { tissues, others } = colorsOfSurfaces();
  assert.equal(Object.keys(tissues).length, 7);
  assert.equal(Object.keys(others).length, 6);
  const weakest = color => Math.min(...[...Array(256).keys()].map(level => {
    const gray = [level, level, level].map(each => each / 255);
    return Math.max(contrast(color, gray), contrast(over(dark['over-edge'], gray), gray));
  }));
  const of = Object.entries({ ...tissues, ...others }).map(([name, color]) =>
    ({ name, value: weakest(color) }));
  const weak = of.filter(({ value }) => value < GRAPHIC_CONTRAST);
  // With a dark edge, colors darker than L* = 69 cannot have 3. The host defines them.
  assert.deepEqual(weak.map(({ name }) => name), ['muscle', 'color_1', 'color_3', 'color_4']);
  for (const { name, value } of weak) assert.ok(value > 2, `${name}: ${value.toFixed(2)}`);
});

test('tissues differ for all eyes, but for pairs that are known', () => {
  const { tissues, others } = colorsOfSurfaces();
  const names = text => /^(\w+) and (\w+)/.exec(text)[0];
  // The host defines these colors; the names of surfaces and their handles tell them apart.
  assert.deepEqual(alike(tissues, TISSUE_DIFFERENCE).map(names),
                   ['lung and skin', 'skin and fat', 'skin and bone', 'bone and cortex']);
  assert.deepEqual(alike(others, TISSUE_DIFFERENCE).map(names),
                   ['color_1 and color_4', 'color_2 and color_3', 'color_2 and color_5']);
});
