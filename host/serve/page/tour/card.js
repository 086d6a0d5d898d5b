// The card of the tour: the step's text, links to all steps, and buttons.
import {byId, h, setText, update} from '../elements/dom.js';
import {say} from '../texts/say.js';
import {STEP_COUNT, hashOf} from './address.js';
import {STEPS} from './texts.js';

/** @typedef {import('./address.js').Pixel} Pixel */

export class Card {
  /**
   * @param {{go: (step: number) => void, close: () => void, again: () => void}} acts
   */
  constructor({go, close, again}) {
    /** @private */
    this.count_ = h('p', {class: 'muted small', 'data-testid': 'tour-count'});
    this.title = h('h2', {id: 'tour-title', tabindex: -1, 'data-testid': 'tour-title'});
    /** @private */
    this.text_ = h('div', {class: 'tour-text', 'data-testid': 'tour-text', 'aria-live': 'polite',
      tabindex: 0, role: 'group', 'aria-labelledby': 'tour-title'});
    /** @private */
    this.message_ = h('p', {class: 'panel-message', role: 'status',
      'data-testid': 'tour-message'});
    /** @private */
    this.again_ = h('button', {type: 'button', hidden: true, 'data-testid': 'tour-again',
      onclick: again}, say`Ask again`);
    /** @private */
    this.links_ = STEPS.map(({title}, index) => h('a', {title,
      'aria-label': say`Step ${index + 1}: ${title}`, 'data-testid': `tour-link-${index + 1}`},
    index + 1));
    /** @private */
    this.back_ = h('button', {type: 'button', 'data-testid': 'tour-back',
      onclick: () => go(this.step_ - 1)}, say`Back`);
    /** @private */
    this.next_ = h('button', {type: 'button', class: 'primary', 'data-testid': 'tour-next',
      onclick: () => this.step_ < STEP_COUNT ? go(this.step_ + 1) : close()});
    /** @private */
    this.step_ = 1;
    this.element = h('section', {id: 'tour', 'aria-labelledby': 'tour-title', hidden: true,
      'data-testid': 'tour'},
    h('div', {class: 'row spread'}, this.count_, h('button', {class: 'quiet icon',
      'aria-label': say`Close the tour`, title: say`Close the tour (Esc)`,
      'data-testid': 'tour-close', onclick: close}, '×')),
    this.title, this.text_, h('div', {class: 'row wrap'}, this.message_, this.again_),
    h('div', {class: 'row wrap'},
      h('nav', {class: 'tour-steps', 'aria-label': say`Steps of the tour`}, ...this.links_),
      h('div', {class: 'row tour-moves'}, this.back_, this.next_)));
    this.element.addEventListener('keydown', event => {
      if (event.key === 'Escape') {
        event.stopPropagation();
        close();
      }
    });
    byId('right').prepend(this.element);
  }

  /**
   * @param {number} step
   * @param {Pixel | null} pixel  Of the user.
   */
  show(step, pixel) {
    this.step_ = step;
    this.element.hidden = false;
    setText(this.count_, say`Tour of the machine: step ${step} of ${STEP_COUNT}`);
    setText(this.title, STEPS[step - 1].title);
    setText(this.next_, step < STEP_COUNT ? say`Next` : say`Close`);
    this.back_.disabled = step === 1;
    this.links_.forEach((link, index) => {
      link.href = hashOf(index + 1, pixel);
      update(link, {'aria-current': index + 1 === step ? 'step' : null});
    });
  }

  /**
   * @param {string[]} paragraphs
   * @param {boolean} isOld   The scene has changed since.
   */
  write(paragraphs, isOld) {
    this.text_.classList.toggle('outdated', isOld);
    const now = [...this.text_.children].map(({textContent}) => textContent);
    // A screen reader reads what is replaced.
    if (now.join('\n') !== paragraphs.join('\n')) {
      this.text_.replaceChildren(...paragraphs.map(each => h('p', {}, each)));
    }
  }

  /**
   * @param {string} sentence  '' for none.
   * @param {boolean} canRetry
   */
  say(sentence, canRetry = false) {
    setText(this.message_, sentence);
    this.message_.classList.toggle('bad', canRetry);
    this.again_.hidden = !canRetry;
  }
}
