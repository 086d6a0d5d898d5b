// The tour of the machine: follows one pixel of the scene through the machine, in six steps. The
// panels ask the machine; the tour opens them and puts their answers into words.
import {byId} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {hashOf, stepOf} from './address.js';
import {Card} from './card.js';
import {evaluationOf, sentPixels, shownOf} from './facts.js';
import {findPixel} from './find_pixel.js';
import {STEPS} from './texts.js';

/** @typedef {import('./address.js').Pixel} Pixel */
/** @typedef {import('./facts.js').Facts} Facts */
/** @typedef {import('../inspect/inspector.js').Explained} Explained */
/** @typedef {import('../machine/model_view.js').Estimated} Estimated */

const DEADLINE_MS = 20_000;     // For the answers of a step.
const CLOCK = STEPS.length;     // The step that needs an estimate, and no pixel.
const NO_SURFACE = say`The tour found no surface in the picture. Show a surface, or move it to the
  middle of the picture. The tour then continues.`;
const NO_ANSWER = say`The machine has not answered for 20 s.`;
const ASKING = say`Asking the machine …`;
const CHANGED = say`The picture has changed. Asking the machine again …`;
const OUTSIDE = say`The pixel of this address is outside of the picture. The tour follows another
  pixel.`;
const WATCHES = say`A view-only page cannot ask about a pixel. These are the numbers that every page
  gets.`;

class Tour {
  /**
   * @param {import('../panel/app.js').App} app
   * @param {(id: string) => void} showTab
   */
  constructor(app, showTab) {
    this.app = app;
    this.showTab = showTab;
    /** 1 to 6; 0: the tour is closed. */
    this.step = 0;
    /** The pixel of the user; null if the tour chooses. @type {Pixel | null} */
    this.wish = null;
    /** Revisions of the scene that the answers are about, 0 before the first answer. */
    this.revisions = {why: 0, modelled: 0};
    /** @type {Omit<Facts, 'state' | 'watches'>} */
    this.facts = {why: null, stream: null, report: null, frame: null, modelled: null};
    /** Reports since the step began. The first counts from long before the step. */
    this.reports = 0;
    /** What the step has done. asked: the revision of its question, or -1. */
    this.course = {asked: -1, isDrawn: false, isShown: false};
    /** The pixel of the last question of the tour. @type {Pixel | null} */
    this.askedPixel = null;
    this.note = '';
    this.timer = 0;
    /** @type {Element | null}  Had the focus before the tour. */
    this.opener = null;
    this.card = new Card({go: step => this.go(step), close: () => this.close(),
      again: () => this.enter()});
    this.listen();
  }

  listen() {
    const {connection, picture, store} = this.app;
    addEventListener('hashchange', () => this.follow());
    connection.on('hello', () => this.follow());
    connection.on('machine', report => this.takeReport(report));
    picture.onShown(() => this.compare());
    store.subscribe(['revision', 'busy'], () => {
      this.compare();
      this.write();
    });
    document.addEventListener('explained', event =>
      this.takeWhy(/** @type {CustomEvent<Explained>} */ (event).detail));
    document.addEventListener('stepped', event => {
      this.facts.stream = /** @type {CustomEvent} */ (event).detail;
      this.compare();
      this.write();
    });
    document.addEventListener('estimated', event =>
      this.takeEstimate(/** @type {CustomEvent<Estimated>} */ (event).detail));
  }

  /** Opens the step that the address names, or closes the tour. */
  follow() {
    const named = stepOf(location.hash);
    if (!named || !this.app.connection.hello) {
      this.hide();
      return;
    }
    const isOpening = this.step === 0;
    this.opener = isOpening ? document.activeElement : this.opener;
    this.step = named.step;
    this.wish = named.pixel;
    document.body.classList.add('touring');
    this.card.show(this.step, this.wish);
    if (isOpening) {
      this.card.title.focus({preventScroll: true});
    }
    this.enter();
  }

  /** @param {number} step */
  go(step) {
    location.hash = hashOf(step, this.wish);
  }

  close() {
    history.replaceState(null, '', location.pathname + location.search);
    this.hide();
  }

  hide() {
    if (this.step !== 0) {
      this.step = 0;
      clearTimeout(this.timer);
      this.card.element.hidden = true;
      document.body.classList.remove('touring');
      if (this.opener instanceof HTMLElement) {
        this.opener.focus({preventScroll: true});
      }
    }
  }

