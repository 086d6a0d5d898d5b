// Stereo pictures in the page: their size and place, marks, and clicks in both eyes.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, byId, openPage, page, server, shoot, usePage } from '../harness.js';
import { after, say, settled, socketWithoutSkin, state, unfold } from '../steps.js';

const SEED = Number(process.env.PXPL5_SEED ?? '1993');
const NEAR_PX = 1.5;        // From a click to its mark: the click is within a pixel.
const SAME_MM = 3;          // Between the points that two clicks on one place mean.
const CAMERA_PX = 0.02;     // Of a picked point, from the center of its pixel.

let raw;

usePage(['phantom:pelvis', 'resample=96x96x72'], async () => {
  raw = await socketWithoutSkin(page, server.url);
});

/** Sets stereo and waits until the picture of this page's size rests. */
async function stereo(page, words) {
  await after(page, () => say(raw, `stereo ${words}`));
  const parts = /^(sbs|cross)/.test(words) ? 2 : 1;
  // Another page may have set a size.
  await page.evaluate(() => dispatchEvent(new Event('focus')));
  await page.waitForFunction(parts => {
    const { width, height } = document.querySelector('#stage').getBoundingClientRect();
    const [across, down] = globalThis.pxpl5.state.size;
    return Math.abs(across * parts - width * devicePixelRatio) < 5 &&
      Math.abs(down - height * devicePixelRatio) < 5;
  }, parts);
  return settled(page);
}

/** The canvas of the picture: its pixels, and its box in CSS pixels. */
function canvasOf(page) {
  return byIdOf(page, 'frame').evaluate(canvas => {
    const { left, top, width, height } = canvas.getBoundingClientRect();
    return { across: canvas.width, down: canvas.height, left, top, width, height };
  });
}

const byIdOf = (page, id) => page.getByTestId(id);

/** Where the marks of the crosshair are on the screen, by eye from left to right. */
async function crosshairs(count) {
  const marks = ['crosshair', 'crosshair-2'].slice(0, count);
  const boxes = [];
  for (const mark of marks) {
    const { x, y, width, height } = await byId(mark).boundingBox();
    boxes.push({ x: x + width / 2, y: y + height / 2,
                 name: await byId(mark).getAttribute('class') });
  }
  return boxes;
}

/**
 * A place on the screen, in the left part of the picture, where the pixels around show the bone.
 * @param {number} x  Shares of the picture, where the search begins.
 * @param {number} y
 */
async function onBone(x, y) {
  const { left, top, width, height } = await canvasOf(page);
  for (; y < 0.9; y += 0.03) {
    const at = { x: Math.round(left + width * x), y: Math.round(top + height * y) };
    const pixel = [at.x - left, at.y - top].map(Math.round);
    const hits = [];
    for (const step of [-6, 0, 6]) {
      hits.push((await say(raw, `pick ${pixel[0] + step} ${pixel[1]}`)).result.hit);
    }
    if (hits.every(Boolean)) return at;
  }
  throw new Error(`no bone below ${x} ${y}`);
}

/** Clicks a place and waits until the crosshair is elsewhere. */
async function click({ x, y }) {
  const before = await byId('crosshair').getAttribute('transform');
  await page.mouse.click(x, y);
  await page.waitForFunction(before => document.querySelector('[data-testid=crosshair]')
    .getAttribute('transform') !== before, before);
  const text = await byId('pointed').textContent();
  const [, ...mm] = /at ([\d.]+) ([LR]), ([\d.]+) ([AP]), ([\d.]+) ([SI])/.exec(text);
  return [0, 2, 4].map(k => Number(mm[k]) * ('LPS'.includes(mm[k + 1]) ? 1 : -1));
}

test('side by side, each picture has its proportions, letters and scale, and fits the panel',
     async () => {
  await say(raw, 'view 20 15 fit=yes');
  for (const mode of ['sbs', 'cross']) {
    await stereo(page, mode);
    const { size } = await state(page);
    const canvas = await canvasOf(page), stage = await byId('stage').boundingBox();
    assert.deepEqual([canvas.across, canvas.down], [2 * size[0], size[1]]);
    assert.deepEqual([canvas.width, canvas.height], [2 * size[0], size[1]], 'pixel by pixel');
    assert.ok(stage.width - canvas.width < 5 && stage.height - canvas.height < 3);
    const bars = [];
    for (const id of ['scale-bar', 'scale-bar-2']) bars.push(await byId(id).boundingBox());
    assert.ok(Math.abs(bars[0].width - bars[1].width) < 0.1);
    assert.ok(Math.abs(bars[1].x - bars[0].x - size[0]) < 1, JSON.stringify(bars));
    const letters = await byId('overlay').locator('.side:visible').allTextContents();
    assert.deepEqual(letters.slice(0, 4), letters.slice(4));
    assert.match(await byId('badge-size').textContent(), new RegExp(`^${2 * size[0]} × `));
    await shoot(page, `stereo-${mode}`);
  }
});

