// The headset on the page: its button, what the help says about it, and the strip while it is worn.
import {byId, h} from '../elements/dom.js';
import {webGlOf} from '../picture/painters.js';
import {say} from '../texts/say.js';
import {reasonAgainst} from './reasons.js';
import {Worn} from './worn.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../picture/metrics.js').HeadsetFigures} HeadsetFigures */

const CONTROLS = [
  [say`Grip`, say`hold and turn the patient; with both hands: scale`],
  [say`Trigger`, say`move a clip plane; pull it out of the patient to remove it`],
  [say`Stick`, say`up or down changes the isovalue of the chosen surface`],
  [say`A or X`, say`put the patient before you again`],
  [say`B or Y`, say`at two places: measure their distance`],
];
const STATES = {visible: say`Shown in the headset.`, 'visible-blurred':
  say`The headset shows a menu of its own over the patient.`,
  hidden: say`The headset is paused: it is taken off, or shows something else.`};

export class Headset {
  /**
   * @param {App} app
   * @param {HeadsetFigures} figures
   */
  constructor(app, figures) {
    /** @private */
    this.app_ = app;
    /** @private */
    this.figures_ = figures;
    /** @private @type {XRSession | null} */
    this.session_ = null;
    /** @private Whether the browser is asking for a session. */
    this.isStarting_ = false;
    /** Hidden where the browser has found no headset. */
    this.button = h('button', {hidden: true, 'data-testid': 'headset',
      onclick: () => this.session_ ? this.session_.end() : this.start_()}, say`Headset`);
    /** For the help. */
    this.help = h('section', {'data-testid': 'headset-help'});
    /** @private */
    this.state_ = h('span', {});
    /** @private Around the canvas of a session. */
    this.mirror_ = h('div', {id: 'mirror', 'data-testid': 'headset-mirror', hidden: true},
      h('p', {role: 'status', 'data-testid': 'headset-state'}, this.state_, ' ',
        h('button', {'data-testid': 'headset-end', onclick: () => void this.session_?.end()},
          say`End`)));
    byId('stage').append(this.mirror_);
    // Else a drag on the button would turn the picture.
    this.mirror_.addEventListener('pointerdown', event => event.stopPropagation());
    // Pairs that arrive after the end have no other reader.
    app.connection.on('frame', frame => {
      if (frame.header.pose !== 0 && !this.session_) {
        frame.shown();
      }
    });
    app.connection.on('hello', () => void this.look_());
    app.picture.warp?.onSwitched(() => this.offer_());
    /** @private Known once there is a headset. */
    this.hasWebGl_ = false;
    navigator.xr?.addEventListener('devicechange', () => void this.look_());
    void this.look_();
  }

  /** Asks the browser for a headset. @private */
  async look_() {
    this.figures_.reason = await reasonAgainst();
    if (this.figures_.reason === '') {
      this.hasWebGl_ ||= webGlOf() !== null;
    }
    this.offer_();
  }

  /** Shows the button and the help. @private */
  offer_() {
    const {reason} = this.figures_, {watches} = this.app_.connection;
    const cannotWarp = this.app_.picture.warp?.refusal
      || (this.hasWebGl_ ? '' : say`the browser has no WebGL 2`);
    const refusal = watches ? say`A view-only page cannot use a headset. Use the other address that
      pxpl5 serve printed.`
      : cannotWarp === '' ? '' : say`The page cannot use a headset: ${cannotWarp}.`;
    this.button.hidden = reason !== '';
    this.button.disabled = refusal !== '';
    this.button.title = refusal || say`Show the patient in the headset`;
    const why = reason || refusal;
    this.help.replaceChildren(h('h3', {}, say`Headset`), why === ''
      ? h('dl', {}, ...CONTROLS.flatMap(([key, what]) => [h('dt', {}, key), h('dd', {}, what)]))
      : h('p', {class: 'muted', 'data-testid': 'headset-reason'}, why));
  }

  /** @private */
  async start_() {
    if (this.isStarting_ || !navigator.xr) {
      return;
    }
    this.isStarting_ = true;
    /** @type {XRSession | null} */
    let session = null;
    try {
      session = await navigator.xr.requestSession('immersive-vr',
        {optionalFeatures: ['local-floor']});
      await this.wear_(session);
    } catch (error) {
      await session?.end().catch(() => {});
      this.mirror_.querySelector('.view')?.remove();
      this.app_.toasts.error(say`The headset could not be started: ${
        error instanceof Error ? error.message : String(error)}`);
    } finally {
      this.isStarting_ = false;
    }
  }

  /** @private @param {XRSession} session */
  async wear_(session) {
    const canvas = h('canvas', {'aria-hidden': 'true', width: 1, height: 1});
    const view = h('div', {class: 'view'}, canvas);
    this.mirror_.prepend(view);
    const worn = new Worn(this.app_, canvas, this.figures_);
    this.session_ = session;
    this.app_.picture.refresh.isWorn = true;
    let why = '';
    const show = () => {
      this.figures_.state = session.visibilityState;
      this.state_.textContent = STATES[session.visibilityState];
    };
    session.addEventListener('visibilitychange', show);
    session.addEventListener('end', () => {
      this.session_ = null;
      this.app_.picture.refresh.isWorn = false;
      this.figures_.state = 'off';
      this.mirror_.hidden = true;
      this.button.setAttribute('aria-pressed', 'false');
      worn.end();
      view.remove();
      if (why !== '') {
        this.app_.toasts.error(why);
      } else {
        this.app_.toasts.info(say`The headset session has ended.`);
      }
    });
    canvas.addEventListener('webglcontextlost', () => {
      if (this.session_ === session) {
        why = say`The headset session has ended: the browser has taken WebGL back.`;
        void session.end();
      }
    });
    this.mirror_.hidden = false;
    this.button.setAttribute('aria-pressed', 'true');
    show();
    await worn.start(session);
  }
}
