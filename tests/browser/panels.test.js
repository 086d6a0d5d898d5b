// The panels on the right: slices, volume, distances, the machine and its inspector.
import assert from 'node:assert/strict';
import test from 'node:test';
import { byId, page, server, usePage } from './harness.js';
import { after, ask, drag, lookAtPicture, middleOf, rawSocket, say, settled, state, stateWhen }
  from './steps.js';

const REGION = 128;  // Pixels along a region's edge.
const SPHERE_MM = 60;  // Diameter: host/phantom/analytic.cpp.

let raw;

usePage(undefined, async () => {
  raw = await rawSocket(page, server.url);
});

/** Runs in the page: a fingerprint of a canvas, and how many pixels have about that color. */
function lookAtCanvas(canvas, color) {
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const [r, g, b] = [1, 3, 5].map(at => parseInt(color.slice(at, at + 2), 16));
  let hash = 7;
  let near = 0;
  for (let i = 0; i < data.length; i += 4) {
    hash = (Math.imul(hash, 31) + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) | 0;
    const far = Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b);
    near += far < 30 ? 1 : 0;
  }
  return { hash, near };
}

const canvasOf = (id, color = '#000000') => byId(id).evaluate(lookAtCanvas, color);

/** Does something and waits until a canvas shows something else. */
async function redrawn(id, act) {
  const { hash } = await canvasOf(id);
  await act();
  await page.waitForFunction(new Function('[canvas, was]',
    `return (${lookAtCanvas})(canvas, '#000000').hash !== was;`),
                             [await byId(id).elementHandle(), hash]);
}

test('slices stand as radiologists hang them, with the contour of the surface', async () => {
  await byId('tab-slices').click();
  await settled(page);
  const { size } = (await state(page)).volume;
  const answers = {};
  for (const axis of ['x', 'y', 'z']) {
    const index = Math.floor(size['xyz'.indexOf(axis)] / 2);
    answers[axis] = (await ask(raw, { ask: 'slice', axis, index })).json;
  }
  assert.deepEqual(answers.z.letters, { left: 'R', right: 'L', top: 'A', bottom: 'P' });
  assert.deepEqual(answers.y.letters, { left: 'R', right: 'L', top: 'S', bottom: 'I' });
  assert.deepEqual(answers.x.letters, { left: 'A', right: 'P', top: 'S', bottom: 'I' });
  const { color } = (await state(page)).surfaces.find(({ name }) => name === 'bone');
  await page.getByTestId('slice-axial').waitFor();
  await redrawn('slice-axial', () => byId('slice-index-0').fill(String(size[2] / 2 - 6)));
  assert.ok((await canvasOf('slice-axial', color)).near > 50, `a contour in ${color}`);
});

test('a slice outside of the volume is refused in a sentence with both numbers', async () => {
  await assert.rejects(ask(raw, { ask: 'slice', axis: 'z', index: 4711 }), /4711.*47|47.*4711/s);
  await assert.rejects(ask(raw, { ask: 'slice', axis: 'w', index: 1 }), /w/);
});

test('window and level change pixels, the wheel steps, the readout tells values', async () => {
  await redrawn('slice-axial', () => byId('window-Bone').click());
  await redrawn('slice-axial', async () => {
    await byId('slices-level').fill('900');
    await byId('slices-level').press('Enter');
  });
  const at = await middleOf(byId('slice-axial'));
  const index = Number(await byId('slice-index-0').inputValue());
  await redrawn('slice-axial', async () => {
    await page.mouse.move(at.x, at.y);
    await page.mouse.wheel(0, 120);
  });
  assert.notEqual(Number(await byId('slice-index-0').inputValue()), index);
  assert.match(await byId('slices-readout').innerText(), /-?\d+\s+at voxel \d+, \d+, \d+/);
});

test('the crosshair goes from a slice to the picture, and from the picture to the slices',
     async () => {
  const at = await middleOf(byId('slice-axial'));
  await redrawn('slice-coronal', () => page.mouse.click(at.x + 12, at.y + 9));
  await byId('crosshair').and(page.locator('[visibility=visible], :not([visibility])')).waitFor();
  const stage = await middleOf(byId('stage'));
  await redrawn('slice-axial', () => page.mouse.click(stage.x, stage.y - 40));
});

