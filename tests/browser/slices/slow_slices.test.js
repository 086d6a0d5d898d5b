// Slices over a slow link.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browser, openPage, server, useServer } from '../harness.js';
import { settled } from '../steps.js';
import { slowLink } from '../video/slow_link.js';

const FAST = 1e9, SLOW = 5e6 / 8;  // Bytes per second.
const MOST_OF_PLAIN = 0.7;

useServer(['phantom:pelvis', 'resample=192x192x96']);

/** The picture of the axial slice, when it is painted. */
const painted = page => page.getByTestId('slice-axial').evaluate(canvas => new Promise(done =>
  requestAnimationFrame(() => requestAnimationFrame(() => done(canvas.toDataURL())))));

/** Counts the answers to questions, and the bytes of the newest. */
function prepare() {
  const Plain = globalThis.WebSocket;
  globalThis.answers = 0;
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        take(event);
        if (view?.getUint32(0, true) === 0x4e413550) {
          globalThis.answers += 1;
          globalThis.answerBytes = event.data.byteLength;
        }
      });
    }
  };
}

/** Opens the slices through a link, and steps `count` slices up from the middle. */
async function stepped(t, rate, count) {
  const link = await slowLink(server.url, rate);
  t.after(() => link.close());
  const { page, close } = await openPage(browser, link.url, { script: prepare });
  await page.getByTestId('tab-slices').click();
  await page.getByTestId('slices-readout').getByText('crosshair').waitFor();
  await settled(page);
  const pictures = [], bytes = [];
  for (let k = 0; k < count; ++k) {
    const before = await page.evaluate(() => globalThis.answers);
    const was = await painted(page);
    await page.getByTestId('slice-axial').focus();
    await page.keyboard.press(']');
    await page.waitForFunction(was => {
      const canvas = document.querySelector('[data-testid=slice-axial]');
      return canvas.toDataURL() !== was;
    }, was);
    if (k > 0) await page.waitForFunction(was => globalThis.answers > was, before);
    pictures.push(await painted(page));
    bytes.push(await page.evaluate(() => globalThis.answerBytes));
  }
  return { page, close, pictures, bytes };
}

test('over a slow link slices have fewer bytes, and every pixel is the same', async t => {
  const slow = await stepped(t, SLOW, 3);
  await slow.close();
  const fast = await stepped(t, FAST, 3);
  await fast.close();
  assert.deepEqual(slow.pictures, fast.pictures);
  assert.equal(new Set(fast.pictures).size, 3);
  assert.ok(slow.bytes[2] < MOST_OF_PLAIN * fast.bytes[2], `${slow.bytes} of ${fast.bytes}`);
});
