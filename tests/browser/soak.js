// Uses everything again and again and watches memory and processes: `soak.js MINUTES`, through
// run_test.sh. Fails if anything grows beyond its bound after a first round, which fills caches.
import { launchBrowser, openPage, serve } from './harness.js';
import { browserProcesses, memoryMib, treeOf } from './processes.js';
import { drag, middleOf, rawSocket, say, settled, state } from './steps.js';

// The flight recorders use 64 MiB of the server's memory, which they fill in the first minutes.
const MAY_GROW_MIB = { server: 96, browser: 96, heap: 8 };
const S_PER_MIN = 60;

const minutes = Number(process.argv[2] ?? 30);
if (!(minutes > 0)) throw new Error(`minutes: '${process.argv[2]}' is no number above 0`);

const server = await serve('phantom:pelvis', 'resample=128x128x64');
const browser = await launchBrowser();
const { page, context, close } = await openPage(browser, server.url);
const session = await context.newCDPSession(page);
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

async function sample() {
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  const processes = treeOf(server.child.pid);
  return { server: memoryMib(processes), browser: memoryMib(browserProcesses()),
         heap: usedSize / 2 ** 20, processes: processes.length };
}

// The browser fills its caches for two rounds.
await round();
await round();
const start = await sample();
const begin = performance.now();
const minutesPassed = () => (performance.now() - begin) / 1000 / S_PER_MIN;
let middle = null;
let rounds = 0;
do {
  await round();
  rounds += 1;
  if (!middle && minutesPassed() >= minutes / 2) middle = await sample();
} while (minutesPassed() < minutes);
const end = await sample();

console.log(`${rounds} rounds in ${minutesPassed().toFixed(1)} minutes`);
console.log('| | server MiB | browser MiB | page heap MiB | processes |\n|---|---|---|---|---|');
for (const [name, each] of Object.entries({ start, middle, end })) {
  console.log(`| ${name} | ${each.server.toFixed(1)} | ${each.browser.toFixed(1)} | ` +
    `${each.heap.toFixed(2)} | ${each.processes} |`);
}
await close();
await browser.close();
const left = treeOf(server.child.pid);
const how = await server.stop();
const faults = Object.entries(MAY_GROW_MIB).filter(([name, most]) => end[name] - start[name] > most)
  .map(([name, most]) => `${name} grew by ${(end[name] - start[name]).toFixed(1)} MiB, ` +
    `${most} are allowed`);
if (end.processes !== start.processes) {
  faults.push(`${start.processes} processes at the start, ${end.processes} at the end`);
}
const alive = left.filter(pid => treeOf(pid).length > 0);
if (alive.length > 0) faults.push(`processes ${alive} still run`);
if (how.code !== 0) faults.push(`pxpl5 serve ended with ${how.code}: ${how.errors}`);
if (faults.length > 0) throw new Error(faults.join('\n'));