test('the volume report tells size, spacing, values and source', async () => {
  await byId('tab-volume').click();
  const { volume } = await state(page);
  const facts = await byId('volume-facts').innerText();
  const { size, maximum } = volume;
  for (const fact of [size.join(' × '), 'not stated', 'phantom:pelvis', String(maximum)]) {
    assert.ok(facts.includes(fact), `'${fact}' in ${facts}`);
  }
  assert.ok((await byId('volume-findings').innerText()).length > 10);
});

test('a distance of two clicks agrees with picks, and follows the camera', async () => {
  const stage = await byId('stage').boundingBox();
  const { size } = await state(page);
  const pixels = [[0.44, 0.4], [0.56, 0.42]].map(([x, y]) =>
    [Math.floor(x * size[0]), Math.floor(y * size[1])]);
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  for (const [x, y] of pixels) {
    await page.mouse.click(stage.x + (x + 0.5) / size[0] * stage.width,
                           stage.y + (y + 0.5) / size[1] * stage.height);
  }
  await byId('measure-list').locator('li').waitFor();
  const picks = [];
  for (const [x, y] of pixels) picks.push((await say(raw, `pick ${x} ${y}`)).result.p_mm);
  const expected = Math.hypot(...picks[0].map((mm, axis) => mm - picks[1][axis]));
  const told = Number.parseFloat(await byId('measure-list').locator('b').innerText());
  assert.ok(Math.abs(told - expected) <= Math.max(0.05, told < 100 ? 0.06 : 0.6),
            `${told} mm, the picks are ${expected} mm apart`);
  await page.keyboard.press('Escape');
  const line = () => byId('measure-lines').locator('line').first().getAttribute('x1');
  const before = await line();
  await after(page, async () => {
    await byId('stage').focus();
    await page.keyboard.press('ArrowRight');
  });
  assert.notEqual(await line(), before);
  await byId('measure-delete-1').click();
  assert.equal(await byId('measure-lines').locator('line').count(), 0);
});

/** The point in mm that a place of the page shows. */
async function pickAt(x, y) {
  const box = await byId('frame').boundingBox();
  const { size } = await state(page);
  const pixel = [(x - box.x) / box.width * size[0], (y - box.y) / box.height * size[1]];
  return (await say(raw, `pick ${pixel.map(Math.floor).join(' ')}`)).result.p_mm;
}

test('the first end of a distance stays where it was clicked', async () => {
  const { x, y } = await middleOf(byId('stage'));
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const first = await pickAt(x - 30, y);
  await page.mouse.click(x - 30, y);
  await byId('measure-message').getByText('second').waitFor();
  await after(page, async () => {
    await byId('stage').focus();
    for (let n = 0; n < 4; n++) await page.keyboard.press('ArrowRight');
  });
  await settled(page);
  const second = await pickAt(x + 30, y);
  await page.mouse.click(x + 30, y);
  await byId('measure-list').locator('li').waitFor();
  const told = Number.parseFloat(await byId('measure-list').locator('b').innerText());
  const expected = Math.hypot(...first.map((mm, axis) => mm - second[axis]));
  assert.ok(Math.abs(told - expected) <= Math.max(0.05, told < 100 ? 0.06 : 0.6),
            `${told} mm, the clicked points are ${expected} mm apart`);
  await page.keyboard.press('Escape');
});

