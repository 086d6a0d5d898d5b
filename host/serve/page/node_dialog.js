// What one node does, and ending it, in a dialog.
import {h} from './dom.js';

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

/**
 * @param {NodeReport} node
 * @param {((name: string) => void) | null} kill  Null: this page may only watch.
 */
export function showNode(node, kill) {
  const dialog = h('dialog', {class: 'node-dialog', 'data-testid': 'node-dialog',
    'aria-label': node.name, onclose: () => dialog.remove()});
  const sent = [...node.sent].sort((a, b) => b.bytes - a.bytes);
  const mortal = MORTAL.has(node.role) && kill !== null;
  const end = h('button', {type: 'button', class: 'danger', 'data-testid': 'node-kill',
    onclick: () => {
      dialog.close();
      kill?.(node.name);
    }}, `Kill ${node.name}`);
  dialog.append(h('h2', {}, node.name),
    h('p', {class: 'muted'}, node.answered === false
      ? 'It is too busy to answer just now.' : `${Math.round(100 * node.busy)} % busy, ` +
      `${(node.memory_bytes / 1e6).toFixed(1)} MB, ${node.queue} messages waiting.`),
    node.stages.length > 0 ? table(['stage', 'ms'], node.stages.map(({name, ms}) =>
      [name.replaceAll('_', ' '), ms.toFixed(1)])) : '',
    sent.length > 0 ? table(['sent to', 'what', 'channel', 'messages', 'kB'], sent.map(each =>
      [each.to, each.kind, each.channel, each.messages, (each.bytes / 1e3).toFixed(1)])) : '',
    sent.length > MOST_ROWS ? h('p', {class: 'legend'},
      `The ${MOST_ROWS} largest of ${sent.length} are shown.`) : '',
    mortal ? h('p', {}, 'Killing it ends its process at once, as a failure would: the machine ' +
      'stops, is started again, and the session is repeated. Nothing is lost.') : '',
    h('div', {class: 'dialog-buttons'}, mortal ? end : '',
      h('button', {type: 'button', autofocus: true, 'data-testid': 'node-close',
        onclick: () => dialog.close()}, 'Close')));
  document.body.append(dialog);
  dialog.showModal();
}
