// Tests of warped pictures: stops the machine, and compares screenshots.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { byId, server, shoot } from '../harness.js';
import { treeOf } from '../processes.js';
import { after, say, settled } from '../steps.js';

export const LEAST_PSNR_DB = 28;  // A warped picture 5 degrees aside, in means of 4 x 4 pixels.
const LEAST_GAIN_DB = 5;          // Over the picture as it was.
const MOST_UNKNOWN = 0.08;        // Share of the surface that only the exact picture shows.
export const MOST_UNLIKE = 0.005; // Share of pixels in which painters differ: mostly at edges.
const TRIES = 40;         // On a busy computer, most frames of one sample are replaced.

/** The processes of the GPs. */
function gps() {
  return treeOf(server.child.pid).filter(pid =>
    readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0')[0].endsWith('pxpl5-gp'));
}

/** Stops the GPs, so that the machine draws nothing, until `act` is done. */
export async function whileStopped(act) {
  const stopped = gps();
  if (stopped.length === 0) throw new Error('the server has no GPs');
  for (const pid of stopped) process.kill(pid, 'SIGSTOP');
  try {
    return await act();
  } finally {
    for (const pid of stopped) process.kill(pid, 'SIGCONT');
  }
}

/**
 * Shows a view; returns the number of the frame of one sample that a page has kept. A refinement
 * may have taken the place of the frame before it was sent: then the view is shown again.
 */
export async function keptOf(raw, keeping, view) {
  for (let tries = 0; tries < TRIES; tries++) {
    await after(keeping, () => say(raw, 'view 200 40'));
    const { revision } = await after(keeping, () => say(raw, view));
    const index = await keeping.evaluate(revision =>
      globalThis.kept.findIndex(each => each.revision === revision), revision);
    if (index >= 0) return index;
  }
  throw new Error(`${view}: no frame of one sample was sent in ${TRIES} tries`);
}

/**
 * Checks a warped picture beside the exact one.
 * @param t      The test.
 * @param found  Result of comparePictures() of one painter.
 */
export function checkWarped(t, name, found) {
  t.diagnostic(`${name}: ${found.warped_db.toFixed(1)} dB, as it was ` +
    `${found.late_db.toFixed(1)} dB; unknown ${(100 * found.unknown).toFixed(2)} %; ` +
    `of ${found.bytes} bytes ${found.depth_bytes} are depths; ` +
    `other painter: ${(100 * found.unlike).toFixed(2)} % differ`);
  assert.ok(found.warped_db >= LEAST_PSNR_DB, `${name}: ${found.warped_db} dB`);
  assert.ok(found.warped_db >= found.late_db + LEAST_GAIN_DB,
            `${name}: ${found.warped_db} dB, as it was ${found.late_db} dB`);
  assert.ok(found.unknown < MOST_UNKNOWN, `${name}: ${found.unknown} are unknown`);
  assert.ok(found.unlike < MOST_UNLIKE, `${name}: the painters differ in ${found.unlike}`);
  assert.ok(found.shown > 10 && found.elsewhere <= 0.02 * found.shown,
            `${name}: of ${found.shown} pixels ${found.elsewhere} show another place`);
}

/** The PSNR of two screenshots of one element, in means of 4 x 4 pixels. */
export function similarity(page, ...screenshots) {
  return page.evaluate(async files => {
    const [a, b] = await Promise.all(files.map(async file => {
      const bytes = Uint8Array.from(atob(file), each => each.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]));
      // Scaled down by 4, each pixel is the mean of 16.
      const [width, height] = [bitmap.width, bitmap.height].map(px => Math.floor(px / 4));
      const context = new OffscreenCanvas(width, height).getContext('2d');
      context.drawImage(bitmap, 0, 0, 4 * width, 4 * height, 0, 0, width, height);
      return context.getImageData(0, 0, width, height).data;
    }));
    const sum = a.reduce((total, value, k) => total + (value - b[k]) ** 2, 0);
    return 10 * Math.log10(255 * 255 * a.length / sum);
  }, screenshots.map(each => each.toString('base64')));
}

/**
 * Drags from a place while the machine is stopped.
 * @param at    Client coordinates.
 * @param name  Of a screenshot of the warped picture; '' for none.
 * @returns the PSNR of the warped picture and of the late one, beside the exact one
 */
export async function warpedAndLate(page, at, name = '') {
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const late = await byId('stage').screenshot();
  const warped = await whileStopped(async () => {
    await page.mouse.move(at.x + 9, at.y + 5);
    await page.waitForFunction(() => globalThis.pxpl5.warp.warped);
    if (name) await shoot(page, name);
    return byId('stage').screenshot();
  });
  await page.waitForFunction(() => !globalThis.pxpl5.warp.warped);
  await settled(page);
  const exact = await byId('stage').screenshot();
  await page.mouse.up();
  return { found: await similarity(page, warped, exact),
           before: await similarity(page, late, exact) };
}

/** The pixels of the picture's canvas, as text. */
export function pixelsOf(page) {
  return page.getByTestId('frame').evaluate(async canvas => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const digest = await crypto.subtle.digest('SHA-256', data);
    return `${canvas.width} ${canvas.height} ${new Uint8Array(digest).join()}`;
  });
}
