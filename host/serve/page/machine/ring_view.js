// The ring on a canvas: nodes in ring order, channels, and dots that stand for messages.
import {fitted, letterFont, onceAFrame, prefersReducedMotion, styleColor, watchSize}
  from '../elements/canvas.js';
import {h} from '../elements/dom.js';
import {grouped, percent} from '../elements/numbers.js';
import {dotsOf, flowsOf, stretchesOf} from './ring_flow.js';
import {plural, say} from '../texts/say.js';

/** @typedef {import('./ring_flow.js').Flow} Flow */
/** @typedef {import('./ring_flow.js').MachineReport} MachineReport */
/** @typedef {{flow: Flow, born: number}} Dot */

const DOTS_A_REPORT = 48;
const DOTS_ALIVE = 400;
const TURN_MS = 4000;           // Time of a dot for one turn of the ring.
const FADE_MS = 500;            // Dots fade in this time after the last message.
const FRAME_MS = 40;            // 25 frames/s look smooth and are cheap.
const MOST_LABELS = 10;         // With more nodes, names would overlap.
const LABEL_ROOM = 28;          // Space for names above and below the ring, CSS pixels.
const NEAR = 0.4;               // A pointer closer to the center than this chooses no node.
const GOLDEN = 0.618034;        // Multiples of it, modulo 1, are spread evenly.
const TRACKS = [0.56, 0.80];    // Radii of the innermost and outermost channel, of the whole.
const NODES = 0.88;

/** Kinds of messages; all others are control. Colors are those of tokens.css. */
const KINDS = [
  {kind: 'RegionPrograms', label: say`programs`, color: '--of-gp'},
  {kind: 'RegionPixels', label: say`pixels`, color: '--of-renderer'},
  {kind: 'FrameDone', label: say`frames`, color: '--of-frame-buffer'},
  {kind: '', label: say`control`, color: '--of-host'},
];
const CONTROL = '--of-host';
const ROLE_COLORS = new Map([['host', CONTROL], ['gp', '--of-gp'], ['renderer', '--of-renderer'],
  ['framebuffer', '--of-frame-buffer'], ['frame_buffer', '--of-frame-buffer']]);

/**
 * @param {number} place    On the ring; between nodes too.
 * @param {number} count    Number of nodes.
 */
function angleOf(place, count) {
  return 2 * Math.PI * place / count - Math.PI / 2;
}

/**
 * The radius of the largest ring that leaves room for nodes and names.
 * @param {CanvasRenderingContext2D} context
 * @param {import('./ring_flow.js').NodeReport[]} nodes
 * @param {number} width
 * @param {number} height
 * @param {number} unit
 * @returns {number}  Radius of the whole: nodes stand at NODES of it.
 */
function radiusFor(context, nodes, width, height, unit) {
  context.font = letterFont(unit, 400);
  const labeled = nodes.length <= MOST_LABELS;
  const radii = nodes.map(({name}, place) => {
    const out = Math.abs(Math.cos(angleOf(place, nodes.length)));
    const room = labeled ? context.measureText(name).width / 2 + 2 : 10 * unit;
    return (width / 2 - room) / Math.max(out, 0.01);
  });
  return Math.max(20, Math.min(...radii, height / 2 - (labeled ? LABEL_ROOM : 10) * unit) / NODES);
}

export class RingView {
  /** @param {(node: string, event: MouseEvent) => void} choose  Opens the dialog of a node. */
  constructor(choose) {
    this.canvas = h('canvas', {class: 'ring', role: 'img', 'data-testid': 'ring'});
    /** @private */ this.scale_ = h('span', {});
    this.legend = h('p', {class: 'legend keys'}, this.scale_, ...KINDS.map(({label}, number) =>
      h('span', {}, h('i', {class: `kind-${number}`}), label)));
    /** @private @type {MachineReport | null} */ this.report_ = null;
    /** @private @type {number[][]} */ this.stretches_ = [];
    /** @private @type {Dot[]} */ this.dots_ = [];
    /** Time of the last message, ms. @private @type {number | null} */ this.restsSince_ = null;
    /** @private @type {ReadonlyMap<string, unknown>} */ this.dead_ = new Map();
    /** @private @type {string | null} */ this.hovered_ = null;
    /** @private */ this.running_ = false;
    /** @private */ this.unit_ = 1;  // Scale of text and lines, from `fitted`.
    /** @private */ this.drawSoon_ = onceAFrame(() => this.draw_(performance.now()));
    watchSize(this.canvas, this.drawSoon_);
    this.canvas.addEventListener('pointermove', event => this.hover_(this.nodeAt_(event)));
    this.canvas.addEventListener('pointerleave', () => this.hover_(null));
    this.canvas.addEventListener('contextmenu', event => {
      const node = this.nodeAt_(event);
      event.preventDefault();
      if (node) {
        choose(node, event);
      }
    });
  }

