// Slices over a slow link.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { settled } from '../steps.js';
import { slowLink } from '../video/slow_link.js';

const FAST = 1e9, SLOW = 5e6 / 8;  // Bytes per second.
const PLAIN_BYTES = 2 * 192 * 192, MOST_OF_PLAIN = 0.7;
const STEPS = 3;

useServer(['phantom:pelvis', 'resample=192x192x96']);

/** The picture of the axial slice, when it is painted. */
const painted = page => page.getByTestId('slice-axial').evaluate(canvas => new Promise(done =>
  requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL())))));

/** Counts the answers to questions, and the bytes of the largest: the axial slice has most. */
function prepare() {
  const Plain = globalThis.WebSocket;
  globalThis.answers = globalThis.answerBytes = 0;
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        take(event);
        if (view?.getUint32(0, true) === 0x4e413550) {
          globalThis.answers += 1;
          globalThis.answerBytes = Math.max(globalThis.answerBytes, event.data.byteLength);
        }
      });
    }
  };
}

/** A browser that cannot unpack gets plain slices, whatever the link. */
function withoutUnpacking() {
  delete globalThis.DecompressionStream;
}

/** Opens the slices through a link, and jumps up: nothing comes ahead of a jump. */
async function jumped(t, rate, ...scripts) {
  const link = await slowLink(server.url, rate);
  t.after(() => link.close());
  const { page, close } = await openPage(browser, link.url, { scripts: [prepare, ...scripts] });
  await page.getByTestId('tab-slices').click();
  await page.getByTestId('slices-readout').getByText('crosshair').waitFor();
  await settled(page);
  const pictures = [], bytes = [];
  for (let k = 0; k < STEPS; ++k) {
    const before = await page.evaluate(() => {
      globalThis.answerBytes = 0;
      return globalThis.answers;
    });
    const was = await painted(page);
    await page.getByTestId('slice-axial').focus();
    await page.keyboard.press('PageUp');
    await page.waitForFunction(was => globalThis.answers > was, before);
    await page.waitForFunction(was =>
      document.querySelector('[data-testid=slice-axial]').toDataURL() !== was, was);
    pictures.push(await painted(page));
    bytes.push(await page.evaluate(() => globalThis.answerBytes));
  }
  await close();
  return { pictures, bytes };
}

test('over a slow link slices have fewer bytes, and every pixel is the same', async t => {
  const packed = await jumped(t, SLOW), plain = await jumped(t, FAST, withoutUnpacking);
  assert.deepEqual(packed.pictures, plain.pictures);
  assert.equal(new Set(plain.pictures).size, STEPS);
  for (let k = 0; k < STEPS; ++k) {
    assert.ok(plain.bytes[k] > PLAIN_BYTES, `${plain.bytes}`);
    assert.ok(packed.bytes[k] < MOST_OF_PLAIN * plain.bytes[k],
              `${packed.bytes} of ${plain.bytes}`);
  }
});
