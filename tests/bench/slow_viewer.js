// How long a person waits over a slow link, measured in the page, through
// tests/browser/run_test.sh:
//
//     slow_viewer.js [--mbit 5] [--rtt-ms 100] [--volume PATH] [--load OPTION]..
//
// The volume is phantom:pelvis with slices of 512 x 512, or PATH with options of `load`. Prints a
// table; fails on no time.
import { parseArgs } from 'node:util';
import { launchBrowser, openPage, serve } from '../browser/harness.js';
import { settled } from '../browser/steps.js';
import { slowLink } from '../browser/video/slow_link.js';

const STEPS = 9;
const BITS = 8, MEGA = 1e6, KILO = 1000;
const GOALS = { page_kb: 180, requests: 20, first_ms: 1500, step_ms: 300 };

const { values: options } = parseArgs({ options: {
  mbit: { type: 'string', default: '5' },
  'rtt-ms': { type: 'string', default: '100' },
  volume: { type: 'string', default: 'phantom:pelvis' },
  load: { type: 'string', multiple: true, default: [] },
} });
const phantom = options.volume.startsWith('phantom:') && options.load.length === 0;
const load = phantom ? ['resample=512x512x96'] : options.load;

/** Runs in the page before its own code: notes when the first picture is on the screen. */
function noteFirst() {
  const look = () => {
    if (globalThis.pxpl5?.frames > 0) globalThis.firstAt = performance.now();
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

/** Runs in the page: the files of the page, as they were sent. */
function filesOf() {
  const files = [...performance.getEntriesByType('navigation'),
                 ...performance.getEntriesByType('resource')];
  return { count: files.length,
           bytes: files.reduce((sum, { transferSize }) => sum + transferSize, 0) };
}

/** Presses a key on the axial slice; milliseconds until the slice is painted. */
async function stepped(page, key) {
  await page.evaluate(() => {
    globalThis.stepMs = new Promise(done => {
      document.addEventListener('keydown', ({ timeStamp }) => {
        document.addEventListener('sliceshown', () => requestAnimationFrame(
          () => done(performance.now() - timeStamp)), { once: true });
      }, { once: true, capture: true });
    });
  });
  await page.keyboard.press(key);
  return page.evaluate(() => globalThis.stepMs);
}

/** Several steps, each after the one before has come to rest. */
async function steps(page, key) {
  const all = [];
  for (let k = 0; k < STEPS; ++k) {
    all.push(await stepped(page, key));
    await settled(page);
  }
  return { first: all[0], median: all.slice(1).sort((a, b) => a - b)[(STEPS - 1) >> 1] };
}

const server = await serve(options.volume, ...load);
const browser = await launchBrowser();
const link = await slowLink(server.url, Number(options.mbit) * MEGA / BITS,
                            Number(options['rtt-ms']) / 2);
const { page, close } = await openPage(browser, link.url, { script: noteFirst });
await settled(page);
const files = await page.evaluate(filesOf);
const first_ms = await page.evaluate(() => globalThis.firstAt);
await page.getByTestId('tab-slices').click();
await page.getByTestId('slices-readout').getByText('crosshair').waitFor();
await settled(page);
await page.getByTestId('slice-axial').focus();
const far = await steps(page, 'PageUp'), near = await steps(page, '[');

const ms = time => time.toFixed(0);
console.log(`${[options.volume, ...load].join(' ')}; ${options.mbit} Mbit/s, ` +
  `${options['rtt-ms']} ms there and back`);
console.log(`| | measured | goal |
|---|---|---|
| files of the page | ${files.count} | under ${GOALS.requests} |
| their size, kB | ${(files.bytes / KILO).toFixed(0)} | under ${GOALS.page_kb} |
| first picture after, ms | ${ms(first_ms)} | ${GOALS.first_ms} |
| slice after a jump, ms: first, median of the others | ${ms(far.first)}, ${ms(far.median)} | ${
  GOALS.step_ms} |
| slice after a step, ms: first, median of the others | ${ms(near.first)}, ${ms(near.median)} | ${
  GOALS.step_ms} |`);
await close();
await browser.close();
link.close();
const how = await server.stop();
if (how.code !== 0) throw new Error(`pxpl5 serve ended with ${how.code}: ${how.errors}`);
