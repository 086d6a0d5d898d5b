// Panel: what the machine's processes do just now, and what happens when one dies.
import {h} from './dom.js';
import {showNode} from './node_dialog.js';
import {NodeList} from './node_list.js';
import {messageLine} from './panel_parts.js';
import {RegionMap} from './region_map.js';
import {RingView} from './ring_view.js';
import {StageBars} from './stage_bars.js';

/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */

const MOST_EVENTS = 6;

class MachinePanel {
  /**
   * @param {HTMLElement} root
   * @param {import('./types.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    /** @type {MachineReport | null} */
    this.report = null;
    /** Until when notes are about a node that was killed here. */
    this.awaits = false;
    const choose = (/** @type {string} */ name) => this.choose(name);
    this.ring = new RingView(choose);
    this.nodes = new NodeList(choose);
    this.regions = new RegionMap(app.store);
    this.stages = new StageBars();
    this.title = h('span', {'data-testid': 'machine-title'});
    this.events = h('ol', {class: 'events', 'data-testid': 'machine-events',
      'aria-live': 'polite'});
    this.message = messageLine('machine-message');
    this.body = h('div', {class: 'stack', hidden: true},
      this.ring.canvas, this.ring.legend,
      h('h3', {}, 'How busy each node is'), this.nodes.element,
      h('p', {class: 'legend'}, 'Lines: the last ten seconds. Press a node to look into it or to ' +
        'kill it.'), this.events,
      h('h3', {}, 'Who draws what'), this.regions.canvas, this.regions.readout,
      h('h3', {}, 'Where a frame’s time goes'), this.stages.element);
    root.append(h('p', {class: 'panel-intro'}, 'The machine’s processes at work. ', this.title),
      this.message.element, this.body);
    this.message.say('Waiting for the nodes to answer …');
    this.listen(root);
  }

  /** @param {HTMLElement} root */
  listen(root) {
    const {connection, store} = this.app;
    root.addEventListener('panelshow', () => connection.wantMachine(true));
    root.addEventListener('panelhide', () => connection.wantMachine(false));
    connection.on('machine', report => this.take(report));
    connection.on('note', ({text}) => {
      if (this.awaits) {
        this.tell(text);
      }
    });
    store.subscribe(['machine'], ({machine}) => {
      this.title.textContent = `Topology “${machine.topology}”: ${machine.gps} GPs, ` +
        `${machine.renderers} Renderers.`;
    });
  }

  /** @param {MachineReport} report */
  take(report) {
    this.report = report;
    this.body.hidden = false;
    this.message.element.hidden = true;
    this.ring.update(report);
    this.nodes.update(report.nodes);
    // Before the first frame there are no regions.
    this.regions.update(report.frame && report.frame.regions.columns > 0 ? report.frame.regions
      : null);
    this.stages.update(report);
  }

  /** @param {string} name */
  choose(name) {
    const node = this.report?.nodes.find(each => each.name === name);
    if (node) {
      showNode(node, this.app.connection.watches ? null : each => void this.kill(each));
    }
  }

  /** @param {string} name */
  async kill(name) {
    this.awaits = true;
    const reply = await this.app.connection.do(`kill ${name}`);
    if (reply.ok) {
      this.tell(reply.text ?? `${name} was killed.`);
    }
  }

  /** @param {string} text  What happened after a node was killed. */
  tell(text) {
    const time = new Date().toLocaleTimeString('en', {hour12: false});
    this.events.append(h('li', {}, h('span', {class: 'muted number'}, `${time} `), text));
    while (this.events.childElementCount > MOST_EVENTS) {
      this.events.firstElementChild?.remove();
    }
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('./types.js').App} app
 */
export function create(root, app) {
  new MachinePanel(root, app);
}