  /** Opens the panel of the step and asks for what the step does not know yet. */
  enter() {
    const {watches} = this.app.connection;
    const {panel, watched} = STEPS[this.step - 1];
    if (!this.app.layout.now.right) {
      this.app.layout.toggle('right');
    }
    this.showTab(watches ? watched : panel);
    this.reports = 0;
    this.facts.report = null;
    this.course = {asked: -1, isDrawn: false, isShown: false};
    this.card.say(watches ? WATCHES : ASKING);
    this.write();
    this.scroll();
    if (!watches) {
      this.expect();
      this.compare();
    }
  }

  /** Reports an error if no answer arrives within DEADLINE_MS. */
  expect() {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.card.say(NO_ANSWER, true), DEADLINE_MS);
  }

  /** The revision of the scene, if the picture shows it and rests; else null. */
  resting() {
    const {state} = this.app.store, {header} = this.app.picture;
    return state && !state.busy && header?.rests && header.revision === state.revision
      ? state.revision : null;
  }

  /** Whether the scene has changed since the answers. */
  isOld() {
    const {why, modelled} = this.revisions;
    const revision = this.step === CLOCK ? modelled : why;
    return revision !== 0 && revision !== this.app.store.state?.revision;
  }

  /** Shows the answers, or asks if they are missing or old, as soon as the picture rests. */
  compare() {
    if (this.step === 0 || this.app.connection.watches) {
      return;
    }
    if (this.isOld() && this.course.isShown) {
      this.course = {asked: -1, isDrawn: false, isShown: false};
      this.facts.report = null;
      this.card.say(CHANGED);
      this.write();
    }
    const revision = this.resting();
    if (revision === null) {
      return;
    }
    if (this.isKnown(revision)) {
      this.show();
    } else if (this.needsReport() && this.isExplained(revision)) {
      this.drawOnce();
    } else if (this.course.asked !== revision) {
      this.course = {asked: revision, isDrawn: false, isShown: false};
      this.facts.report = null;
      this.expect();
      if (this.step === CLOCK) {
        document.dispatchEvent(new Event('estimate'));
      } else {
        void this.explain(revision);
      }
    }
  }

  /** An estimate draws the scene again, so that the next report counts the messages of a frame. */
  drawOnce() {
    if (this.reports > 0 && !this.course.isDrawn) {
      this.course.isDrawn = true;
      this.expect();
      document.dispatchEvent(new Event('estimate'));
    }
  }

  needsReport() {
    return STEPS[this.step - 1].part === 'ring';
  }

  needsStream() {
    return STEPS[this.step - 1].part === 'stream';
  }

  /**
   * Whether the answers that the step needs are about this revision of the scene.
   * @param {number} revision
   */
  isKnown(revision) {
    const {why, report, stream} = this.facts;
    if (this.step === CLOCK) {
      return this.revisions.modelled === revision;
    }
    return this.isExplained(revision) && (why === null
      || (!this.needsReport() || report !== null) && (!this.needsStream() || stream !== null));
  }

  /**
   * Whether the pixel of the tour is explained for this revision.
   * @param {number} revision
   */
  isExplained(revision) {
    const {why} = this.facts;
    return this.revisions.why === revision
      && (!this.wish || isSamePixel(this.wish, why));
  }

  /**
   * Asks why the pixel has its color.
   * @param {number} revision  Of the scene.
   */
  async explain(revision) {
    const {state} = this.app.store, {why} = this.facts;
    const [width, height] = this.app.picture.wholeSize(state?.size ?? [0, 0]);
    if (this.wish && (this.wish.x >= width || this.wish.y >= height)) {
      this.note = OUTSIDE;
      this.follow_(null);
    }
    const isKept = why && this.revisions.why === revision;
    const found = this.wish ?? (isKept ? {x: why.x, y: why.y} : await findPixel(this.app));
    const pixel = this.wish ?? found;  // The user may have asked meanwhile.
    this.askedPixel = pixel;
    if (this.course.asked !== revision || this.app.store.state?.revision !== revision) {
      // The scene has changed meanwhile: the pixel may be another one in its picture.
      this.course.asked = this.course.asked === revision ? -1 : this.course.asked;
      this.compare();
      return;
    }
    if (pixel) {
      document.dispatchEvent(new CustomEvent('explain', {detail: pixel}));
    } else {
      this.takeWhy({result: null, revision, error: '', by: 'tour'});
    }
  }

  /**
   * @private
   * @param {Pixel | null} pixel  The wish of the user.
   */
  follow_(pixel) {
    this.wish = pixel;
    history.replaceState(null, '', hashOf(this.step, pixel));
    this.card.show(this.step, pixel);
  }

  /** @param {Explained} explained */
  takeWhy({result, revision, error, by}) {
    this.facts.why = result;
    this.facts.stream = null;
    this.revisions.why = revision;
    if (this.step > 0 && result && by === 'user') {
      this.follow_({x: result.x, y: result.y});
    }
    if (this.wish && !isSamePixel(this.wish, this.askedPixel)) {
      this.course.asked = -1;  // The user has asked about another pixel than the tour.
    }
    if (this.step !== CLOCK) {
      this.course.isShown = false;
      this.take(error);
    }
  }

  /** @param {Estimated} estimated */
  takeEstimate({result, revision, error}) {
    this.facts.modelled = result;
    this.revisions.modelled = revision;
    if (this.step === CLOCK) {
      this.take(error);
    } else if (this.step > 0) {
      this.scroll();  // The panel has scrolled to the estimate.
    }
  }

  /**
   * An answer of the machine.
   * @param {string} error
   */
  take(error) {
    if (this.step === 0) {
      return;
    }
    if (error) {
      clearTimeout(this.timer);
      this.card.say(error, true);
    } else {
      this.compare();
    }
    this.write();
  }

  /** @param {import('./facts.js').MachineReport} report */
  takeReport(report) {
    this.reports += 1;
    if (this.step > 0 && this.reports === 1) {
      queueMicrotask(() => this.scroll());  // The panel has contents now.
    }
    this.facts.frame = report.frame ?? null;
    const {why} = this.facts, {watches} = this.app.connection;
    const ours = watches ? null : why?.renderer ?? null;
    const isWanted = sentPixels(report, ours).messages > 0
      && (this.course.isDrawn || watches && this.reports > 1);
    if (this.step > 0 && isWanted && (watches || !this.facts.report)) {
      this.facts.report = report;
    }
    this.compare();
    this.write();
  }

  /** Shows the answers, and the part of the panel that they are about. */
  show() {
    const {why} = this.facts;
    if (this.course.isShown) {
      return;
    }
    this.course.isShown = true;
    clearTimeout(this.timer);
    this.card.say(!why && this.step !== CLOCK ? NO_SURFACE : this.note);
    this.note = '';
    const at = this.step === 3 ? shownOf(this.all())?.writes[0]?.at
      : this.step === 4 ? evaluationOf(this.all())?.at : undefined;
    if (at !== undefined) {
      document.dispatchEvent(new CustomEvent('step-to', {detail: at}));
    }
    this.write();
    this.scroll();
  }

  /** @returns {Facts} */
  all() {
    const {store, connection} = this.app;
    return {...this.facts, watches: connection.watches,
      state: /** @type {import('./facts.js').State} */ (store.state)};
  }

  /** Writes what is known. */
  write() {
    if (this.step > 0 && this.app.store.state) {
      this.card.write(STEPS[this.step - 1].text(this.all()), this.isOld());
    }
  }

  /** Scrolls the panel to the part that the step is about. */
  scroll() {
    const {element} = this.card;
    const part = byId('panels').querySelector(`[data-testid="${STEPS[this.step - 1]?.part}"]`);
    if (part instanceof HTMLElement) {
      const isOver = getComputedStyle(element).position === 'sticky';
      part.style.scrollMarginTop = isOver ? `${element.offsetHeight}px` : '';
      part.scrollIntoView({block: 'start'});
    }
  }
}

/** @param {Pixel} pixel @param {Pixel | null} other */
function isSamePixel(pixel, other) {
  return pixel.x === other?.x && pixel.y === other?.y;
}

/**
 * @param {import('../panel/app.js').App} app
 * @param {(id: string) => void} showTab
 * @returns {{open: () => void, close: () => void}}
 */
export function createTour(app, showTab) {
  const tour = new Tour(app, showTab);
  return {
    open: () => tour.go(1),
    close: () => { if (tour.step !== 0) { tour.close(); } },
  };
}
