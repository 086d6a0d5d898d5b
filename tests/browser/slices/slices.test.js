// Slices: zoom, move, contours, colors, interpolation, windows.
import assert from 'node:assert/strict';
import test, { beforeEach } from 'node:test';
import { byId, page, server, shoot, usePage } from '../harness.js';
import { after, canvasPixels, drag, middleOf, rawSocket, say, settled, state }
  from '../steps.js';

const NOTCH = 120;

let raw;

usePage(undefined, async () => {
  raw = await rawSocket(page, server.url);
  await byId('tab-slices').click();
  await settled(page);
  await byId('slices-readout').getByText('crosshair').waitFor();
  await byId('slice-settings').locator('summary').click();
});

beforeEach(async () => {
  if (await byId('slice-whole').isVisible()) {
    await byId('slice-whole').click();
    await page.mouse.move(1, 1);
    await drawn();
  }
});

/** The voxel that the readout tells for a place of the axial slice. */
async function voxelAt(x, y) {
  await page.mouse.move(x, y);
  const text = await byId('slices-readout').innerText();
  return text.match(/at voxel (\d+), (\d+), (\d+)/).slice(1).map(Number);
}

const pixelsOf = id => canvasPixels(byId(id));

/** Waits for the next picture of the screen: views draw once per refresh. */
const drawn = () => page.evaluate(() => new Promise(done =>
  requestAnimationFrame(() => requestAnimationFrame(done))));

async function zoomAt(at, notches) {
  await page.mouse.move(at.x, at.y);
  await page.keyboard.down('Control');
  const deltaY = -Math.sign(notches) * NOTCH;
  for (let i = 0; i < Math.abs(notches); i++) await page.mouse.wheel(0, deltaY);
  await page.keyboard.up('Control');
  await drawn();
}

const times = async () => Number.parseFloat(await byId('slice-times').innerText());

/** How many pixels of a canvas have about that color. */
async function near(id, color) {
  const rgb = [1, 3, 5].map(at => parseInt(color.slice(at, at + 2), 16));
  const data = await pixelsOf(id);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    count += rgb.every((part, k) => Math.abs(data[i + k] - part) < 12) ? 1 : 0;
  }
  return count;
}

test('Ctrl and the wheel zoom all slices; the voxel under the pointer stays there', async () => {
  const middle = await middleOf(byId('slice-axial'));
  const at = { x: middle.x + 40, y: middle.y - 30 };
  const before = await voxelAt(at.x, at.y);
  const [axial, coronal] = [await pixelsOf('slice-axial'), await pixelsOf('slice-coronal')];
  await zoomAt(at, 6);
  assert.ok(Math.abs(await times() - 1.25 ** 6) < 0.1);
  assert.deepEqual(await voxelAt(at.x + 1, at.y), before);
  assert.notDeepEqual(await pixelsOf('slice-axial'), axial);
  assert.notDeepEqual(await pixelsOf('slice-coronal'), coronal);
  await zoomAt(at, -20);
  assert.equal(await times(), 1);
  assert.deepEqual(await voxelAt(at.x, at.y), before);
});

test('the Move tool and the middle button move a zoomed slice with the pointer', async () => {
  const at = await middleOf(byId('slice-axial'));
  await zoomAt(at, 7);
  const before = await voxelAt(at.x, at.y);
  const crosshair = (await state(page)).revision;
  await byId('choice-move').click();
  await drag(page, at, { x: at.x + 30, y: at.y - 20 });
  await drawn();
  assert.deepEqual(await voxelAt(at.x + 30, at.y - 20), before);
  await byId('choice-point').click();
  await page.mouse.move(at.x + 30, at.y - 20);
  await page.mouse.down({ button: 'middle' });
  await page.mouse.move(at.x, at.y, { steps: 5 });
  await page.mouse.up({ button: 'middle' });
  await drawn();
  assert.deepEqual(await voxelAt(at.x, at.y), before);
  assert.equal((await state(page)).revision, crosshair, 'nothing is sent to the machine');
});

test('a zoomed slice follows the crosshair', async () => {
  const at = await middleOf(byId('slice-axial'));
  await zoomAt(at, 3);
  /** Whether the vertical line of the crosshair is there: nothing else is blue. */
  const hasLine = () => byId('slice-axial').evaluate(canvas => {
    const { width, height } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
    const columns = Array.from({ length: width }, (_, x) =>
      Array.from({ length: height }, (_, y) => 4 * (y * width + x))
        .filter(i => data[i + 2] - data[i] > 40).length);
    return Math.max(...columns) > height / 3;
  });
  const box = await byId('slice-coronal').boundingBox();
  for (const share of [0.05, 0.95]) {  // Beyond what the axial slice shows.
    await page.mouse.click(box.x + share * box.width, box.y + box.height / 2);
    await drawn();
    assert.ok(await hasLine(), `at ${share}`);
  }
  await byId('slice-axial').focus();
  await page.keyboard.press('0');
  assert.equal(await times(), 1);
  await page.keyboard.press('+');
  assert.equal(await times(), 1.3);
  await byId('slice-whole').click();
  assert.equal(await times(), 1);
  assert.ok(await byId('slice-smaller').isDisabled());
});

