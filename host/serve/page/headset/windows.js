// Off-axis windows around the patient: each eye's picture shows the sphere and little else.
// A head that only turns needs no new pictures, unless it is near or within the patient. No pixel
// shows the room.
import {add, cross, dot, length, minus, rotated, times, unit} from './rigid.js';

/** @typedef {import('./rigid.js').Pose} Pose */
/** @typedef {import('./rigid.js').Vector} Vector */
/** @typedef {import('./placement.js').Sphere} Sphere */

/**
 * What the machine draws an eye's picture with: LPS millimeters to the eye's millimeters, and these
 * to clip coordinates.
 * @typedef {{patient_to_eye: number[], projection: number[]}} EyeWindow
 */

const LEAST_NEAR_MM = 20;
const MARGIN = 1.02;         // Of the sphere's radius.
const WIDEST = 1.6;          // Tangents of a window's edges: 58 degrees off its axis.
const BESIDE = 1.1;          // Nearer to the center than this many radii: no window around it.

/**
 * @param {number[]} edges  Left, right, bottom, top: tangents.
 * @param {number} near
 * @param {number} far
 */
export function frustum([left, right, bottom, top], near, far) {
  const [width, height, depth] = [right - left, top - bottom, far - near];
  return [2 / width, 0, 0, 0, 0, 2 / height, 0, 0, (right + left) / width, (top + bottom) / height,
    -(far + near) / depth, -1, 0, 0, -2 * far * near / depth, 0];
}

/**
 * The edges of a circle as tangents, seen from the origin.
 * @param {number} aside   Of its center.
 * @param {number} ahead   Of its center.
 * @param {number} radius  Less than the distance of the center.
 */
function edgesOf(aside, ahead, radius) {
  const middle = Math.atan2(aside, ahead), half = Math.asin(Math.min(1, radius
    / Math.hypot(aside, ahead)));
  const edge = (/** @type {number} */ angle) => Math.max(-WIDEST, Math.min(WIDEST,
    Math.abs(angle) >= Math.PI / 2 ? Math.sign(angle) * WIDEST : Math.tan(angle)));
  return [edge(middle - half), edge(middle + half)];
}

/**
 * Whether the eyes are so near to the sphere that their windows look where the head looks.
 * @param {Vector[]} eyes  Millimeters, in the patient.
 * @param {import('./placement.js').Sphere} sphere
 */
export function lookAhead(eyes, {center_mm, radius_mm}) {
  const center = /** @type {Vector} */ (center_mm);
  return eyes.some(eye => length(minus(eye, center)) < BESIDE * MARGIN * radius_mm);
}

/**
 * Windows around a sphere, all of one orientation. From near or within the sphere, the windows are
 * wide and look where the head looks.
 * @param {Vector[]} eyes   Positions of the eyes in the patient, millimeters.
 * @param {Pose} head       In the patient.
 * @param {Vector} up       Of the room, in the patient; a unit vector.
 * @param {Sphere} sphere
 * @returns {EyeWindow[]}
 */
export function windowsOf(eyes, head, up, {center_mm, radius_mm}) {
  const center = /** @type {Vector} */ (center_mm), radius = radius_mm * MARGIN;
  const middle = times(eyes.reduce(add), 1 / eyes.length);
  const isBeside = lookAhead(eyes, {center_mm, radius_mm});
  const axes = isBeside ? headAxes(head) : axesTowards(minus(middle, center), up, head);
  return eyes.map(eye => {
    const to = minus(center, eye);
    const [right, above, behind] = axes.map(axis => dot(axis, to)), ahead = -behind;
    const near = Math.max(LEAST_NEAR_MM, ahead - radius);
    const far = Math.max(near + radius, ahead + radius);
    const edges = isBeside ? [-WIDEST, WIDEST, -WIDEST, WIDEST]
      : [...edgesOf(right, ahead, radius), ...edgesOf(above, ahead, radius)];
    const rows = axes.map(axis => [...axis, -dot(axis, eye)]);
    const patient_to_eye = [0, 1, 2, 3].flatMap(column =>
      [...rows.map(row => row[column]), column === 3 ? 1 : 0]);
    return {patient_to_eye, projection: frustum(edges, near, far)};
  });
}

/** @param {Pose} head @returns {Vector[]} right, up, back */
function headAxes({turn}) {
  return [rotated(turn, [1, 0, 0]), rotated(turn, [0, 1, 0]), rotated(turn, [0, 0, 1])];
}

/**
 * @param {Vector} behind  Towards the viewer; not zero.
 * @param {Vector} up
 * @param {Pose} head
 * @returns {Vector[]} right, up, back
 */
function axesTowards(behind, up, head) {
  const axis = unit(behind);
  let right = cross(up, axis);
  if (length(right) < 0.1) {  // From above or below the patient.
    right = cross(cross(axis, rotated(head.turn, [1, 0, 0])), axis);
  }
  right = unit(right);
  return [right, cross(axis, right), axis];
}

/**
 * The pixels of a window that is as sharp as what the headset shows, in whole steps.
 * @param {EyeWindow[]} windows
 * @param {number} focal_px   Of the headset's views: pixels per tangent.
 * @param {{least: number, most: number, step: number}} limits
 * @returns {[number, number]} width and height
 */
export function sizeOf(windows, focal_px, {least, most, step}) {
  const [width, height] = [0, 5].map(at => Math.max(...windows.map(({projection}) =>
    2 / projection[at] * focal_px)));
  const whole = (/** @type {number} */ px) => Math.max(least, Math.min(most,
    Math.ceil(px / step) * step));
  return [whole(width), whole(height)];
}
