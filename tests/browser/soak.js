// Uses everything again and again and watches memory, descriptors, threads and processes:
// PXPL5_SOAK is "MINUTES [GPS RENDERERS]". For the last quarter of the time the machine has so many
// GPs and Renderers more: with "60 30 18" it ends with 54 nodes. Fails if anything grows beyond its
// bound after a first round, which fills caches, or if a process of the server grows in the second
// half of either machine's time.
import { launchBrowser, openPage, serve } from './harness.js';
import { browserProcesses, holdings, memoryMib, treeOf } from './processes.js';
import { drag, middleOf, rawSocket, say, settled, state } from './steps.js';

// The flight recorders use 64 MiB of the server's memory, which they fill in the first minutes.
const MAY_GROW_MIB = { server: 96, browser: 48, heap: 8 };
// Bounds of the page: a removed surface that something still refers to is 101 elements and 12
// listeners. Messages and the axis of the histogram come and go.
const MAY_GROW_COUNT = { nodes: 150, listeners: 8 };
// The bounds of one process. The C library's allocator keeps and returns pages as it likes.
const PROCESS_MAY_GROW = { mib: 12, descriptors: 0, threads: 0 };
// A short run compares with its start. Recorders still fill, and some descriptors come late.
const PROCESS_MAY_GROW_AT_FIRST = { descriptors: 4, threads: 1 };
const RECORDERS_FULL_MIN = 20;
const S_PER_MIN = 60;
const DESCRIPTORS_REST_MS = 20_000, POLL_MS = 100;

const wish = process.env.PXPL5_SOAK ?? '0.3 2 1';
const [minutes, gps = 0, renderers = 0] = wish.split(' ').map(Number);
if (!(minutes > 0 && gps >= 0 && renderers >= 0)) {
  throw new Error(`PXPL5_SOAK is '${wish}', must be minutes, GPs and Renderers, as 60 30 18`);
}

const server = await serve('phantom:pelvis', 'resample=128x128x64');
const browser = await launchBrowser();
const { page, context, close } = await openPage(browser, server.url);
const session = await context.newCDPSession(page);
await session.send('Performance.enable');
const raw = await rawSocket(page, server.url);
const byId = id => page.getByTestId(id);

/** Does a command; one that fails ends the run. */
async function command(line) {
  const reply = await say(raw, line);
  if (!reply.ok) throw new Error(`${line}: ${reply.error}`);
}

async function swing(locator, x, y) {
  const at = await middleOf(locator);
  await drag(page, at, { x: at.x + x, y: at.y + y }, { steps: 30 });
}

/** A second person looks in and leaves. */
async function watch() {
  const watcher = await openPage(browser, server.watchUrl);
  await settled(watcher.page);
  await watcher.close();
}

const activities = {
  turn: () => swing(byId('stage'), 80, 20),
  threshold: async () => {
    await swing(byId('handle-bone').locator('.reach'), 15, 0);
    await swing(byId('handle-bone').locator('.reach'), -15, 0);
  },
  clip: async () => {
    for (const line of ['clip L', 'clip L 20', 'clip off']) await command(line);
  },
  surface: async () => {
    for (const line of ['surface fat preset=fat opacity=0.5', 'components bone show=largest',
                       'components bone show=all', 'certificate bone', 'remove fat']) {
      await command(line);
    }
  },
  looks: async () => {
    for (const line of ['light 1 30 30', 'material specular=0.1', 'background #102030', 'undo',
                       'undo', 'redo', 'view anterior']) {
      await command(line);
    }
  },
  panels: async () => {
    for (const tab of ['machine', 'inspector', 'volume', 'slices']) {
      await byId(`tab-${tab}`).click();
    }
    await byId('slice-axial').hover();
    for (let i = 0; i < 10; i++) await page.mouse.wheel(0, i < 5 ? 100 : -100);
  },
  ask: async () => {
    const [width, height] = (await state(page)).size.map(each => Math.floor(each / 2));
    for (const line of [`pick ${width} ${height}`, `why ${width} ${height}`, 'histogram',
                       'history', 'activity', 'snapshot download:soak.png',
                       'export download:soak.stl']) {
      await command(line);
    }
  },
  load: () => command('load phantom:pelvis resample=128x128x64'),
  watch,
};

/** In the page: the socket of this script keeps nothing of what it has heard. */
function forget(socket) {
  socket.states.length = 0;
  socket.frames.length = 0;
}

/** One round of everything; ends with the newest picture on the screen. */
async function round() {
  for (const act of Object.values(activities)) await act();
  await settled(page);
  await raw.evaluate(forget);
}

/**
 * What the processes hold, at the first moment when none has more descriptors than before. A
 * connection or a file may be open for a moment: a leak stays, and is found when the time is over.
 * @param {Map | undefined} before  An earlier sample's.
 */
