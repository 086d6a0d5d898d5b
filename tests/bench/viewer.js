// How fast the viewer follows a person, measured in the page, through tests/browser/run_test.sh:
//
//     viewer.js [--seconds N] [--size 512x512] [--volume PATH [--load OPTION].. --surface LINE..]
//         [--warp webgl|software]
//
// The volume is phantom:pelvis, or PATH with the options of `load` and surfaces that the command
// `surface` takes: --surface 'bone iso=150'. Prints a table; fails on no time, but if the picture
// at rest is another one without warp.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { setTimeout as sleep } from 'node:timers/promises';
import { parseArgs } from 'node:util';
import { launchBrowser, openPage, serve } from '../browser/harness.js';
import { browserProcesses, cpuSeconds, treeOf } from '../browser/processes.js';
import { evaluate, forget, record } from '../browser/recorder.js';
import { after, middleOf, rawSocket, say, settled, unfold } from '../browser/steps.js';

const SWING_PX = 60;         // A drag goes so far to both sides.
const SWING_S = 2;           // And takes so long there and back.
const MOVES_PER_S = 60;
const REST_MS = 500;         // After the last input the newest state must be shown, lossless.
const CORES_PERCENT = 100;
// The last two are those of a surface that is turned with warp.
const GOALS = { surfaces: 10, frames: 25, latency: 120, changes: 30, pointer: 40, volumes: 15 };
const PHANTOM = 'phantom:pelvis';

const { values: options } = parseArgs({ options: {
  seconds: { type: 'string', default: '10' },
  size: { type: 'string', default: '512x512' },
  volume: { type: 'string', default: PHANTOM },
  load: { type: 'string', multiple: true, default: [] },
  surface: { type: 'string', multiple: true, default: [] },
  warp: { type: 'string', default: '' },
} });
const seconds = Number(options.seconds);
if (!(seconds > 0)) throw new Error(`--seconds is above 0; it is ${options.seconds}`);
if (!options.volume.startsWith('phantom:') && !existsSync(options.volume)) {
  throw new Error(`--volume: ${options.volume}: no such file`);
}

/** @param {number[]} samples */
function quantile(samples, share) {
  const sorted = [...samples].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;
}