test('a slice that was moved away from the crosshair stays there', async () => {
  const at = await middleOf(byId('slice-axial'));
  await zoomAt(at, 8);
  await page.mouse.down({ button: 'middle' });
  await page.mouse.move(at.x + 160, at.y + 90, { steps: 5 });
  await page.mouse.up({ button: 'middle' });
  const before = await voxelAt(at.x, at.y);
  const index = Number(await byId('slice-index-0').inputValue());
  await page.mouse.wheel(0, NOTCH);
  await byId('slice-count-0').getByText(`${index + 2} /`).waitFor();
  await drawn();
  const [x, y, z] = await voxelAt(at.x + 1, at.y);
  assert.deepEqual([x, y, z], [before[0], before[1], index + 1]);
});

/** Sends touches: each is a list of places. */
async function touches(...steps) {
  const session = await page.context().newCDPSession(page);
  for (const [type, ...points] of steps) {
    await session.send('Input.dispatchTouchEvent',
      { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  }
  await drawn();
}

test('a tap is a click, and two fingers are none', async () => {
  const at = await middleOf(byId('slice-axial'));
  const readout = async () => (await byId('slices-readout').innerText()).match(/voxel [\d, ]+/)[0];
  const crosshair = async () => {
    await page.mouse.move(1, 1);
    await byId('slices-readout').getByText('crosshair').waitFor();
    return readout();
  };
  const before = await crosshair();
  const [left, right] = [[at.x - 33, at.y + 11], [at.x + 20, at.y]];
  await touches(['touchStart', left], ['touchStart', left, right], ['touchEnd']);
  assert.equal(await crosshair(), before);
  await byId('choice-measure').click();
  await touches(['touchStart', left], ['touchStart', left, right], ['touchEnd']);
  assert.ok(!(await byId('slices-message').innerText()).includes('second'));
  await touches(['touchStart', left], ['touchEnd']);
  await byId('slices-message').getByText('second').waitFor();
  await byId('choice-point').click();
  await touches(['touchStart', left], ['touchEnd']);
  assert.notEqual(await crosshair(), before);
});

test('two fingers zoom and move', async () => {
  const at = await middleOf(byId('slice-axial'));
  const both = reach => [[at.x - reach, at.y], [at.x + reach, at.y]];
  await touches(['touchStart', [at.x - 20, at.y]], ['touchStart', ...both(20)],
                ...[25, 30, 40, 50, 60].map(reach => ['touchMove', ...both(reach)]), ['touchEnd']);
  assert.equal(await times(), 3);
  await byId('slice-whole').click();
});

test('contours are thick, thin or hidden', async () => {
  const { color } = (await state(page)).surfaces.find(({ name }) => name === 'bone');
  await byId('window-Lung').click();  // Bone and all else are white.
  const counts = {}, pictures = {};
  for (const lines of ['thick', 'thin', 'off']) {
    await byId('slice-lines').selectOption(lines);
    await drawn();
    counts[lines] = await near('slice-axial', color);
    pictures[lines] = await pixelsOf('slice-axial');
  }
  for (const lines of ['thick', 'thin']) {
    assert.ok(counts[lines] > 20 && counts.off < counts[lines] / 4, JSON.stringify(counts));
  }
  const changed = lines =>
    pictures[lines].filter((value, k) => value !== pictures.off[k]).length;
  assert.ok(changed('thick') > 1.2 * changed('thin'), `${changed('thick')}, ${changed('thin')}`);
  // A window that shows all as white: the inside of the skin has 35 % of its color on white.
  const skin = (await state(page)).surfaces.find(({ name }) => name === 'skin').color;
  await byId('slices-window').fill('1');
  await byId('slices-level').fill('-5000');
  await byId('slices-level').press('Enter');
  const tint = `#${[1, 3, 5].map(at => Math.round(0.65 * 255 + 0.35 *
    parseInt(skin.slice(at, at + 2), 16)).toString(16).padStart(2, '0')).join('')}`;
  const tinted = {};
  for (const lines of ['thin', 'filled']) {
    await byId('slice-lines').selectOption(lines);
    await drawn();
    tinted[lines] = await near('slice-axial', tint);
    if (lines === 'filled') await shoot(page, 'slices_filled');
  }
  assert.ok(tinted.filled > 2000 && tinted.thin < tinted.filled / 4, JSON.stringify(tinted));
  await byId('slice-lines').selectOption('off');
  await byId('window-full').click();
});

test('slices show where clip planes cut', async () => {
  await drawn();
  const slices = ['slice-axial', 'slice-coronal', 'slice-sagittal'];
  const pictures = () => Promise.all(slices.map(pixelsOf));
  const before = await pictures();
  // A plane across the patient's left and right, beside the crosshair.
  await after(page, () => say(raw, 'clip L 20'), now => now.clips.length === 1);
  await drawn();
  const cut = await pictures();
  assert.notDeepEqual(cut[0], before[0]);
  assert.notDeepEqual(cut[1], before[1]);
  assert.deepEqual(cut[2], before[2], 'the plane is parallel to the sagittal slice');
  await shoot(page, 'slices_cut');
  await after(page, () => say(raw, 'clip off'), now => now.clips.length === 0);
  await drawn();
  assert.deepEqual(await pictures(), before);
});

test('a change that slices do not show does not paint them again', async () => {
  const slices = ['slice-axial', 'slice-coronal', 'slice-sagittal'];
  await page.waitForFunction(() => [0, 1, 2].every(each =>
    document.querySelector(`[data-testid=slice-count-${each}]`).textContent !== ''));
  await drawn();
  const begin = () => page.evaluate(() => {
    globalThis.painted = {};
    for (const canvas of document.querySelectorAll('.slice-canvas')) {
      const context = canvas.getContext('2d');
      context.drawImage = function count(...image) {
        const { testid } = canvas.dataset;
        globalThis.painted[testid] = (globalThis.painted[testid] ?? 0) + 1;
        Object.getPrototypeOf(this).drawImage.apply(this, image);
      };
    }
  });
  const paintedAfter = async line => {
    await begin();
    await after(page, () => say(raw, line));
    await drawn();
    return page.evaluate(() => globalThis.painted);
  };
  try {
    assert.deepEqual(await paintedAfter('surface bone opacity=0.5'), {});
    // A clip plane may cut any of them.
    assert.deepEqual(Object.keys(await paintedAfter('clip L 20')).sort(), slices);
  } finally {
    for (const line of ['clip off', 'surface bone opacity=1']) await say(raw, line);
    await page.evaluate(() => document.querySelectorAll('.slice-canvas').forEach(canvas => {
      delete canvas.getContext('2d').drawImage;
    }));
    await settled(page);
  }
});

test('colors and square voxels', async () => {
  await byId('slice-colors').selectOption('hot');
  await drawn();
  const hot = await pixelsOf('slice-axial');
  assert.ok(hot.some((red, i) => i % 4 === 0 && red > 90 && hot[i + 1] < 20 && hot[i + 2] < 20));
  await byId('slice-colors').selectOption('gray');
  const at = await middleOf(byId('slice-axial'));
  await zoomAt({ x: at.x + 45, y: at.y - 10 }, 12);
  /** Different grays of the canvas: as many as voxels, or also those between. */
  const grays = async () => new Set((await pixelsOf('slice-axial'))
    .filter((_, i) => i % 4 === 0)).size;
  await byId('window-Soft tissue').click();
  await drawn();
  const smooth = await grays();
  await byId('slice-smooth').uncheck();
  await drawn();
  const square = await grays();
  assert.ok(smooth > square, `${smooth} grays between voxels, ${square} of voxels`);
  await shoot(page, 'slices_zoomed');
  await byId('slice-smooth').check();
  await byId('slice-whole').click();
  await byId('slice-lines').selectOption('thick');
});

test('without a pointer, the readout has the value under the crosshair', async () => {
  const stage = await middleOf(byId('stage'));
  await page.mouse.move(stage.x, stage.y);
  const text = await byId('slices-readout').innerText();
  assert.match(text, /^-?[\d.]+\s+[\s\S]*at the crosshair, voxel \d+, \d+, \d+/);
});

test('scans that are no CT begin with the window of most values', async () => {
  await after(page, () => say(raw, 'load phantom:fetus'),
              now => now.volume?.name.includes('fetus'));
  await byId('window-most').waitFor();
  assert.ok(!await byId('window-Brain').isVisible());
  const field = async id => Number(await byId(id).inputValue());
  const first = [await field('slices-window'), await field('slices-level')];
  const { minimum, maximum } = (await state(page)).volume;
  assert.ok(first[0] < maximum - minimum, `${first} of ${minimum} to ${maximum}`);
  await byId('window-full').click();
  assert.deepEqual([await field('slices-window'), await field('slices-level')],
                   [maximum - minimum, (minimum + maximum) / 2]);
  await byId('window-most').click();
  assert.deepEqual([await field('slices-window'), await field('slices-level')], first);
});
