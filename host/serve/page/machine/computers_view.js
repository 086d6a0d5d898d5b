// The other computers of a machine: their state, and buttons that use or release them.
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {plural, say} from '../texts/say.js';

/**
 * An entry of the answer to the command `computers`.
 * @typedef {object} Computer
 * @property {string} name
 * @property {'used' | 'idle' | 'lost' | 'released'} state
 * @property {number} cores
 * @property {number} nodes
 * @property {string} [why]  Why it is lost.
 */

/** @type {Record<Computer['state'], string>} */
const STATES = {used: say`used`, idle: say`idle`, lost: say`lost`, released: say`released`};

/** @param {Computer} computer */
function stateText({state, cores, nodes, why}) {
  return [STATES[state] ?? state, plural(cores, say`1 core`, say`${grouped(cores)} cores`),
    plural(nodes, say`1 node`, say`${grouped(nodes)} nodes`)].join(', ') + (why ? `: ${why}` : '');
}

export class ComputersView {
  /** @param {import('../panel/app.js').App} app */
  constructor(app) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.isShown_ = false;
    /** @private */
    this.rows_ = h('div', {class: 'stack', 'data-testid': 'computers'});
    /** @private */
    this.invitation_ = h('p', {class: 'legend', hidden: true, 'data-testid': 'invitation'});
    this.element = h('div', {class: 'stack', hidden: true}, h('h3', {}, say`Computers`), this.rows_,
      h('div', {class: 'row'},
        h('button', {'data-testid': 'computers-use', title: say`Places the nodes again, on all
          computers that have joined`, onclick: () => void this.change_('use')}, say`Use all`),
        h('button', {'data-testid': 'computers-invite', title: say`Prints the command for one more
          computer`, onclick: () => void this.invite_()}, say`Invite`)),
      this.invitation_);
    // A note may say that a computer has joined or is lost, or that the machine has restarted.
    app.connection.on('note', () => this.show(this.isShown_));
  }

  /** @param {boolean} isShown */
  show(isShown) {
    this.isShown_ = isShown;
    if (isShown) {
      void this.refresh();
    }
  }

  /** Asks for the list. A viewer that only watches may not ask. */
  async refresh() {
    if (this.app_.connection.watches) {
      return;
    }
    const reply = await this.app_.connection.do('computers', {quiet: true});
    if (reply.ok) {
      this.list_(/** @type {Computer[]} */ (reply.result?.computers ?? []));
    }
  }

  /**
   * @private
   * @param {Computer[]} computers
   */
  list_(computers) {
    this.element.hidden = computers.length === 0;
    this.rows_.replaceChildren(...computers.map(each => {
      const canUse = each.state !== 'used';
      const canRelease = each.state === 'used' || each.state === 'idle';
      return h('div', {class: 'row', 'data-testid': `computer-${each.name}`},
        h('span', {class: 'grow'}, h('strong', {}, each.name), ' ',
          h('span', {class: 'muted'}, stateText(each))),
        canUse ? h('button', {onclick: () => void this.change_(`use ${each.name}`)}, say`Use`)
          : null,
        canRelease ? h('button', {onclick: () => void this.change_(`release ${each.name}`)},
          say`Release`) : null);
    }));
  }

  /**
   * @private
   * @param {string} words
   */
  async change_(words) {
    const reply = await this.app_.connection.do(`computers ${words}`);
    if (reply.ok) {
      this.list_(/** @type {Computer[]} */ (reply.result?.computers ?? []));
    }
  }

  /** @private */
  async invite_() {
    const reply = await this.app_.connection.do('computers invite');
    if (reply.ok) {
      this.invitation_.hidden = false;
      this.invitation_.textContent = reply.text ?? '';
    }
  }
}
