// What one node does, and ending it, in a dialog.
import {h} from '../elements/dom.js';
import {memoryText} from './node_list.js';
import {sumsOf} from './ring_flow.js';

/** @typedef {import('./ring_flow.js').NodeReport} NodeReport */

const MORTAL = new Set(['gp', 'renderer', 'framebuffer', 'frame_buffer']);
const MOST_ROWS = 8;

/**
 * @param {string[]} head
 * @param {(string | number)[][]} rows
 */
function table(head, rows) {
  return h('table', {}, h('thead', {}, h('tr', {}, ...head.map(each => h('th', {}, each)))),
    h('tbody', {}, ...rows.slice(0, MOST_ROWS).map(row =>
      h('tr', {}, ...row.map(each => h('td', {}, each))))));
}

/** @param {NodeReport} node */
function tablesOf(node) {
  const sums = sumsOf(node.sent);
  return [node.stages.length > 0 ? table(['stage', 'ms'], node.stages.map(({name, ms}) =>
    [name.replaceAll('_', ' '), ms.toFixed(1)])) : '',
  sums.length > 0 ? table(['sent to', 'what', 'channels', 'messages', 'kB'], sums.map(each =>
    [each.to, each.kind, each.channels.join(' '), each.messages, (each.bytes / 1e3).toFixed(1)]))
    : h('p', {class: 'legend'}, 'It sent nothing.'),
  sums.length > MOST_ROWS ? h('p', {class: 'legend'},
    `The ${MOST_ROWS} largest of ${sums.length} are shown.`) : ''];
}

export class NodeDialog {
  /**
   * Opens it; `update` is to follow with each report.
   * @param {NodeReport} node
   * @param {((name: string) => void) | null} kill  Null: this page may only watch.
   */
  constructor({name, role}, kill) {
    this.name = name;
    const dialog = h('dialog', {class: 'node-dialog', 'data-testid': 'node-dialog',
      'aria-label': name, onclose: () => dialog.remove()});
    const mortal = MORTAL.has(role) && kill !== null;
    /** @private */ this.status_ = h('p', {class: 'muted', 'data-testid': 'node-status'});
    /** @private */ this.tables_ = h('div', {class: 'node-tables'});
    /** @private */ this.end_ = h('button', {type: 'button', class: 'danger',
      'data-testid': 'node-kill', onclick: () => {
        dialog.close();
        kill?.(name);
      }}, `Kill ${name}`);
    dialog.append(h('h2', {}, name), this.status_, this.tables_,
      mortal ? h('p', {}, 'Killing it ends its process at once, as a failure would: the machine ' +
        'stops, is started again, and the session is repeated. Nothing is lost.') : '',
      h('div', {class: 'dialog-buttons'}, mortal ? this.end_ : '',
        h('button', {type: 'button', autofocus: true, 'data-testid': 'node-close',
          onclick: () => dialog.close()}, 'Close')));
    document.body.append(dialog);
    dialog.showModal();
  }

  /**
   * @param {NodeReport} node
   * @param {boolean} dead
   */
  update(node, dead) {
    this.end_.disabled = dead;
    if (dead || node.answered === false) {  // What it did last stays.
      this.status_.textContent = dead ? 'It is dead. Below: what it did before.'
        : 'It is too busy to answer just now. Below: what it did before.';
      return;
    }
    this.status_.textContent = `In the last ${((node.wall_ms ?? 0) / 1000).toFixed(2)} s: ` +
      `${Math.round(100 * node.busy)} % busy, ${node.queue} messages waiting, ` +
      `${memoryText(node.memory_bytes)} of memory.`;
    this.tables_.replaceChildren(...tablesOf(node));
  }
}
