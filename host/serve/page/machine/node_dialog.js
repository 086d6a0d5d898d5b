// A dialog with the activity of one node, and a button that kills the node.
import {h} from '../elements/dom.js';
import {grouped, percent} from '../elements/numbers.js';
import {memoryText} from './node_list.js';
import {sumsOf} from './ring_flow.js';
import {say} from '../texts/say.js';

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
  return [node.stages.length > 0 ? table([say`stage`, 'ms'], node.stages.map(({name, ms}) =>
    [name.replaceAll('_', ' '), grouped(ms, 1)])) : '',
  sums.length > 0 ? table([say`sent to`, say`kind`, say`channels`, say`messages`, 'kB'],
    sums.map(each => [each.to, each.kind, each.channels.join(' '), grouped(each.messages),
      grouped(each.bytes / 1e3, 1)]))
    : h('p', {class: 'legend'}, say`No messages were sent.`),
  sums.length > MOST_ROWS ? h('p', {class: 'legend'},
    say`Showing the ${MOST_ROWS} largest of ${sums.length}.`) : ''];
}

export class NodeDialog {
  /**
   * Opens the dialog. Call `update` with each report.
   * @param {NodeReport} node
   * @param {((name: string) => void) | null} kill  null on a view-only page.
   */
  constructor({name, role}, kill) {
    this.name = name;
    const dialog = h('dialog', {class: 'node-dialog', 'data-testid': 'node-dialog',
      'aria-label': name, onclose: () => dialog.remove()});
    const mortal = MORTAL.has(role) && kill !== null;
    /** @private */ this.status_ = h('p', {class: 'muted', 'data-testid': 'node-status'});
    /** @private */ this.tables_ = h('div', {class: 'node-tables', tabindex: 0,
      role: 'region', 'aria-label': say`Report of ${name}`});  // It scrolls, also by keys.
    /** @private */ this.end_ = h('button', {type: 'button', class: 'danger',
      'data-testid': 'node-kill', onclick: () => {
        dialog.close();
        kill?.(name);
      }}, say`Kill ${name}`);
    dialog.append(h('h2', {}, name), this.status_, this.tables_,
      mortal ? h('p', {}, say`Killing the node ends its process at once, to exercise failure
        handling. The machine restarts, and the scene is restored.`) : '',
      h('div', {class: 'dialog-buttons'}, mortal ? this.end_ : '',
        h('button', {type: 'button', autofocus: true, 'data-testid': 'node-close',
          onclick: () => dialog.close()}, say`Close`)));
    document.body.append(dialog);
    dialog.showModal();
  }

  /**
   * @param {NodeReport} node
   * @param {boolean} dead
   */
  update(node, dead) {
    this.end_.disabled = dead;
    if (dead || node.answered === false) {  // The last report stays.
      this.status_.textContent = dead ? say`This node is dead. The tables show its last report.`
        : say`This node is too busy to report. The tables show its last report.`;
      return;
    }
    this.status_.textContent = say`In the last ${grouped((node.wall_ms ?? 0) / 1000, 2)} s:
      ${percent(node.busy)} busy, ${grouped(node.queue)} in the message queue,
      ${memoryText(node.memory_bytes)} of memory.`;
    this.tables_.replaceChildren(...tablesOf(node));
  }
}