test('why: pixel, instructions, triangle, and the cell with its eight values', async () => {
  const { revision } = await say(raw, 'view anterior');
  await stateWhen(page, (now, set) => now.revision >= set, revision);
  await settled(page);
  await byId('tab-inspector').click();
  await byId('inspect-mode').click();
  const stage = await middleOf(byId('stage'));
  await page.mouse.click(stage.x, stage.y - 30);
  await byId('why-pixel').waitFor();
  const sentence = await byId('why-sentence').innerText();
  assert.match(sentence, /\w+ \w+ \w+/);
  await byId('why-stores').locator('summary').click();
  assert.match(await byId('why-stores').innerText(), /→/, 'what instructions changed');
  assert.match(await byId('why-triangle').innerText(), /gp-\d/);
  const values = await byId('cell').locator('text').allTextContents();
  assert.ok(values.filter(text => /-?\d/.test(text)).length >= 8, values.join(' | '));

  await page.mouse.click(stage.x + 8, stage.y - 30);
  await page.waitForFunction(was => document.querySelector('[data-testid=why-sentence]')
    ?.textContent !== was, sentence);
  assert.ok(await byId('why-stores').locator('li').first().isVisible(), 'unfolded stays unfolded');
});

/** In the page: the color of the displayed picture under a place of the window. */
function colorUnder({ x, y }) {
  const canvas = document.querySelector('[data-testid=frame]');
  const box = canvas.getBoundingClientRect();
  const { data } = canvas.getContext('2d').getImageData(
    Math.floor((x - box.left) / box.width * canvas.width),
    Math.floor((y - box.top) / box.height * canvas.height), 1, 1);
  return '#' + [...data.slice(0, 3)].map(part => part.toString(16).padStart(2, '0')).join('');
}

test('a length between two clicks in a slice is the length in the patient', async () => {
  await byId('tab-slices').click();
  await byId('choice-measure').click();
  const at = await middleOf(byId('slice-axial'));
  const places = [[-20, -5], [25, 10]].map(([x, y]) =>
    ({ x: Math.round(at.x) + x, y: Math.round(at.y) + y }));
  const ends = [];
  for (const { x, y } of places) {
    await page.mouse.move(x, y);
    const text = await byId('slices-readout').locator('span').innerText();
    ends.push([...text.matchAll(/([LRPASI]) ([\d.]+)/g)].map(([, side, mm]) =>
      'RAI'.includes(side) ? -mm : Number(mm)));
    await page.mouse.click(x, y);
  }
  const known = Math.hypot(...ends[0].map((mm, axis) => mm - ends[1][axis]));
  await byId('slices-message').getByText(' mm. ').waitFor();
  const told = Number.parseFloat(await byId('slices-message').innerText());
  // From 100 mm on, lengths are told in whole millimeters.
  const rounded = told < 100 ? 0.3 : 0.6;
  assert.ok(known > 10 && Math.abs(told - known) < rounded, `${told} mm, not ${known} mm`);
  await byId('tab-measure').click();
  const listed = byId('measure-list').locator('li b').last();
  assert.ok(Math.abs(Number.parseFloat(await listed.innerText()) - known) < rounded);
  await byId('tab-slices').click();
  await byId('choice-point').click();
});

