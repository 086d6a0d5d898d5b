// The room around the patient: floor, letters, size, distances, hands, sentences.
import {significant} from '../elements/numbers.js';
import {SIDES} from '../picture/projection.js';
import {say} from '../texts/say.js';
import {add, cross, dot, length, minus, rotated, times, unit} from './rigid.js';

/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {import('./placement.js').Placement} Placement */
/** @typedef {import('./placement.js').Sphere} Sphere */
/** @typedef {import('./room_painter.js').Line} Line */
/** @typedef {import('./room_painter.js').Label} Label */
/** @typedef {import('./hands.js').Hand} Hand */
/** @typedef {{a_mm: Vector, b_mm: Vector, text: string}} Length */

const FLOOR_M = 3;
const TILE_M = 0.5;
const LETTERS_AT = 1.1;       // Radii from the center.
const ACCENT = [0.42, 0.7, 0.96];
const GRIP_M = 0.1;           // Length of a hand's line.

/** @param {string} background  #rrggbb */
export function isLight(background) {
  const [red, green, blue] = [1, 3, 5].map(at => parseInt(background.slice(at, at + 2), 16));
  return 0.3 * red + 0.59 * green + 0.11 * blue > 128;
}

/**
 * The floor, in tiles around a viewer.
 * @param {Pose} head
 * @param {boolean} onLight
 * @returns {Line[]}
 */
function floorLines({position}, onLight) {
  const color = onLight ? [0, 0, 0, 0.35] : [1, 1, 1, 0.3];
  const [x, z] = [position[0], position[2]].map(each => Math.round(each / TILE_M) * TILE_M);
  /** @type {Line[]} */
  const lines = [];
  // Pieces of a tile each: the fading is linear along a piece.
  for (let across = -FLOOR_M; across <= FLOOR_M; across += TILE_M) {
    for (let along = -FLOOR_M; along < FLOOR_M; along += TILE_M) {
      lines.push({from: [x + across, 0, z + along], to: [x + across, 0, z + along + TILE_M], color},
        {from: [x + along, 0, z + across], to: [x + along + TILE_M, 0, z + across], color});
    }
  }
  return lines;
}

/**
 * The outline of a cut across the sphere.
 * @param {Placement} placement
 * @param {Sphere} sphere
 * @param {{letter: string, at_mm: number}} cut
 * @returns {Line[]}
 */
function cutLines(placement, {center_mm, radius_mm}, {letter, at_mm}) {
  const towards = SIDES.find(each => each.letter === letter)?.towards ?? [0, 0, 1];
  const center = /** @type {Vector} */ (center_mm);
  const middle = add(center, times(towards, at_mm - dot(center, towards)));
  const a = unit(cross(towards, towards[2] === 0 ? [0, 0, 1] : [0, 1, 0])), b = cross(towards, a);
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => placement.toWorld(
    add(middle, add(times(a, u * radius_mm), times(b, v * radius_mm)))));
  return corners.map((from, at) => ({from, to: corners[(at + 1) % 4], color: [...ACCENT, 1]}));
}

/**
 * @param {Hand} hand
 * @returns {Line[]} where it points, and a cross at its tip
 */
function handLines({grip, tip}) {
  const color = [...ACCENT, 1], size = 0.008;
  const axes = /** @type {Vector[]} */ ([[size, 0, 0], [0, size, 0], [0, 0, size]]);
  const behind = add(tip, rotated(grip.turn, [0, 0, GRIP_M]));
  return [{from: behind, to: tip, color}, ...axes.map(axis => rotated(grip.turn, axis))
    .map(axis => ({from: minus(tip, axis), to: add(tip, axis), color}))];
}

/** @param {number} magnification */
export function sizeText(magnification) {
  if (Math.abs(magnification - 1) < 0.005) {
    return say`natural size`;
  }
  return say`${significant(magnification, magnification < 10 ? 2 : 3)} × natural size`;
}

/**
 * Everything that the room has in a frame.
 * @param {object} scene
 * @param {Placement} scene.placement
 * @param {Sphere | null} scene.sphere  Null: there is no patient.
 * @param {string} scene.background     #rrggbb
 * @param {Pose} scene.head
 * @param {Hand[]} scene.hands
 * @param {{letter: string, at_mm: number} | null} scene.cut  Under the hand.
 * @param {Length[]} scene.lengths
 * @param {string} scene.value          About the isovalue that is being changed, or ''.
 * @param {string} scene.sentence       For the viewer, or ''.
 * @returns {{lines: Line[], labels: Label[]}}
 */
export function roomOf({placement, sphere, background, head, hands, cut, lengths, value,
  sentence}) {
  const onLight = isLight(background), ink = onLight ? '#111' : '#fff';
  const lines = [...floorLines(head, onLight), ...hands.flatMap(handLines)];
  /** @type {Label[]} */
  const labels = [];
  const ahead = rotated(head.turn, [0, 0, -1]);
  let below = add(head.position, times(ahead, 0.8));
  if (sphere) {
    const radius = sphere.radius_mm * placement.scale;
    const center = placement.toWorld(/** @type {Vector} */ (sphere.center_mm));
    const height = Math.max(0.02, Math.min(0.06, radius * 0.14));
    for (const {letter, towards} of SIDES) {
      labels.push({text: letter, color: ink, height, at: add(center,
        times(placement.directionToWorld(towards), LETTERS_AT * radius))});
    }
    below = add(center, [0, -LETTERS_AT * radius - 2 * height, 0]);
    labels.push({text: sizeText(placement.magnification), color: ink, height: height * 0.6,
      at: below});
    if (cut) {
      lines.push(...cutLines(placement, sphere, cut));
    }
  }
  for (const {a_mm, b_mm, text} of lengths) {
    const [a, b] = [placement.toWorld(a_mm), placement.toWorld(b_mm)];
    lines.push({from: a, to: b, color: [1, 0.85, 0.4, 1]});
    labels.push({text, color: '#ffd966', height: 0.018, boxed: true,
      at: add(times(add(a, b), 0.5), [0, 0.025, 0])});
  }
  if (value !== '') {
    const [hand] = hands;
    labels.push({text: value, color: '#fff', height: 0.018, boxed: true,
      at: add(hand?.tip ?? below, [0, 0.05, 0])});
  }
  if (sentence !== '') {
    // Before the viewer, nearer than the patient, a little below the middle.
    const flat = /** @type {Vector} */ ([ahead[0], 0, ahead[2]]);
    const towards = length(flat) < 0.1 ? ahead : unit(flat);
    labels.push({text: sentence, color: '#e8bd6a', height: 0.016, boxed: true,
      at: add(add(head.position, times(towards, 0.5)), [0, -0.12, 0])});
  }
  return {lines, labels};
}
