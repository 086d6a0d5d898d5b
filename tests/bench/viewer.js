// How fast the viewer follows a person, measured in the page: `viewer.js [--seconds N]`, through
// tests/browser/run_test.sh. Prints a table; fails on no time.
import { launchBrowser, openPage, serve } from '../browser/harness.js';
import { browserProcesses, cpuSeconds, treeOf } from '../browser/processes.js';
import { evaluate, forget, record } from '../browser/recorder.js';
import { after, middleOf, settled, unfold } from '../browser/steps.js';

const PICTURE = '512x512';
const SWING_PX = 60;         // A drag goes so far to both sides.
const SWING_S = 2;           // And takes so long there and back.
const REST_MS = 500;         // After the last input the newest state must be shown, lossless.
const CORES_PERCENT = 100;
const GOALS = { surfaces: 10, frames: 25, latency: 120 };

const seconds = Number(/--seconds[ =](\d+)/.exec(process.argv.slice(2).join(' '))?.[1] ?? 10);

/** @param {number[]} samples */
function quantile(samples, share) {
  const sorted = [...samples].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;
}

/** Drags to and fro for as long as asked, as fast as the browser takes moves. */
async function swing(page, at, { x, y }) {
  await page.evaluate(forget);
  await page.evaluate(() => { globalThis.pxpl5.warp.pointer_ms.length = 0; });
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const begin = performance.now();
  for (let s = 0; s < seconds; s = (performance.now() - begin) / 1000) {
    const way = Math.sin(2 * Math.PI * s / SWING_S) * SWING_PX;
    await page.mouse.move(at.x + x * way, at.y + y * way);
  }
  const rest = await page.evaluate(rested, REST_MS);
  await page.mouse.up();
  const pointer_ms = await page.evaluate(() => globalThis.pxpl5.warp.pointer_ms);
  return { ...await page.evaluate(evaluate), ...rest, pointer_ms };
}

/** In the page: what is shown so long after the last input. */
function rested(rest_ms) {
  const due = globalThis.recorded.inputs.at(-1) + rest_ms;
  return new Promise(resolve => setTimeout(() => {
    const { state, revision, rests } = globalThis.pxpl5;
    resolve({ isNewest: revision === state.revision, isLossless: rests });
  }, due - performance.now()));
}

/** One drag with what it costs. */
async function measure(page, server, at, way) {
  const trees = { server: () => treeOf(server.child.pid), browser: browserProcesses };
  const cpu = () => Object.values(trees).map(pids => cpuSeconds(pids()));
  const [before, begin] = [cpu(), performance.now()];
  const drag = await swing(page, at, way);
  const wall = (performance.now() - begin) / 1000;
  const [serverCpu, browserCpu] = cpu().map((s, i) => (s - before[i]) / wall * CORES_PERCENT);
  await settled(page);
  return { ...drag, serverCpu, browserCpu };
}

const server = await serve('phantom:pelvis');
const browser = await launchBrowser();
const { page, close } = await openPage(browser, server.url, { script: record });
await settled(page);
await page.getByTestId('size-menu').selectOption(PICTURE);
await page.waitForFunction(size => globalThis.pxpl5.state.size.join('x') === size, PICTURE);
await settled(page);

const rows = {};
const grip = await middleOf(page.getByTestId('handle-bone').locator('.reach'));
rows['threshold dragged'] = await measure(page, server, grip, { x: 1, y: 0 });
const turned = async () => measure(page, server, await middleOf(page.getByTestId('stage')),
                                   { x: 2, y: 0.5 });
rows['view turned'] = await turned();
// Without the transparent skin, the page follows the pointer between two pictures.
await unfold(page);
await after(page, () => page.getByTestId('surface-visible-skin').uncheck());
rows['bone turned'] = await turned();
await page.getByTestId('warp-switch').uncheck();
rows['bone turned, warp off'] = await turned();

console.log(`phantom:pelvis, ${PICTURE}, ${seconds} s each; CPU in percent of one core`);
console.log('| | new pictures/s | frames/s | input to picture ms: median | 95 % | ' +
  `pointer to screen ms: median | 95 % | newest after ${REST_MS} ms | lossless | CPU server | ` +
  'CPU browser |');
console.log('|---|---|---|---|---|---|---|---|---|---|---|');
for (const [name, row] of Object.entries(rows)) {
  const numbers = [row.states / row.seconds, row.frames / row.seconds,
                  quantile(row.latency_ms, 0.5), quantile(row.latency_ms, 0.95),
                  quantile(row.pointer_ms, 0.5), quantile(row.pointer_ms, 0.95)];
  const cells = numbers.map(each => Number.isNaN(each) ? '-' : each.toFixed(1));
  console.log(`| ${[name, ...cells, row.isNewest ? 'yes' : 'no', row.isLossless ? 'yes' : 'no',
                  row.serverCpu.toFixed(0), row.browserCpu.toFixed(0)].join(' | ')} |`);
}
console.log(`goals: ${GOALS.surfaces} surfaces/s, ${GOALS.frames} frames/s, median ` +
  `${GOALS.latency} ms`);

await close();
await browser.close();
const how = await server.stop();
if (how.code !== 0) throw new Error(`pxpl5 serve ended with ${how.code}: ${how.errors}`);
if (Object.values(rows).some(row => row.latency_ms.length === 0)) {
  throw new Error('a drag showed nothing: there is nothing to measure');
}