  /** @param {ReadonlyMap<string, unknown>} dead  Dead nodes by name. */
  mark(dead) {
    this.dead_ = dead;
    if (dead.size > 0) {
      this.rest_();
    }
    this.drawSoon_();
  }

  /** Starts no new dots and fades the moving dots. @private */
  rest_() {
    const now = performance.now();
    this.dots_ = this.dots_.filter(({born}) => born <= now);
    this.restsSince_ ??= now;
  }

  /** @param {MachineReport} report */
  update(report) {
    const flows = flowsOf(report.nodes);
    this.report_ = report;
    this.stretches_ = stretchesOf(flows, report.nodes.length, report.channels.length);
    const {each, dots} = dotsOf(flows, DOTS_A_REPORT);
    if (flows.length === 0) {
      this.rest_();
    } else if (this.restsSince_ !== null) {
      this.restsSince_ = null;
      this.dots_ = [];
    }
    if (!prefersReducedMotion()) {
      const now = performance.now();
      // Adjacent dots belong to one flow. Spreading them over time avoids overlaps.
      this.dots_.push(...dots.map((flow, number) =>
        ({flow, born: now + number * GOLDEN % 1 * report.wall_ms})));
      this.dots_.splice(0, this.dots_.length - DOTS_ALIVE);
    }
    this.scale_.textContent = flows.length === 0 ? say`No messages: the machine is idle.`
      : prefersReducedMotion() ? say`Brighter arcs carried more messages.`
        : say`One dot is ${plural(each, say`1 message`, say`${grouped(each)} messages`)}.`;
    this.canvas.setAttribute('aria-label', say`Ring of ${report.nodes.length} nodes`);
    this.drawSoon_();
    this.run_();
  }

