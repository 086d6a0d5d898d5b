// The load of each node, now and in the last seconds. Each node is a button with a dialog.
import {DATA, h, s} from '../elements/dom.js';
import {grouped, percent} from '../elements/numbers.js';
import {say} from '../texts/say.js';

/** @typedef {import('./ring_flow.js').NodeReport} NodeReport */

const HISTORY = 40;         // Reports kept per node: 10 s.
const SPARK = [HISTORY, 16];

/**
 * @param {number} bytes
 */
export function memoryText(bytes) {
  return bytes < 1e5 ? `${grouped(bytes / 1e3)} kB`
    : `${grouped(bytes / 1e6, bytes < 1e7 ? 1 : 0)} MB`;
}

/**
 * A line through the last shares, newest at the right.
 * @param {number[]} shares
 */
function sparkPath(shares) {
  const first = SPARK[0] - shares.length;
  return shares.map((share, n) =>
    `${n === 0 ? 'M' : 'L'}${first + n + 0.5} ${((1 - share) * SPARK[1]).toFixed(1)}`).join('');
}

class NodeCell {
  /**
   * @param {string} name
   * @param {string} role
   * @param {(name: string, event: Event) => void} choose
   */
  constructor(name, role, choose) {
    /** @private */
    this.name_ = name;
    /** @private @type {number[]} */
    this.shares_ = [];
    /** @private */
    this.path_ = s('path');
    /** @private */
    this.percent_ = h('span', {class: 'number muted'});
    /** @private */
    this.bar_ = s('rect', {class: 'bar', x: 0, y: 0, height: 2, width: 0});
    this.element = h('button', {type: 'button', class: `node-cell ${role}`,
      'data-testid': `node-${name}`, 'aria-haspopup': 'dialog',
      onclick: (/** @type {Event} */ event) => choose(name, event),
      oncontextmenu: (/** @type {Event} */ event) => {
        event.preventDefault();
        choose(name, event);
      }},
    h('span', {...DATA, class: 'node-name'}, name),
    s('svg', {class: 'spark', viewBox: `0 0 ${SPARK[0]} ${SPARK[1]}`, preserveAspectRatio: 'none',
      'aria-hidden': true}, this.path_), this.percent_,
    s('svg', {class: 'level', viewBox: '0 0 100 2', preserveAspectRatio: 'none',
      'aria-hidden': true}, this.bar_));
  }

  /** @param {boolean} dead */
  mark(dead) {
    this.element.classList.toggle('dead', dead);
    if (dead) {
      this.percent_.textContent = say`dead`;
      this.bar_.setAttribute('width', '0');
      this.element.title = say`${this.name_} is dead`;
    }
  }

  /** @param {NodeReport} node */
  update({busy, answered, memory_bytes, queue, name}) {
    const known = answered !== false;
    this.element.classList.toggle('silent', !known);
    if (known) {
      this.shares_.push(Math.min(Math.max(busy, 0), 1));
      this.shares_.splice(0, this.shares_.length - HISTORY);
    }
    const load = known ? percent(busy) : '…';
    this.percent_.textContent = load;
    this.bar_.setAttribute('width', String(known ? 100 * busy : 0));
    this.path_.setAttribute('d', sparkPath(this.shares_));
    this.element.title = known
      ? say`${name}: ${load} busy, ${memoryText(memory_bytes)},
        ${grouped(queue)} in the message queue`
      : say`${name} is too busy to report`;
  }
}

export class NodeList {
  /** @param {(name: string, event: Event) => void} choose  Opens the dialog of a node. */
  constructor(choose) {
    /** @private */
    this.choose_ = choose;
    /** @private @type {Map<string, NodeCell>} */
    this.cells_ = new Map();
    this.element = h('div', {class: 'node-list', 'data-testid': 'nodes'});
  }

  /** @param {ReadonlyMap<string, unknown>} dead  By name. */
  mark(dead) {
    for (const [name, cell] of this.cells_) {
      cell.mark(dead.has(name));
    }
  }

  /** @param {NodeReport[]} nodes */
  update(nodes) {
    const names = nodes.map(({name}) => name);
    if (names.join() !== [...this.cells_.keys()].join()) {
      this.cells_ = new Map(nodes.map(({name, role}) =>
        [name, this.cells_.get(name) ?? new NodeCell(name, role, this.choose_)]));
      this.element.replaceChildren(...[...this.cells_.values()].map(cell => cell.element));
    }
    for (const node of nodes) {
      this.cells_.get(node.name)?.update(node);
    }
  }
}