test('a click means what the clicked eye sees, and the marks lie there in both eyes', async () => {
  const separations = [];
  for (const mode of ['sbs', 'cross', 'anaglyph']) {
    await stereo(page, `${mode} separation=60`);
    const { width } = await canvasOf(page);
    const wide = mode !== 'anaglyph';
    const at = await onBone(0.2, 0.1);
    const first = await click({ x: at.x, y: at.y });
    const eyes = await crosshairs(2);
    assert.ok(Math.hypot(eyes[0].x - at.x, eyes[0].y - at.y) < NEAR_PX,
              `${mode}: ${JSON.stringify([at, eyes])}`);
    assert.match(eyes[0].name, mode === 'cross' ? /eye-right/ : /eye-left/);
    assert.match(eyes[1].name, mode === 'cross' ? /eye-left/ : /eye-right/);
    assert.ok(Math.abs(eyes[0].y - eyes[1].y) < 0.01, 'no vertical parallax');
    if (!wide) continue;
    separations.push(eyes[1].x - eyes[0].x - width / 2);
    await click(await onBone(0.3, 0.3));
    const second = await click({ x: Math.round(eyes[1].x), y: Math.round(eyes[1].y) });
    const apart = Math.hypot(...first.map((mm, k) => mm - second[k]));
    assert.ok(apart < SAME_MM, `${mode}: ${first} and ${second}`);
    await shoot(page, `stereo-click-${mode}`);
  }
  const [parallel, crossed] = separations;
  assert.ok(parallel * crossed < 0, `parallaxes ${separations}`);
});

test('a distance is drawn for both eyes', async () => {
  await stereo(page, 'sbs separation=60');
  await byId('tab-measure').click();
  await byId('measure-mode').click();
  const [a, b] = [await onBone(0.3, 0.3), await onBone(0.2, 0.1)];
  await page.mouse.click(a.x, a.y);
  await byId('measure-message').getByText('Click the second point.').waitFor();
  await page.mouse.click(b.x, b.y);
  await byId('measure-list').getByText('mm').waitFor();
  await page.keyboard.press('Escape');
  const texts = await byId('measure-lines').locator('text').allTextContents();
  assert.equal(texts.length, 2);
  assert.equal(texts[0], texts[1]);
  await shoot(page, 'stereo-measure');
  await byId('measure-delete-1').click();
});

test('the page and the server have the same eyes', async () => {
  let random = SEED;
  const next = (least, most) => {
    random = (random * 1103515245 + 12345) % 2147483648;
    return least + (most - least) * random / 2147483648;
  };
  let hits = 0;
  for (let i = 0; i < 12; i++) {
    const eyes = i % 3 === 0 ? '' :
      ` separation=${next(5, 90).toFixed(1)} convergence=${next(300, 1500).toFixed(1)}`;
    const mode = i % 2 === 0 ? 'sbs' : 'cross';
    await say(raw, `stereo ${mode}${eyes}`);
    const { revision } = await say(raw, `view ${next(0, 360).toFixed(2)} ` +
      `${next(-60, 60).toFixed(2)} roll=${next(-90, 90).toFixed(2)} ` +
      `zoom=${next(0.5, 3).toFixed(4)} ` +
      `pan=${next(-20, 20).toFixed(2)},${next(-20, 20).toFixed(2)}`);
    await page.waitForFunction(wanted => globalThis.pxpl5.state.revision >= wanted, revision);
    const { size } = await state(page);
    for (let k = 0; k < 9; k++) {
      const pixel = { x: Math.floor(next(0, 2 * size[0])), y: Math.floor(next(0, size[1])) };
      const { result } = await say(raw, `pick ${pixel.x} ${pixel.y}`);
      if (!result.hit) continue;
      ++hits;
      const place = await page.evaluate(async ([pixel, p_mm]) => {
        const load = name => import(new URL(name, location.href).href);
        const { camerasAt } = await load('picture/camera.js');
        const { projectToPicture } = await load('picture/projection.js');
        const { partsOf, stereoOf } = await load('picture/stereo.js');
        const { state } = globalThis.pxpl5, [width, height] = state.size;
        const side = Math.floor(pixel.x / width);
        const cameras = camerasAt(state.camera, state.camera, width / height, stereoOf(state));
        const eye = partsOf(state.stereo)[side].eyes[0];
        const { x, y } = projectToPicture(cameras[eye].patient_to_clip, p_mm, width, height);
        return { x: x + side * width - 0.5, y: y - 0.5 };
      }, [pixel, result.p_mm]);
      const off = Math.hypot(place.x - pixel.x, place.y - pixel.y);
      assert.ok(off < CAMERA_PX, `${mode}${eyes}: ${JSON.stringify([pixel, place])}`);
    }
  }
  assert.ok(hits > 12, `${hits} points`);
});