test('why: the inspector says that the picture shows the mean of all samples', async () => {
  await byId('tab-inspector').click();
  await byId('inspect-mode').click();
  const { samples } = await settled(page);
  assert.equal(samples, 16);
  const stage = await middleOf(byId('stage'));
  const place = { x: Math.round(stage.x), y: Math.round(stage.y) - 30 };
  await page.mouse.click(place.x, place.y);
  const message = byId('inspector-message');
  await message.getByText('16 samples').waitFor();
  const told = await message.innerText();
  assert.ok(told.includes(await page.evaluate(colorUnder, place)), told);
  assert.match(told, /This explains one sample, at the pixel's center\./);
});

/** In the page: pixels of a region in a picture that the server has for download. */
async function regionOf([path, x0, y0, edge]) {
  const bitmap = await createImageBitmap(await (await fetch(path)).blob());
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const [width, height] = [Math.min(edge, bitmap.width - x0), Math.min(edge, bitmap.height - y0)];
  return { width, height, data: [...context.getImageData(x0, y0, width, height).data] };
}

test('scrubbing: the start is not the end, and the end is the region itself', async () => {
  await byId('scrub-status').getByText('instructions executed').waitFor();
  await redrawn('region', () => byId('scrub-first').click());
  await redrawn('region', () => byId('scrub-last').click());
  await byId('disassembly').locator('li').first().waitFor();
  const [x, y] = (await state(page)).size.map(each => Math.floor(each / 2));
  const { json, bytes } = await ask(raw, { ask: 'scrub', x, y, at: -1 });
  assert.equal(json.at, json.count);
  const { result } = await say(raw, 'snapshot download:whole.png');
  const path = result.download + new URL(server.url).search;
  const whole = await page.evaluate(regionOf, [path, json.x0, json.y0, REGION]);
  for (let row = 0; row < whole.height; row++) {
    for (let i = 0; i < whole.width; i++) {
      const [here, there] = [4 * (row * whole.width + i), 4 * (row * REGION + i)];
      assert.deepEqual(bytes.slice(there, there + 3), whole.data.slice(here, here + 3),
                       `pixel ${json.x0 + i}, ${json.y0 + row}`);
    }
  }
});

test('the machine: its nodes, what they do, who draws what', async () => {
  await byId('tab-machine').click();
  const { gps, renderers } = (await state(page)).machine;
  await byId('node-gp-0').waitFor();
  const nodes = await byId('nodes').getByRole('button').allTextContents();
  for (let gp = 0; gp < gps; gp++) assert.ok(nodes.some(each => each.includes(`gp-${gp}`)));
  for (let n = 0; n < renderers; n++) assert.ok(nodes.some(each => each.includes(`renderer-${n}`)));
  const stage = await middleOf(byId('stage'));
  await drag(page, stage, { x: stage.x + 80, y: stage.y }, { steps: 20 });
  await byId('clocks').getByText('1993').waitFor();
  await page.getByText(/maximum [1-9]/).waitFor();
  await page.waitForFunction(() => [...document.querySelectorAll('[data-testid^=node-gp]')]
    .every(node => /\d %/.test(node.textContent)));
  await settled(page);
});

test('what the machine of 1993 would have taken is told when asked for, until the picture changes',
     async () => {
  assert.ok(await byId('model-facts').isHidden(), 'nothing is worked out before it is asked for');
  await byId('model-go').click();
  await byId('model-facts').waitFor();
  const { result } = await say(raw, 'model');
  const facts = await byId('model-facts').innerText();
  const { machine, gps, surfaces, frame } = result;
  const told = [machine, `${gps} GPs`, ...surfaces.map(({ name }) => `Surface ${name}`),
    ...surfaces.map(({ triangles }) => `${triangles.toLocaleString('en')} triangles`),
    `${Number(frame.frames_per_s.toPrecision(3))} frames/s`];
  for (const each of told) assert.ok(facts.includes(each), `'${each}' in ${facts}`);
  const rows = await byId('model-use').allInnerTexts();
  assert.equal(rows.length, frame.use.length);
  const limit = frame.use.findIndex(({ unit }) => unit === frame.limit);
  rows.forEach((row, at) => {
    assert.ok(row.includes(`${Math.round(100 * frame.use[at].busiest)} %`), row);
    assert.equal(/limit/.test(row), at === limit, row);
  });
  assert.equal(await byId('model-message').innerText(), '');
  await after(page, () => say(raw, 'view 60 10'));
  await byId('model-message').getByText('changed').waitFor();
});

test('the buttons of a node stay in place, whatever the node reports', async () => {
  await byId('node-gp-0').click();
  const boxWith = async sent => {
    await byId('node-dialog').getByText('No messages were sent.').waitFor({ state: sent });
    return byId('node-kill').boundingBox();
  };
  const idle = await boxWith('attached');
  await after(page, () => say(raw, 'view 20 20'));
  assert.deepEqual(await boxWith('detached'), idle);
  await byId('node-close').click();
});

test('a killed node is told of, and the same picture comes back', async () => {
  await after(page, () => say(raw, 'view 30 15'));
  await after(page, () => say(raw, 'background #102040'));
  const before = await settled(page);
  const { undo } = await state(page);
  await byId('node-gp-0').click();
  await byId('node-status').getByText(/In the last [0-9.]+ s/).waitFor();
  const dead = page.locator('[data-testid=node-gp-0].dead');
  const died = dead.getByText('dead', { exact: true }).waitFor();
  await byId('node-kill').click();
  await died;
  await byId('machine-events').getByText('gp-0').first().waitFor();
  await page.getByTestId(/^toast-/).getByText('gp-0').first().waitFor();
  await stateWhen(page, (now, was) => now.revision > was && !now.busy, before.revision);
  assert.equal((await settled(page)).digest, before.digest);
  await dead.waitFor({ state: 'detached' });
  const now = await state(page);
  assert.equal(now.undo, undo, 'what was done can still be undone');
  await after(page, () => byId('undo').click());
  assert.notEqual((await settled(page)).digest, before.digest);
  assert.ok((await lookAtPicture(page)).colors > 100);
});

test('distances end with their volume, also if its file stays', async () => {
  await byId('tab-measure').click();
  assert.ok(await byId('measure-list').locator('li').count() > 0);
  const source = (await state(page)).volume.source;
  await say(raw, `load ${source} smooth=2`);
  await byId('measure-list').locator('li').first().waitFor({ state: 'detached' });
  assert.equal((await state(page)).volume.source, source);
});

/**
 * In the page: opposite points of a red contour, left and right, top and bottom, in CSS pixels of
 * the window: the middles of the line's first and last pixels in its middle row and column.
 */
function oppositePoints(canvas) {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  const line = Array.from({ length: width * height }, (_, at) =>
    [at % width, Math.floor(at / width), data[4 * at] - data[4 * at + 2]])
    .filter(([, , red]) => red > 80);
  const box = canvas.getBoundingClientRect();
  const inWindow = ([x, y]) => ({ x: box.left + (x + 0.5) * box.width / width,
                                  y: box.top + (y + 0.5) * box.height / height });
  return [0, 1].map(along => {
    const across = line.map(place => place[1 - along]);
    const middle = Math.round((Math.min(...across) + Math.max(...across)) / 2);
    const places = line.filter(place => place[1 - along] === middle)
      .map(place => place[along]).sort((a, b) => a - b);
    const gap = places.findIndex((place, at) => places[at + 1] > place + 8);
    return [places.slice(0, gap + 1), places.slice(gap + 1)].map(run => {
      const end = (run[0] + run.at(-1)) / 2;
      return inWindow(along === 0 ? [end, middle] : [middle, end]);
    });
  });
}

test('two clicks on opposite points of a contour measure the diameter of the sphere', async () => {
  await say(raw, 'load phantom:sphere');
  const { revision } = await say(raw, 'surface surface color=#ff4020');
  const { volume } = await stateWhen(page, (now, set) => now.revision >= set, revision);
  await byId('tab-slices').click();
  await byId('slice-count-0').getByText(`${volume.size[2] / 2 + 1} / ${volume.size[2]}`).waitFor();
  await byId('choice-point').click();
  const box = await byId('slice-axial').boundingBox();
  // Beside the sphere, so that the crosshair covers no point of the contour that is clicked. The
  // slice is square and as high as its canvas.
  await redrawn('slice-axial', () =>
    page.mouse.click(box.x + box.width / 2 - 0.44 * box.height, box.y + 0.06 * box.height));
  await byId('choice-measure').click();
  const found = await page.waitForFunction(new Function('canvas',
    `const ends = (${oppositePoints})(canvas);
     return ends.flat().every(({ x, y }) => x > 0 && y > 0) && ends;`),
                                           await byId('slice-axial').elementHandle());
  for (const [axis, pair] of (await found.jsonValue()).entries()) {
    for (const { x, y } of pair) await page.mouse.click(x, y);
    await byId('measure-list').locator('li').nth(axis).waitFor({ state: 'attached' });
    const told = Number.parseFloat(await byId('slices-message').innerText());
    assert.ok(Math.abs(told - SPHERE_MM) <= volume.spacing_mm[axis] / 2,
              `${told} mm along ${'xy'[axis]}, the sphere has ${SPHERE_MM} mm`);
  }
});
