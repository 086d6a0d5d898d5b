// The messages of the ring between two reports, prepared for drawing. Pure functions.

/** @typedef {{to: string, kind: string, channel: number, messages: number, bytes: number}} Sent */

/**
 * @typedef {object} NodeReport         One node, since its previous report.
 * @property {string} name              'gp-0'
 * @property {string} role              'host', 'gp', 'renderer', ...
 * @property {boolean} [answered]       False: too busy to report; the other fields are unknown.
 * @property {number} [wall_ms]         Since this node's previous report.
 * @property {number} busy              0..1, of the wall clock.
 * @property {{name: string, ms: number}[]} stages
 * @property {number} memory_bytes
 * @property {number} queue             Messages waiting.
 * @property {Sent[]} sent
 */

/**
 * @typedef {object} MachineReport      The `machine` message.
 * @property {number} wall_ms           Since the previous report.
 * @property {number} frames            Frames finished in that time.
 * @property {{elapsed_ms: number, renderer_ms_1993?: number, instructions: number,
 *   regions: {columns: number, rows: number, renderer: number[], cycles: number[]}}} [frame]
 * @property {NodeReport[]} nodes       In the order of the ring.
 * @property {{messages: number, bytes: number}[]} channels
 */

/** @typedef {{from: number, hops: number, channel: number, kind: string, messages: number}} Flow */

/**
 * The messages of each node as paths along the ring, which has one direction.
 * @param {NodeReport[]} nodes  In the order of the ring.
 * @returns {Flow[]}            `from`: place on the ring; `hops`: places further on.
 */
export function flowsOf(nodes) {
  const places = new Map(nodes.map(({name}, place) => [name, place]));
  return nodes.flatMap(({sent}, from) => sent.flatMap(({to, kind, channel, messages}) => {
    const place = places.get(to);
    if (place === undefined || messages === 0) {
      return [];
    }
    const hops = (place - from + nodes.length) % nodes.length || nodes.length;
    return [{from, hops, channel, kind, messages}];
  }));
}

/**
 * The messages of a node by destination and kind, summed over the channels.
 * @param {Sent[]} sent
 * @returns {{to: string, kind: string, channels: number[], messages: number, bytes: number}[]}
 *     the most bytes first; channels in order
 */
export function sumsOf(sent) {
  /** @type {Map<string, ReturnType<typeof sumsOf>[number]>} */
  const sums = new Map();
  for (const {to, kind, channel, messages, bytes} of sent) {
    const sum = sums.get(`${to} ${kind}`) ?? {to, kind, channels: [], messages: 0, bytes: 0};
    sums.set(`${to} ${kind}`, {...sum, messages: sum.messages + messages, bytes: sum.bytes + bytes,
      channels: [...new Set([...sum.channels, channel])].sort((a, b) => a - b)});
  }
  return [...sums.values()].sort((a, b) => b.bytes - a.bytes);
}

/**
 * Number of messages on each stretch of each channel.
 * @param {Flow[]} flows
 * @param {number} nodeCount
 * @param {number} channelCount
 * @returns {number[][]}  [channel][place]: on the stretch from that place to the next.
 */
export function stretchesOf(flows, nodeCount, channelCount) {
  const stretches = Array.from({length: channelCount}, () => new Array(nodeCount).fill(0));
  for (const {from, hops, channel, messages} of flows) {
    const passed = stretches[channel];
    for (let hop = 0; passed && hop < hops; ++hop) {
      passed[(from + hop) % nodeCount] += messages;
    }
  }
  return stretches;
}

/**
 * Dots for the messages, at most `most`. Each flow gets its share: remainders carry over to the
 * next flow, so that many small flows count as much as one large flow.
 * @param {Flow[]} flows
 * @param {number} most
 * @returns {{each: number, dots: Flow[]}}  each: messages that a dot stands for, 1, 2, 5, 10 ...
 */
export function dotsOf(flows, most) {
  const all = flows.reduce((sum, {messages}) => sum + messages, 0);
  const power = 10 ** Math.max(0, Math.floor(Math.log10(Math.max(1, all / most))));
  const each = [1, 2, 5, 10].map(step => step * power).find(step => all / step <= most) ?? power;
  /** @type {Flow[]} */
  const dots = [];
  let left = each / 2;
  for (const flow of flows) {
    for (left += flow.messages; left >= each; left -= each) {
      dots.push(flow);
    }
  }
  return {each, dots};
}