  /** @private  Draws while dots move, and stops when none do. */
  run_() {
    if (this.running_) {
      return;
    }
    this.running_ = true;
    let last = 0;
    const step = (/** @type {number} */ now) => {
      if (this.dots_.length === 0 || this.canvas.clientWidth === 0) {
        this.running_ = false;
        this.dots_ = [];
        this.drawSoon_();
        return;
      }
      if (now - last >= FRAME_MS) {
        last = now;
        this.draw_(now);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /**
   * @private
   * @param {number} now  ms
   */
  draw_(now) {
    const {context, width, height, unit} = fitted(this.canvas);
    const report = this.report_;
    if (!report || width === 0) {
      return;
    }
    const radius = radiusFor(context, report.nodes, width, height, unit);
    this.unit_ = unit;
    context.translate(width / 2, height / 2);
    this.drawChannels_(context, radius, report.nodes.length);
    this.drawDots_(context, radius, report.nodes.length, now);
    this.drawNodes_(context, radius, report.nodes);
    this.drawMiddle_(context, radius, report);
  }

  /**
   * @private
   * @param {number} channel
   * @param {number} radius   Radius of the whole ring.
   */
  track_(channel, radius) {
    const last = Math.max(this.stretches_.length - 1, 1);
    return radius * (TRACKS[0] + (TRACKS[1] - TRACKS[0]) * channel / last);
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {number} radius
   * @param {number} count
   */
  drawChannels_(context, radius, count) {
    const most = Math.max(1, ...this.stretches_.flat());
    context.lineWidth = 1.5 * this.unit_;
    for (let channel = 0; channel < this.stretches_.length; ++channel) {
      const track = this.track_(channel, radius);
      for (let place = 0; place < count; ++place) {
        const share = Math.log1p(this.stretches_[channel]?.[place] ?? 0) / Math.log1p(most);
        context.strokeStyle = `rgba(140, 160, 180, ${0.14 + 0.5 * share})`;
        context.beginPath();
        context.arc(0, 0, track, angleOf(place, count), angleOf(place + 1, count));
        context.stroke();
      }
    }
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {number} radius
   * @param {number} count
   * @param {number} now
   */
  drawDots_(context, radius, count, now) {
    const left = this.restsSince_ === null ? 1 : 1 - (now - this.restsSince_) / FADE_MS;
    this.dots_ = left <= 0 ? []
      : this.dots_.filter(({flow, born}) => now - born < TURN_MS * flow.hops / count);
    context.globalAlpha = Math.min(Math.max(left, 0), 1);
    const colors = new Map(KINDS.map(({kind, color}) => [kind, styleColor(this.canvas, color)]));
    for (const {flow, born} of this.dots_) {
      if (now >= born) {
        const angle = angleOf(flow.from + (now - born) / TURN_MS * count, count);
        const track = this.track_(flow.channel, radius);
        context.fillStyle = colors.get(flow.kind) ?? colors.get('') ?? '';
        context.beginPath();
        context.arc(track * Math.cos(angle), track * Math.sin(angle), 2.2 * this.unit_, 0,
          2 * Math.PI);
        context.fill();
      }
    }
    context.globalAlpha = 1;
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {number} radius
   * @param {import('./ring_flow.js').NodeReport[]} nodes
   */
  drawNodes_(context, radius, nodes) {
    const size = Math.min(9 * this.unit_, Math.max(3, radius * 2.4 / nodes.length));
    context.font = letterFont(this.unit_, 400);
    context.textBaseline = 'middle';
    nodes.forEach(({name, role, busy}, place) => {
      const angle = angleOf(place, nodes.length);
      const x = NODES * radius * Math.cos(angle), y = NODES * radius * Math.sin(angle);
      const dead = this.dead_.has(name);
      const color = styleColor(this.canvas, dead ? '--bad' : ROLE_COLORS.get(role) ?? CONTROL);
      context.beginPath();
      context.arc(x, y, size, 0, 2 * Math.PI);
      context.fillStyle = styleColor(this.canvas, '--panel');
      context.fill();
      context.globalAlpha = dead ? 0 : 0.15 + 0.85 * (busy ?? 0);
      context.fillStyle = color;
      context.fill();
      context.globalAlpha = 1;
      context.lineWidth = name === this.hovered_ ? 3 : 1.2;
      context.strokeStyle = color;
      if (dead) {
        const arm = size * Math.SQRT1_2;
        context.moveTo(x - arm, y - arm);
        context.lineTo(x + arm, y + arm);
        context.moveTo(x - arm, y + arm);
        context.lineTo(x + arm, y - arm);
      }
      context.stroke();
      if (nodes.length <= MOST_LABELS) {
        context.textAlign = 'center';
        context.fillStyle = dead ? color : styleColor(this.canvas, '--text');
        const side = Math.sin(angle) < -0.01 ? -1 : 1;
        context.fillText(dead ? say`${name} dead` : name, x, y + side * (size + 9 * this.unit_));
      }
    });
  }

  /**
   * @private
   * @param {CanvasRenderingContext2D} context
   * @param {number} radius
   * @param {MachineReport} report
   */
  drawMiddle_(context, radius, report) {
    const seconds = report.wall_ms / 1000 || 1;
    const node = report.nodes.find(({name}) => name === this.hovered_);
    const messages = node ? node.sent.reduce((sum, each) => sum + each.messages, 0)
      : report.channels.reduce((sum, each) => sum + each.messages, 0);
    const bytes = node ? node.sent.reduce((sum, each) => sum + each.bytes, 0)
      : report.channels.reduce((sum, each) => sum + each.bytes, 0);
    const lines = [node ? node.name : say`${grouped(report.frames / seconds, 1)} frames/s`,
      say`${grouped(messages / seconds)} messages/s`, `${grouped(bytes / seconds / 1e6, 1)} MB/s`];
    if (node) {
      lines.splice(1, 0, say`${percent(node.busy)} busy`);
    }
    context.textAlign = 'center';
    lines.forEach((line, number) => {
      context.font = number === 0 ? letterFont(this.unit_, 600, 'title')
        : letterFont(this.unit_, 400);
      context.fillStyle = styleColor(this.canvas, number === 0 ? '--text' : '--muted');
      context.fillText(line, 0, (number - (lines.length - 1) / 2) * 18 * this.unit_,
        2 * TRACKS[0] * radius);
    });
  }

  /**
   * @private
   * @param {MouseEvent} event
   * @returns {string | null}  The node nearest to the direction of the pointer.
   */
  nodeAt_({clientX, clientY}) {
    const box = this.canvas.getBoundingClientRect();
    const x = clientX - box.left - box.width / 2, y = clientY - box.top - box.height / 2;
    const away = Math.hypot(x, y) / Math.min(box.width, box.height) * 2;
    const nodes = this.report_?.nodes ?? [];
    if (away < NEAR || nodes.length === 0) {
      return null;
    }
    const place = (Math.atan2(y, x) + Math.PI / 2) / (2 * Math.PI) * nodes.length;
    return nodes[(Math.round(place) + nodes.length) % nodes.length].name;
  }

  /**
   * @private
   * @param {string | null} node
   */
  hover_(node) {
    if (node !== this.hovered_) {
      this.hovered_ = node;
      this.drawSoon_();
    }
  }
}
