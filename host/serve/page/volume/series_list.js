// The series of a folder, of which one is to be chosen: by patient and study, with thumbnails.
import {h} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {say} from '../texts/say.js';
import {sizeText, UPLOAD} from './words.js';

/** @typedef {import('../panel/app.js').App} App */
/**
 * A row of the answer `series`.
 * @typedef {{number: number, uid: string, patient: string, patient_id: string, study: string,
 *   study_date: string, study_description: string, description: string, series_number: number,
 *   modality: string, body_part: string, date: string, columns: number, rows: number,
 *   slices: number, bytes: number,
 *   thumbnail?: {first: number, width: number, height: number}}} Row
 */

/** @param {App} app */
export function createSeries(app) {
  const groups = h('div', {class: 'series'}), title = h('p', {role: 'alert'});
  const note = h('p', {class: 'muted', role: 'status', 'data-testid': 'series-note'});
  const root = h('div', {hidden: true, role: 'group', 'aria-label': say`Series of the folder`,
    'data-testid': 'open-choice'}, title, note, groups);
  let asked = 0;
  /**
   * Fills in patients, studies and thumbnails when they come.
   * @param {string} source
   * @param {(number: string) => void} choose
   */
  const fill = async (source, choose) => {
    const number = ++asked;
    note.textContent = say`Reading thumbnails …`;
    try {
      const {json, bytes} = await app.connection.ask({ask: 'series', path: source});
      if (number === asked) {
        const focused = document.activeElement?.getAttribute('data-testid');
        groups.replaceChildren(...patientsOf(json.series, bytes, choose));
        note.textContent = noteOf(json);
        if (focused?.startsWith('series-')) {  // A key may be on its way to it.
          /** @type {HTMLElement | null} */
          (groups.querySelector(`[data-testid="${focused}"]`))?.focus();
        }
      }
    } catch (error) {
      if (number === asked) {
        note.textContent = say`No thumbnails: ${/** @type {Error} */ (error).message
          .replace(UPLOAD, '')}`;
      }
    }
  };
  return {
    root,
    /**
     * Returns whether there is a choice.
     * @param {string} error  Lines of the form "2: UID 'description', CT, 512x512x112".
     * @param {string} source  Path on the server.
     * @param {(number: string) => void} choose
     */
    show: (error, source, choose) => {
      const found = [...error.matchAll(/^ +(\d+): (?:\S+|\(no UID\)) '(.*)', (.*)$/gm)];
      asked++;  // Thumbnails of another folder come too late.
      root.hidden = found.length === 0;
      const [, count = String(found.length)] = error.match(/ holds (\d+)[ :]/) ?? [];
      title.textContent = root.hidden ? ''
        : say`${error.split(':')[0]} has ${count} series. Choose one:`;
      groups.replaceChildren(h('div', {class: 'cards'}, ...found.map(([, number, name, about]) =>
        card(number, name, [about.replace(/(\d)x(?=\d)/g, '$1 × ')], null, choose))));
      if (found.length > 0) {
        /** @type {HTMLElement | null} */ (groups.querySelector('button'))?.focus();
        void fill(source, choose);
      }
      return found.length > 0;
    },
  };
}

/**
 * @param {string} number
 * @param {string} name
 * @param {(Node | string)[]} about
 * @param {HTMLElement | null} picture
 * @param {(number: string) => void} choose
 */
function card(number, name, about, picture, choose) {
  return h('button', {class: 'card', type: 'button', 'data-testid': `series-${number}`,
    onclick: () => choose(number)},
    picture, h('span', {class: 'words'}, h('strong', {}, name || say`Series ${number}`),
      h('span', {class: 'muted'}, ...about)));
}

/**
 * @param {Row[]} rows
 * @param {ArrayBuffer} bytes
 * @param {(number: string) => void} choose
 */
function patientsOf(rows, bytes, choose) {
  return groupsOf(rows, row => `${row.patient_id}\n${row.patient}`).map(ofPatient =>
    h('section', {'data-testid': 'patient'},
      h('h3', {}, patientText(ofPatient[0])),
      ...groupsOf(ofPatient, row => row.study).map(ofStudy =>
        h('section', {'data-testid': 'study'},
          h('h4', {class: 'muted'}, studyText(ofStudy[0])),
          h('div', {class: 'cards'}, ...ofStudy.map(row =>
            card(String(row.number), row.description, aboutOf(row), pictureOf(row, bytes),
                 choose)))))));
}

/**
 * Rows by key, in the order of their first rows.
 * @param {Row[]} rows
 * @param {(row: Row) => string} keyOf
 */
function groupsOf(rows, keyOf) {
  /** @type {Map<string, Row[]>} */
  const groups = new Map();
  for (const row of rows) {
    groups.set(keyOf(row), [...groups.get(keyOf(row)) ?? [], row]);
  }
  return [...groups.values()];
}

/** @param {Row} row */
function patientText({patient, patient_id: id}) {
  return [patient || say`Patient without a name`, id === '' ? '' : say`ID ${id}`]
    .filter(Boolean).join(', ');
}

/** @param {Row} row */
function studyText({study_date: date, study_description: about}) {
  return [about || say`Study`, dicomDate(date)].filter(Boolean).join(', ');
}

/**
 * "CT, chest, 512 × 512 × 112, 59 MB", and the date if it is not that of the study.
 * @param {Row} row
 * @returns {(Node | string)[]}
 */
function aboutOf(row) {
  const first = [row.modality, row.body_part.toLowerCase()].filter(Boolean);
  const whole = [`${row.columns} × ${row.rows} × ${row.slices}`, sizeText(row.bytes),
    row.date === row.study_date ? '' : dicomDate(row.date)].filter(Boolean);
  return [first.map(each => `${each}, `).join(''), ...whole.flatMap((each, at) =>
    [at === 0 ? '' : ', ', h('span', {class: 'whole'}, each)])];
}

/**
 * "20261126" as "2026-11-26"; other texts stay.
 * @param {string} date
 */
export function dicomDate(date) {
  return date.replace(/^(\d{4})(\d\d)(\d\d)$/, '$1-$2-$3');
}

/**
 * @param {Row} row
 * @param {ArrayBuffer} bytes
 */
function pictureOf({thumbnail}, bytes) {
  if (!thumbnail) {
    return h('span', {class: 'thumbnail', 'data-testid': 'no-thumbnail'});
  }
  const {first, width, height} = thumbnail;
  const canvas = h('canvas', {class: 'thumbnail', width, height, 'data-testid': 'thumbnail',
    'aria-hidden': 'true'});
  const rgba = new ImageData(width, height);
  new Uint8Array(bytes, first, width * height).forEach((gray, at) =>
    rgba.data.set([gray, gray, gray, 255], 4 * at));
  canvas.getContext('2d')?.putImageData(rgba, 0, 0);
  return canvas;
}

/** @param {{series: Row[], more: number, note: string}} json */
function noteOf({series, more, note}) {
  const without = series.filter(({thumbnail}) => !thumbnail).length;
  const sentences = [];
  if (more > 0) {
    sentences.push(say`${grouped(more)} more series are not listed: open a part of the folder, or
      give the option Series.`);
  }
  if (without > 0) {
    sentences.push(note
      ? say`No thumbnail for ${without} of ${series.length} series: ${note.replace(UPLOAD, '')}`
      : say`No thumbnail for ${without} of ${series.length} series.`);
  }
  return sentences.join(' ');
}