/** The pixels of the picture in a screenshot of the page, beside those of the canvas. */
function compareScreen(page, screenshot) {
  return page.evaluate(async file => {
    const bytes = Uint8Array.from(atob(file), each => each.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const canvas = document.querySelector('#frame');
    const box = canvas.getBoundingClientRect();
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    const screen = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    const [dx, dy] = [box.left, box.top].map(css => css * devicePixelRatio);
    // The browser moves the canvas and its parents to whole pixels.
    let best = Infinity, at = null;
    for (const x of [-1, 0, 1, 2].map(step => Math.floor(dx) + step)) {
      for (const y of [-1, 0, 1, 2].map(step => Math.floor(dy) + step)) {
        let differing = 0;
        for (let row = 8; row + 8 < canvas.height; ++row) {
          for (let column = 8; column + 8 < canvas.width; column += 3) {
            if (row + y < 0 || row + y >= bitmap.height || column + x < 0 ||
                column + x >= bitmap.width) continue;
            const a = 4 * (row * canvas.width + column);
            const b = 4 * ((row + y) * bitmap.width + column + x);
            differing += [0, 1, 2].some(k => pixels[a + k] !== screen[b + k]) ? 1 : 0;
          }
        }
        [best, at] = differing < best ? [differing, { x, y }] : [best, at];
      }
    }
    return { differing: best, at, rows: canvas.height, screen: bitmap.height };
  }, screenshot.toString('base64'));
}

test('alternate rows are shown pixel by pixel, on screens of any resolution', async () => {
  await stereo(page, 'rows');  // A page that opens has a size for one picture.
  for (const [scale, width, height] of [[1, 1203, 701], [1.25, 1000, 601], [1.5, 901, 603]]) {
    const other = await openPage(browser, server.url,
                                 { viewport: { width, height }, deviceScaleFactor: scale });
    await other.page.evaluate(() => {
      for (const each of document.querySelectorAll('#stage > :not(canvas)')) {
        each.style.display = 'none';
      }
    });
    await stereo(other.page, `rows separation=${50 + scale}`);
    const { differing, rows, at } =
      await compareScreen(other.page, await other.page.screenshot());
    assert.equal(differing, 0, `${scale}: ${differing} pixels differ at ${JSON.stringify(at)}`);
    assert.ok(rows > 300);
    assert.equal(await other.page.getByTestId('cut').isVisible(), false);
    await other.close();
  }
});

test('alternate rows that are larger than the panel are cut and not scaled, and the page says so',
     async () => {
  await stereo(page, 'rows');
  await byId('size-menu').selectOption('1280x1024');
  await page.waitForFunction(() => globalThis.pxpl5.state.size[0] === 1280);
  await settled(page);
  const { width, height, across, down } = await canvasOf(page);
  assert.deepEqual([across, down, width, height], [1280, 1024, 1280, 1024]);
  assert.match(await byId('cut').textContent(), /never scaled, so its edges are hidden/);
  assert.ok(await byId('cut').isVisible());
  await shoot(page, 'stereo-cut');
  await byId('size-menu').selectOption('');
  await byId('cut').waitFor({ state: 'hidden' });
});

test('the menu has all modes', async () => {
  await unfold(page);
  await after(page, () => byId('stereo').selectOption('cross'));
  assert.equal((await state(page)).stereo, 'cross');
  await after(page, () => byId('stereo').selectOption('off'));
  assert.equal((await state(page)).stereo, 'off');
});
