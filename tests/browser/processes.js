// Resources of a process and its children, from /proc.
import { readFileSync, readdirSync, readlinkSync } from 'node:fs';

const TICKS_PER_S = 100;  // Of /proc/PID/stat on Linux, whatever the kernel's own rate.

/** A file of /proc, or '' if its process has ended. */
function read(path) {
  try {
    return readFileSync(path, 'utf8');
  } catch (error) {
    if (error.code === 'ENOENT' || error.code === 'ESRCH') return '';
    throw error;
  }
}

/** Fields of /proc/PID/stat from the third on; the second may hold blanks. */
function stat(pid) {
  const text = read(`/proc/${pid}/stat`);
  return text.slice(text.lastIndexOf(')') + 2).split(' ');
}

/** A process and all that descend from it; [] if it has ended. */
export function treeOf(root) {
  const children = new Map();
  let isThere = false;
  for (const name of readdirSync('/proc').filter(each => /^\d+$/.test(each))) {
    const pid = Number(name);
    const parent = Number(stat(pid)[1]);
    children.set(parent, [...(children.get(parent) ?? []), pid]);
    isThere ||= pid === root;
  }
  const found = isThere ? [root] : [];
  for (let i = 0; i < found.length; i++) found.push(...(children.get(found[i]) ?? []));
  return found;
}

/** Seconds that these processes and their ended children have computed. */
export function cpuSeconds(pids) {
  const ticks = pids.flatMap(pid => stat(pid).slice(11, 15).map(Number));
  return ticks.reduce((sum, each) => sum + (each || 0), 0) / TICKS_PER_S;
}

/** The sum of some values of /proc/PID/smaps_rollup of these processes, MiB. */
function sizeMib(pids, kind) {
  const kib = pids.flatMap(pid =>
    [...read(`/proc/${pid}/smaps_rollup`).matchAll(kind)].map(found => Number(found[1])));
  return kib.reduce((sum, each) => sum + each, 0) / 1024;
}

/** Memory of these processes in MiB: what they share is counted once (proportional set size). */
export function memoryMib(pids) {
  return sizeMib(pids, /^Pss:\s+(\d+)/mg);
}

/** How many descriptors a process has of each kind: "socket", "/memfd:pxpl", "pipe", ... */
function descriptorKinds(pid) {
  const kinds = new Map();
  for (const name of readdirSync(`/proc/${pid}/fd`)) {
    let target = 'closed meanwhile';
    try {
      target = readlinkSync(`/proc/${pid}/fd/${name}`);
    } catch (error) {
      if (error.code !== 'ENOENT') throw error;
    }
    const kind = target.replace(/[:\d[\]()]+.*$/, '');
    kinds.set(kind, (kinds.get(kind) ?? 0) + 1);
  }
  return kinds;
}

/**
 * What each process holds: its program, its memory in MiB, and how many descriptors (also by kind)
 * and threads.
 * The memory is without the pages of files: a process has a larger share of its libraries as soon
 * as another program that uses them ends.
 * @param {number[]} pids
 */
export function holdings(pids) {
  const found = new Map();
  for (const pid of pids) {
    const status = read(`/proc/${pid}/status`);
    if (!status) continue;
    let kinds = null;
    try {
      kinds = descriptorKinds(pid);
    } catch (error) {
      if (error.code !== 'ENOENT' && error.code !== 'ESRCH') throw error;
      continue;
    }
    const descriptors = [...kinds.values()].reduce((sum, each) => sum + each, 0);
    found.set(pid, { name: /^Name:\s+(.*)/m.exec(status)[1], descriptors, kinds,
                  mib: sizeMib([pid], /^Pss_(?:Anon|Shmem):\s+(\d+)/mg),
                  threads: Number(/^Threads:\s+(\d+)/m.exec(status)[1]) });
  }
  return found;
}

/** The browser's processes, which this one has started. */
export function browserProcesses() {
  const own = treeOf(process.pid);
  const isBrowser = pid => /chrom/.test(read(`/proc/${pid}/cmdline`).split('\0')[0]);
  return own.filter(isBrowser);
}
