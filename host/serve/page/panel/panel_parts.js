// Common parts of the panels: introduction, message line, choices, fields, mode buttons.
import {h, setMessage} from '../elements/dom.js';
import {say} from '../texts/say.js';

/**
 * One line that describes a panel.
 * @param {string} text
 */
export function intro(text) {
  return h('p', {class: 'panel-intro'}, text);
}

/**
 * A line for hints and errors, with a constant height.
 * @param {string} testid
 */
export function messageLine(testid) {
  const line = h('p', {class: 'panel-message', 'data-testid': testid, role: 'status'});
  return {
    element: line,
    /** @param {string} text */
    say(text) {
      line.classList.remove('bad');
      setMessage(line, text, true);
    },
    /**
     * @param {string} text
     * @param {boolean} [isOwn]  See setMessage.
     */
    fail(text, isOwn = true) {
      line.classList.add('bad');
      setMessage(line, text, isOwn);
    },
    /** @param {import('../link/types.js').Reply} reply  A failure. */
    refuse({error, isOwn}) {
      this.fail(error ?? say`The machine did not answer.`, isOwn ?? error === undefined);
    },
  };
}

/**
 * A row of buttons, one of which is chosen.
 * @template {string} Name
 * @param {string} label        For screen readers.
 * @param {{name: Name, title: string, help: string, glyph?: Node}[]} choices  A glyph stands
 *     for the title.
 * @param {(name: Name) => void} choose
 */
export function choiceRow(label, choices, choose) {
  const row = h('div', {class: 'choice-row', role: 'radiogroup', 'aria-label': label});
  const buttons = choices.map(({name, title, help, glyph}) => h('button', {
    type: 'button', role: 'radio', title: help, 'aria-checked': false,
    'data-testid': `choice-${name}`, 'aria-label': glyph && title, onclick: () => set(name),
  }, glyph ?? title));
  row.append(...buttons);
  row.addEventListener('keydown', event => {
    const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    const at = buttons.indexOf(/** @type {HTMLButtonElement} */ (event.target));
    if (step !== 0 && at >= 0) {
      event.stopPropagation();
      const to = (at + step + buttons.length) % buttons.length;
      set(choices[to].name);
      buttons[to].focus();
    }
  });
  /** @param {Name} name */
  function set(name) {
    show(name);
    choose(name);
  }
  /** @param {Name} name */
  function show(name) {
    buttons.forEach((button, index) => {
      const now = choices[index].name === name;
      button.setAttribute('aria-checked', String(now));
      button.tabIndex = now ? 0 : -1;
    });
  }
  show(choices[0].name);
  return {element: row, set, show};
}

/**
 * An input field for a number.
 * @param {string} label
 * @param {string} testid
 * @param {(value: number) => void} change  Called with finite numbers only.
 */
export function numberField(label, testid, change) {
  const input = h('input', {type: 'number', step: 'any', 'data-testid': testid,
    onchange: () => {
      if (input.value.trim() !== '' && Number.isFinite(Number(input.value))) {
        change(Number(input.value));
      }
    }});
  const element = h('label', {class: 'number-field'}, label, input);
  return {element, input};
}

/**
 * A button that enters a mode of the picture (modes.js) and stays pressed during the mode.
 * @param {import('./app.js').App} app
 * @param {{name: string, title: string, hint: string | (() => string), testid: string,
 *   click: (x: number, y: number) => void, leave?: () => void}} what
 */
export function modeButton(app, {name, title, hint, testid, click, leave}) {
  const button = h('button', {type: 'button', class: 'mode', 'aria-pressed': false,
    'data-testid': testid, onclick: () => {
      if (app.modes.current?.name === name) {
        app.modes.leave(name);
      } else {
        app.modes.enter({name, hint: typeof hint === 'string' ? hint : hint(), click, leave});
        // The mode ends when its panel is hidden.
        button.closest('[role=tabpanel]')?.addEventListener('panelhide',
          () => app.modes.leave(name), {once: true});
      }
    }}, title);
  app.modes.watch(mode => button.setAttribute('aria-pressed', String(mode?.name === name)));
  return button;
}

/**
 * The message of an exception.
 * @param {unknown} error
 */
export function sentenceOf(error) {
  return error instanceof Error ? error.message : String(error);
}

const MOST_SHOWN = 60;      // Letters of a wrong value in an error.

/**
 * A wrong value as an error shows it.
 * @param {unknown} value
 */
export function shown(value) {
  const text = JSON.stringify(value) ?? say`missing`;
  return text.length > MOST_SHOWN ? `${text.slice(0, MOST_SHOWN)}…` : text;
}
