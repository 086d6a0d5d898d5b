// Panel: the activity of the nodes, and the events after a node dies.
import {h} from '../elements/dom.js';
import {ComputersView} from './computers_view.js';
import {ModelView} from './model_view.js';
import {NodeDialog} from './node_dialog.js';
import {NodeList} from './node_list.js';
import {messageLine} from '../panel/panel_parts.js';
import {HeadsetTimes, PointerTimes} from './pointer_times.js';
import {RegionMap} from './region_map.js';
import {RingView} from './ring_view.js';
import {StageBars} from './stage_bars.js';
import {say} from '../texts/say.js';

/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */

const MOST_EVENTS = 3;          // The list is above the ring: more events would push the ring away.

/**
 * A dead node may have one report in flight, but not two: the host requests the next report only
 * after it has received the previous report.
 */
const ANSWERS_OF_THE_LIVING = 2;

/**
 * @param {string} text
 * @param {string} name  A node: 'gp-10' does not name 'gp-1'.
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
    /** Whether the next notes are about a node that died. */
    this.awaits = false;
    /** Dead nodes, with the number of reports since. @type {Map<string, number>} */
    this.dead = new Map();
    /** @type {NodeDialog | null} */
    this.dialog = null;
    const choose = (/** @type {string} */ name) => this.choose(name);
    this.ring = new RingView(choose);
    this.nodes = new NodeList(choose);
    this.regions = new RegionMap();
    this.stages = new StageBars();
    this.pointer = new PointerTimes(app);
    this.headset = new HeadsetTimes();
    this.computers = new ComputersView(app);
    this.title = h('span', {'data-testid': 'machine-title'});
    this.events = h('ol', {class: 'events', 'data-testid': 'machine-events',
      'aria-live': 'polite', hidden: true});
    this.message = messageLine('machine-message');
    this.body = h('div', {class: 'stack', hidden: true},
      this.ring.canvas, this.ring.legend,
      h('h3', {}, say`Load of each node`), this.nodes.element,
      h('p', {class: 'legend'}, say`Each curve shows the last 10 seconds. Click a node to inspect
        or kill it.`),
      this.computers.element,
      h('h3', {}, say`Regions by Renderer`), this.regions.canvas, this.regions.readout,
      h('h3', {}, say`Time per frame`), this.stages.element, this.pointer.element,
      this.headset.element,
      h('h3', {}, say`Modelled machine of 1993`), new ModelView(app).element);
    root.append(h('p', {class: 'panel-intro'}, `${say`Activity of the nodes.`} `, this.title),
      this.message.element, this.events, this.body);
    this.message.say(say`Waiting for the nodes to report …`);
    this.listen(root);
  }

  /** @param {HTMLElement} root */
  listen(root) {
    const {connection, store} = this.app;
    for (const [event, isShown] of /** @type {const} */ ([['panelshow', true],
      ['panelhide', false]])) {
      root.addEventListener(event, () => {
        connection.wantMachine(isShown);
        this.computers.show(isShown);
      });
    }
    connection.on('machine', report => this.take(report));
    connection.on('note', ({level, text}) => {
      const dead = this.report?.nodes.filter(({name}) => names(text, name)) ?? [];
      if (level === 'error' && text.includes('died') && dead.length > 0) {
        this.bury(dead.map(({name}) => name));
        this.awaits = true;  // Another viewer may have killed the node.
      }
      if (this.awaits) {
        this.tell(text);
        this.awaits = level === 'error';  // An info note: the machine has restarted.
      }
    });
    store.subscribe(['machine'], ({machine}) => {
      this.title.textContent = say`Topology “${machine.topology}”: ${machine.gps} GPs,
        ${machine.renderers} Renderers.`;
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
    this.pointer.update();
    this.headset.update();
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

  /** @param {string[]} nodes  Names. The nodes are shown as dead until they report again. */
  bury(nodes) {
    for (const name of nodes) {
      this.dead.set(name, 0);
    }
    this.mark();
  }

  /** Passes the dead nodes to all views. */
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
      this.tell(reply.text ?? say`${name} was killed.`);
    }
  }

  /** @param {string} text  An event after a node was killed. */
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