async function restingHoldings(processes, before) {
  const begin = performance.now();
  for (;;) {
    const now = holdings(processes);
    const isMore = ([pid, { descriptors }]) =>
      descriptors > (before?.get(pid)?.descriptors ?? Infinity);
    if (![...now].some(isMore) || performance.now() - begin > DESCRIPTORS_REST_MS) return now;
    await new Promise(done => setTimeout(done, POLL_MS));
  }
}

async function sample(name, before) {
  // Else the browser keeps decoded pictures in a cache of hundreds of MiB.
  await session.send('Memory.simulatePressureNotification', { level: 'critical' });
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  const { metrics } = await session.send('Performance.getMetrics');
  const count = key => metrics.find(({ name }) => name === key).value;
  const processes = treeOf(server.child.pid);
  const holds = await restingHoldings(processes, before?.holds);
  const most = key => Math.max(...[...holds.values()].map(each => each[key]));
  const one = { name, server: memoryMib(processes), browser: memoryMib(browserProcesses()),
              heap: usedSize / 2 ** 20, nodes: count('Nodes'),
              listeners: count('JSEventListeners'), processes: processes.length, holds };
  console.log(`| ${name} | ${minutesPassed().toFixed(1)} | ${one.server.toFixed(1)} | ` +
    `${one.browser.toFixed(1)} | ${one.heap.toFixed(2)} | ${one.nodes} | ` +
    `${one.listeners} | ${one.processes} | ` +
    `${most('mib').toFixed(1)} | ${most('descriptors')} | ${most('threads')} |`);
  return one;
}

/** Rounds until `end` minutes have passed; samples at the start, in the middle and at the end. */
async function use(name, end) {
  await round();
  await round();
  const samples = [await sample(`${name}, start`)];
  const half = (minutesPassed() + end) / 2;
  do {
    await round();
    rounds += 1;
    if (samples.length === 1 && minutesPassed() >= half) {
      samples.push(await sample(`${name}, half`, samples[0]));
    }
  } while (minutesPassed() < end);
  samples.push(await sample(`${name}, end`, samples.at(-1)));
  return samples;
}

const listed = kinds => [...kinds].map(([kind, count]) => `${count} ${kind}`).join(', ');

/** What grew too much between the samples of one machine. */
function growth(samples) {
  const [start, end] = [samples[0], samples.at(-1)];
  const isShort = minutes < RECORDERS_FULL_MIN;
  const earlier = isShort ? start : samples.at(-2);
  const faults = Object.entries(MAY_GROW_MIB)
    .filter(([name, most]) => end[name] - start[name] > most)
    .map(([name, most]) => `${end.name}: ${name} grew by ${(end[name] - start[name]).toFixed(1)} ` +
      `MiB, ${most} are allowed`);
  for (const [name, most] of Object.entries(MAY_GROW_COUNT)) {
    if (end[name] - start[name] > most) {
      faults.push(`${end.name}: the page had ${start[name]} ${name} at the start, now ` +
        `${end[name]}; ${most} more are allowed`);
    }
  }
  if (end.processes !== start.processes) {
    faults.push(`${end.name}: ${start.processes} processes at the start, ${end.processes} now`);
  }
  for (const [pid, now] of end.holds) {
    const then = earlier.holds.get(pid);
    const bounds = isShort ? PROCESS_MAY_GROW_AT_FIRST : PROCESS_MAY_GROW;
    for (const [key, most] of Object.entries(then ? bounds : {})) {
      if (now[key] - then[key] > most) {
        const kinds = `; before ${listed(then.kinds)}; now ${listed(now.kinds)}`;
        faults.push(`${end.name}: ${now.name} (${pid}) had ${then[key]} ${key} in the sample ` +
          `'${earlier.name}', now ${now[key]}${key === 'descriptors' ? kinds : ''}`);
      }
    }
  }
  return faults;
}

const begin = performance.now();
const minutesPassed = () => (performance.now() - begin) / 1000 / S_PER_MIN;
let rounds = 0;
console.log('| sample | minutes | server MiB | browser MiB | page heap MiB | nodes | listeners | ' +
  'processes | most MiB of a process | most descriptors | most threads |');
console.log('|---|---|---|---|---|---|---|---|---|---|---|');
const faults = growth(await use('usual', gps ? minutes * 3 / 4 : minutes));
if (gps) {
  await command(`scale gp=+${gps} renderer=+${renderers}`);
  faults.push(...growth(await use('larger', minutes)));
}
console.log(`${rounds} rounds in ${minutesPassed().toFixed(1)} minutes`);
await close();
await browser.close();
const left = treeOf(server.child.pid);
const how = await server.stop();
const alive = left.filter(pid => treeOf(pid).length > 0);
if (alive.length > 0) faults.push(`processes ${alive} still run`);
if (how.code !== 0) faults.push(`pxpl5 serve ended with ${how.code}: ${how.errors}`);
if (faults.length > 0) throw new Error(faults.join('\n'));
