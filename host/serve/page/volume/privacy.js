// Hints before a scan is shared: a patient's name, and a face.
import {h} from '../elements/dom.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/**
 * @typedef {object} Facts
 * @property {boolean} isDicom
 * @property {boolean} hasName   The header has a patient's name.
 * @property {string} modality   '' if unknown.
 * @property {string} bodyPart   BodyPartExamined; '' if unknown.
 */

// Parts of the body without a face (DICOM PS3.16, annex L). Any other word may mean a head, in any
// language. Skin is rarely seen in ultrasound, and never in PET.
const NO_HEAD = new RegExp('^(CHEST|THORAX|HEART|CORONARY|LUNGS?|BREASTS?|RIBS?|STERNUM|ABDOMEN'
  + '|LIVER|KIDNEYS?|PANCREAS|SPLEEN|COLON|PELVIS|BLADDER|PROSTATE|UTERUS|HIPS?|TSPINE|LSPINE'
  + '|SSPINE|COCCYX|SHOULDERS?|CLAVICLE|SCAPULA|ARMS?|ELBOWS?|FOREARMS?|WRISTS?|HANDS?|FINGERS?'
  + '|LEGS?|THIGHS?|FEMUR|KNEES?|CALF|ANKLES?|FOOT|FEET|TOES?|EXTREMITY)$');
const SHOWS_SKIN = new Set(['CT', 'MR', '']);

/**
 * Sentences; '' if there is nothing to say.
 * @param {Facts} facts
 */
export function privacyText({isDicom, hasName, modality, bodyPart}) {
  const sentences = [];
  if (hasName) {
    sentences.push(say`The header of this scan contains a patient's name. So may the names of its
      files and folders, other attributes, and the pictures. Check them before you share
      anything.`);
  } else if (!isDicom) {
    sentences.push(say`This page cannot tell whether the file names a patient.`);
  }
  const hasNoHead = bodyPart.toUpperCase().split(/[^A-Z]+/).every(word => NO_HEAD.test(word));
  if (SHOWS_SKIN.has(modality) && bodyPart === '') {
    if (isDicom) {
      sentences.push(say`The header does not state the part of the body.`);
    }
    sentences.push(say`If the scan shows a head, a face can be recognized from the surface of the
      skin.`);
  } else if (SHOWS_SKIN.has(modality) && !hasNoHead) {
    sentences.push(say`The header states the part "${bodyPart}". If a head is seen, a face can be
      recognized from the surface of the skin.`);
  }
  return sentences.join(' ');
}

/**
 * @param {any} json  Answer of the question `attributes`.
 * @returns {Facts}
 */
export function factsOf(json) {
  const value = (/** @type {number} */ group, /** @type {number} */ element) =>
    String(json.attributes.find((/** @type {any[]} */ row) =>
      row[0] === group && row[1] === element && row[2] === 0)?.[5] ?? '');
  return {isDicom: true, hasName: /[^\s^=]/.test(value(0x10, 0x10)), modality: value(0x8, 0x60),
    bodyPart: value(0x18, 0x15)};
}

/**
 * A line that is filled by `show` before something is saved.
 * @param {App} app
 */
export function createPrivacyHint(app) {
  const root = h('p', {class: 'muted privacy', role: 'note', hidden: true,
    'data-testid': 'privacy'});
  let known = '';  // Identity of the volume that the text is about.
  const show = async () => {
    const volume = app.store.state?.volume;
    if (!volume || volume.source.startsWith('phantom:')) {
      known = '';
      root.hidden = true;
      return;
    }
    if (known === volume.series_identity) {
      return;
    }
    const {series_identity: identity} = volume;
    known = identity;
    root.textContent = say`Looking for a patient's name in the header …`;
    root.hidden = false;
    /** @type {Facts} */
    let facts = {isDicom: false, hasName: false, modality: volume.modality, bodyPart: ''};
    let isRead = true;
    try {
      facts = factsOf((await app.connection.ask({ask: 'attributes'})).json);
    } catch {
      isRead = false;  // No DICOM file, or it cannot be read now: less is known.
    }
    if (known === identity) {
      root.textContent = privacyText(facts);
      root.hidden = root.textContent === '';
      known = isRead ? identity : '';  // The next time asks again.
    }
  };
  return {root, show};
}
