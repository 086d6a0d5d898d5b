// Rigid motions: positions, and rotations as unit quaternions. Pure functions; matrices are 4 x 4,
// column-major.

/** @typedef {[number, number, number]} Vector */
/** @typedef {[number, number, number, number]} Quaternion  x, y, z, w. */

/**
 * A motion that first rotates and then moves.
 * @typedef {object} Pose
 * @property {Vector} position
 * @property {Quaternion} turn
 */

/** @type {Quaternion} */
export const NO_TURN = [0, 0, 0, 1];

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @param {Vector} a @param {number} factor @returns {Vector} */
export const times = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a */
export const length = a => Math.hypot(...a);
/** @param {Vector} a  Not zero. */
export const unit = a => times(a, 1 / length(a));

/**
 * The rotation by `b`, then by `a`.
 * @param {Quaternion} a
 * @param {Quaternion} b
 * @returns {Quaternion}
 */
export function product(a, b) {
  const [ax, ay, az, aw] = a, [bx, by, bz, bw] = b;
  return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
}

/** @param {Quaternion} turn @returns {Quaternion} */
export function back([x, y, z, w]) {
  return [-x, -y, -z, w];
}

/**
 * @param {Quaternion} turn
 * @param {Vector} vector
 * @returns {Vector}
 */
export function rotated(turn, vector) {
  const axis = /** @type {Vector} */ ([turn[0], turn[1], turn[2]]);
  const side = times(cross(axis, vector), 2);
  return add(add(vector, times(side, turn[3])), cross(axis, side));
}

/**
 * @param {Vector} axis  A unit vector.
 * @param {number} angle
 * @returns {Quaternion}
 */
export function turnAbout(axis, angle) {
  const sine = Math.sin(angle / 2);
  return [axis[0] * sine, axis[1] * sine, axis[2] * sine, Math.cos(angle / 2)];
}

/**
 * The shortest rotation from one direction to another.
 * @param {Vector} from  Unit vectors.
 * @param {Vector} to
 * @returns {Quaternion}
 */
export function turnBetween(from, to) {
  const axis = cross(from, to), sine = length(axis);
  return sine < 1e-9 ? NO_TURN : turnAbout(times(axis, 1 / sine), Math.atan2(sine, dot(from, to)));
}

/**
 * Spherical interpolation along the shorter way; `share` above 1 extrapolates.
 * @param {Quaternion} a
 * @param {Quaternion} b
 * @param {number} share
 * @returns {Quaternion}
 */
export function slerp(a, b, share) {
  const [x, y, z, w] = product(b, back(a));
  const sine = Math.hypot(x, y, z);
  if (sine < 1e-9) {
    return b;
  }
  const angle = 2 * Math.atan2(w < 0 ? -sine : sine, Math.abs(w));
  return product(turnAbout([x / sine, y / sine, z / sine], angle * share), a);
}

/**
 * The motion by `b`, then by `a`.
 * @param {Pose} a
 * @param {Pose} b
 * @returns {Pose}
 */
export function compose(a, b) {
  return {position: add(a.position, rotated(a.turn, b.position)), turn: product(a.turn, b.turn)};
}

/** @param {Pose} pose @returns {Pose} */
export function inverted({position, turn}) {
  return {position: times(rotated(back(turn), position), -1), turn: back(turn)};
}

/**
 * @param {Pose} pose
 * @param {number} [scale]  Applied before the rotation.
 */
export function matrixOf({position, turn}, scale = 1) {
  const columns = /** @type {Vector[]} */ ([[scale, 0, 0], [0, scale, 0], [0, 0, scale]]);
  return [...columns.flatMap(each => [...rotated(turn, each), 0]), ...position, 1];
}

/** @param {XRRigidTransform} transform @returns {Pose} */
export function poseOf({position, orientation}) {
  return {position: [position.x, position.y, position.z],
    turn: [orientation.x, orientation.y, orientation.z, orientation.w]};
}