/** Drags to and fro for as long as asked, with at most MOVES_PER_S moves a second. */
async function swing(page, at, { x, y }) {
  await page.evaluate(forget);
  await page.evaluate(() => { globalThis.pxpl5.warp.pointer_ms.length = 0; });
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  const begin = performance.now();
  const moves = [];
  for (let s = 0; s < seconds; s = (performance.now() - begin) / 1000) {
    const way = Math.sin(2 * Math.PI * s / SWING_S) * SWING_PX;
    const move = page.mouse.move(at.x + x * way, at.y + y * way);
    move.catch(() => {});  // It is awaited below, and may fail before.
    moves.push(move);
    await sleep(1000 / MOVES_PER_S);
  }
  await Promise.all(moves);
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

/** Does something, and returns what it gives with its costs. */
async function costs(server, act) {
  const trees = { server: () => treeOf(server.child.pid), browser: browserProcesses };
  const cpu = () => Object.values(trees).map(pids => cpuSeconds(pids()));
  const [before, begin] = [cpu(), performance.now()];
  const given = await act();
  const wall = (performance.now() - begin) / 1000;
  const [serverCpu, browserCpu] = cpu().map((s, i) => (s - before[i]) / wall * CORES_PERCENT);
  return { ...given, serverCpu, browserCpu };
}

/** One drag with what it costs. */
async function measure(page, server, at, way) {
  const drag = await costs(server, () => swing(page, at, way));
  await settled(page);
  return drag;
}

/** Plays a time series as fast as it goes, after a turn in which its volumes are read. */
async function played(page, server) {
  const find = id => page.getByTestId(id);
  await find('cine-rate').selectOption('fast');
  const loop = find('cine-loop'), play = find('cine-play');
  await loop.uncheck();
  await play.click();
  await page.waitForFunction(() =>
    document.querySelector('[data-testid=cine-play]').title === 'Play');
  await loop.check();
  await find('cine-number').evaluate(number => {
    globalThis.volumesShown = 0;
    new MutationObserver(() => { globalThis.volumesShown += 1; })
      .observe(number, { childList: true, characterData: true, subtree: true });
  });
  return costs(server, async () => {
    await play.click();
    const begin = await page.evaluate(() => [globalThis.volumesShown, performance.now()]);
    await sleep(1000 * seconds);
    const end = await page.evaluate(() => [globalThis.volumesShown, performance.now()]);
    await play.click();
    return { rate: (end[0] - begin[0]) / (end[1] - begin[1]) * 1000 };
  });
}

/** In the page: the picture at rest, as the machine sent it and as the canvas has it. */
async function atRest() {
  const canvas = document.querySelector('[data-testid=frame]');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const hash = new Uint8Array(await crypto.subtle.digest('SHA-256', data));
  const { digest, warp } = globalThis.pxpl5;
  return { digest, pixels: [...hash].map(byte => byte.toString(16).padStart(2, '0')).join(''),
           warped: warp.warped };
}

const server = await serve(options.volume, ...options.load);
const browser = await launchBrowser();
const { page, close } = await openPage(browser, `${server.url}&warp=${options.warp}`,
                                       { script: record });
await settled(page);

/** Does a command, and waits until its picture has settled. An open socket would get frames. */
async function done(line) {
  await after(page, async () => {
    const raw = await rawSocket(page, server.url);
    const reply = await say(raw, line);
    await raw.evaluate(({ socket }) => socket.close());
    if (!reply.ok) throw new Error(`${line}: ${reply.error}`);
  });
}

await page.getByTestId('size-menu').selectOption(options.size);
await page.waitForFunction(size => globalThis.pxpl5.state.size.join('x') === size, options.size);
await settled(page);

const rows = {};
const turned = async () => measure(page, server, await middleOf(page.getByTestId('stage')),
                                   { x: 2, y: 0.5 });
if (options.volume === PHANTOM) {
  const grip = await middleOf(page.getByTestId('handle-bone').locator('.reach'));
  rows['threshold dragged'] = await measure(page, server, grip, { x: 1, y: 0 });
  rows['view turned'] = await turned();  // With the transparent skin, in two layers.
  await unfold(page);
  await page.getByTestId('warp-switch').uncheck();
  rows['view turned, warp off'] = await turned();  // In one picture, blended by the host.
  await page.getByTestId('warp-switch').check();
  await done('surface skin visible=no');
} else {
  const surfaces = () => page.evaluate(() => globalThis.pxpl5.state.surfaces);
  for (const line of options.surface) await done(`surface ${line}`);
  const wanted = options.surface.map(line => line.split(' ')[0]);
  for (const { name } of await surfaces()) {
    if (wanted.length > 0 && !wanted.includes(name)) await done(`remove ${name}`);
  }
}
const surface = await page.evaluate(() =>
  globalThis.pxpl5.state.surfaces.find(({ visible }) => visible));
if (options.volume !== PHANTOM) await unfold(page);
const subject = options.volume === PHANTOM ? surface.name : 'surfaces';
rows[`${subject} turned`] = await turned();
const withWarp = await page.evaluate(atRest);
await page.getByTestId('warp-switch').uncheck();
await done(`surface ${surface.name} visible=no`);
await done(`surface ${surface.name} visible=yes`);
const without = await page.evaluate(atRest);
rows[`${subject} turned, warp off`] = await turned();

const series = await page.evaluate(() => globalThis.pxpl5.state.volume.frames) > 1
  ? await played(page, server) : null;

const triangles = await page.evaluate(() => globalThis.pxpl5.state.surfaces
  .filter(({ visible }) => visible).map(({ triangles }) => triangles ?? NaN));
console.log(`${[options.volume, ...options.load].join(' ')}, ${options.size}, ` +
  `${triangles.join(' + ')} triangles, ${seconds} s each; CPU in percent of one core`);
console.log('| | inputs/s | new pictures/s | frames/s | canvas changes/s | ' +
  'input to picture ms: median | 95 % | pointer to screen ms: median | 95 % | ' +
  `newest after ${REST_MS} ms | lossless | CPU server | CPU browser |`);
console.log('|---|---|---|---|---|---|---|---|---|---|---|---|---|');
for (const [name, row] of Object.entries(rows)) {
  const numbers = [row.inputs, row.states, row.frames, row.changes].map(each => each / row.seconds);
  numbers.push(quantile(row.latency_ms, 0.5), quantile(row.latency_ms, 0.95),
               quantile(row.pointer_ms, 0.5), quantile(row.pointer_ms, 0.95));
  const cells = numbers.map(each => Number.isNaN(each) ? '-' : each.toFixed(1));
  console.log(`| ${[name, ...cells, row.isNewest ? 'yes' : 'no', row.isLossless ? 'yes' : 'no',
                  row.serverCpu.toFixed(0), row.browserCpu.toFixed(0)].join(' | ')} |`);
}
console.log(`goals: ${GOALS.surfaces} surfaces/s, ${GOALS.frames} frames/s, median ` +
  `${GOALS.latency} ms; with warp ${GOALS.changes} canvas changes/s, pointer to screen median ` +
  `${GOALS.pointer} ms`);
if (series) {
  console.log(`time series: ${series.rate.toFixed(1)} volumes/s, each with its picture (goal ` +
    `${GOALS.volumes}); CPU server ${series.serverCpu.toFixed(0)}, browser ` +
    `${series.browserCpu.toFixed(0)}`);
}
console.log(`at rest: digest ${withWarp.digest} with warp, ${without.digest} without`);

await close();
await browser.close();
const how = await server.stop();
if (how.code !== 0) throw new Error(`pxpl5 serve ended with ${how.code}: ${how.errors}`);
if (Object.values(rows).some(row => row.latency_ms.length === 0)) {
  throw new Error('a drag showed nothing: there is nothing to measure');
}
assert.deepEqual(withWarp, without, 'the picture at rest with warp, and without');
assert.equal(without.warped, false);
