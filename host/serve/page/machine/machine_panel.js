// Panel: what the machine's processes do just now, and what happens when one dies.
import {h} from '../elements/dom.js';
import {ModelView} from './model_view.js';
import {NodeDialog} from './node_dialog.js';
import {NodeList} from './node_list.js';
import {messageLine} from '../panel/panel_parts.js';
import {RegionMap} from './region_map.js';
import {RingView} from './ring_view.js';
import {StageBars} from './stage_bars.js';

/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */

const MOST_EVENTS = 3;          // They stand above all else: more would push the ring away.

/**
 * A node that has died may have an answer under way still, but not two: it is asked anew only when
 * it has answered.
 */
const ANSWERS_OF_THE_LIVING = 2;

/**
 * @param {string} text
 * @param {string} name  Of a node: 'gp-1' is not named in 'gp-10'.
 */
function names(text, name) {
  return text.split(/[^\w-]+/).includes(name);
}

class MachinePanel {
  /**
   * @param {HTMLElement} root
   * @param {import('../panel/app.js').App} app
   */
  constructor(root, app) {
    this.app = app;
    /** @type {MachineReport | null} */
    this.report = null;
    /** Whether notes are about a node that died. */
    this.awaits = false;
    /** Nodes that died: how often they have answered since. @type {Map<string, number>} */
    this.dead = new Map();
    /** @type {NodeDialog | null} */
    this.dialog = null;
    const choose = (/** @type {string} */ name) => this.choose(name);
    this.ring = new RingView(choose);
    this.nodes = new NodeList(choose);
    this.regions = new RegionMap();
    this.stages = new StageBars();
    this.title = h('span', {'data-testid': 'machine-title'});
    this.events = h('ol', {class: 'events', 'data-testid': 'machine-events',
      'aria-live': 'polite', hidden: true});
    this.message = messageLine('machine-message');
    this.body = h('div', {class: 'stack', hidden: true},
      this.ring.canvas, this.ring.legend,
      h('h3', {}, 'How busy each node is'), this.nodes.element,
      h('p', {class: 'legend'}, 'Lines: the last ten seconds. Press a node to look into it or to ' +
        'kill it.'),
      h('h3', {}, 'Who draws what'), this.regions.canvas, this.regions.readout,
      h('h3', {}, 'Where a frame’s time goes'), this.stages.element,
      h('h3', {}, 'On the machine of 1993'), new ModelView(app).element);
    root.append(h('p', {class: 'panel-intro'}, 'The machine’s processes at work. ', this.title),
      this.message.element, this.events, this.body);
    this.message.say('Waiting for the nodes to answer …');
    this.listen(root);
  }

  /** @param {HTMLElement} root */
  listen(root) {
    const {connection, store} = this.app;
    root.addEventListener('panelshow', () => connection.wantMachine(true));
    root.addEventListener('panelhide', () => connection.wantMachine(false));
    connection.on('machine', report => this.take(report));
    connection.on('note', ({level, text}) => {
      const dead = this.report?.nodes.filter(({name}) => names(text, name)) ?? [];
      if (level === 'error' && text.includes('died') && dead.length > 0) {
        this.bury(dead.map(({name}) => name));
        this.awaits = true;  // Whoever killed it.
      }
      if (this.awaits) {
        this.tell(text);
        this.awaits = level === 'error';  // The machine is there again.
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
    for (const {name, answered} of report.nodes) {
      const answers = this.dead.get(name);
      if (answers !== undefined && answered !== false) {
        this.dead.set(name, answers + 1);
        if (answers + 1 >= ANSWERS_OF_THE_LIVING) {
          this.dead.delete(name);
        }
      }
    }
    this.mark();
  }

  /** @param {string[]} nodes  Names. Shown as dead until they answer again. */
  bury(nodes) {
    for (const name of nodes) {
      this.dead.set(name, 0);
    }
    this.mark();
  }

  /** Tells all that show nodes which are dead. */
  mark() {
    this.ring.mark(this.dead);
    this.nodes.mark(this.dead);
    const node = this.report?.nodes.find(({name}) => name === this.dialog?.name);
    if (node) {
      this.dialog?.update(node, this.dead.has(node.name));
    }
  }

  /** @param {string} name */
  choose(name) {
    const node = this.report?.nodes.find(each => each.name === name);
    if (node) {
      this.dialog = new NodeDialog(node,
        this.app.connection.watches ? null : each => void this.kill(each));
      this.mark();
    }
  }

  /** @param {string} name */
  async kill(name) {
    this.awaits = true;
    const reply = await this.app.connection.do(`kill ${name}`);
    if (reply.ok) {
      this.bury([name]);
      this.tell(reply.text ?? `${name} was killed.`);
    }
  }

  /** @param {string} text  What happened after a node was killed. */
  tell(text) {
    const time = new Date().toLocaleTimeString('en', {hour12: false});
    this.events.hidden = false;
    this.events.append(h('li', {}, h('span', {class: 'muted number'}, `${time} `), text));
    while (this.events.childElementCount > MOST_EVENTS) {
      this.events.firstElementChild?.remove();
    }
  }
}

/**
 * @param {HTMLElement} root
 * @param {import('../panel/app.js').App} app
 */
export function create(root, app) {
  new MachinePanel(root, app);
}
