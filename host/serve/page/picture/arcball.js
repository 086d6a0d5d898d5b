// The mathematics of rotation: a ball under the pointer, and view angles. Pure functions.

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {[Triple, Triple, Triple]} Rotation  Rows: the eye's right, up, back in the patient. */
/** @typedef {{azimuth_deg: number, elevation_deg: number, roll_deg: number}} Angles */

const DEGREE = Math.PI / 180;

/** @param {Triple} a @param {Triple} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {Triple} a @param {Triple} b @returns {Triple} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0]];
/** @param {Triple} a @param {number} x @param {Triple} b @param {number} y @returns {Triple} */
const blend = (a, x, b, y) => [a[0] * x + b[0] * y, a[1] * x + b[1] * y, a[2] * x + b[2] * y];
/** @param {Triple} a @returns {Triple} */
const unit = a => {
  const length = Math.hypot(...a);
  return [a[0] / length, a[1] / length, a[2] / length];
};

/** @param {number} azimuth @returns {Triple} */
const levelRight = azimuth => [Math.cos(azimuth), Math.sin(azimuth), 0];

/**
 * The eye's axes, as host/scene/camera.cpp makes them: azimuth 0 is in front of the patient, 90 at
 * the patient's left; roll turns the picture counter-clockwise.
 * @param {Angles} angles
 * @returns {Rotation}
 */
export function rotationOf({azimuth_deg, elevation_deg, roll_deg}) {
  const azimuth = azimuth_deg * DEGREE, elevation = elevation_deg * DEGREE;
  const roll = roll_deg * DEGREE;
  const back = /** @type {Triple} */ ([Math.sin(azimuth) * Math.cos(elevation),
    -Math.cos(azimuth) * Math.cos(elevation), Math.sin(elevation)]);
  const right = levelRight(azimuth), up = cross(back, right);
  return [blend(right, Math.cos(roll), up, -Math.sin(roll)),
    blend(right, Math.sin(roll), up, Math.cos(roll)), back];
}

/**
 * The angles of a rotation: azimuth in [0, 360), roll in (-180, 180]. Seen from right above or
 * below, where azimuth and roll turn about one axis, roll is 0.
 * @param {Rotation} rotation
 * @returns {Angles}
 */
export function anglesOf([right, up, back]) {
  const elevation = Math.asin(Math.max(-1, Math.min(1, back[2])));
  const isPole = Math.hypot(back[0], back[1]) < 1e-6;
  const azimuth = isPole ? Math.atan2(right[1], right[0]) : Math.atan2(back[0], -back[1]);
  const level = levelRight(azimuth);
  const roll = isPole ? 0 : Math.atan2(dot(up, level), dot(right, level));
  return {azimuth_deg: (azimuth / DEGREE + 360) % 360, elevation_deg: elevation / DEGREE,
    roll_deg: roll / DEGREE};
}

/**
 * The point on the ball under a pointer. Far from the center, a hyperbolic sheet replaces the ball,
 * so that a drag continues beyond the rim.
 * Source  G. Bell's trackball, as in Henriksen, Sporring, Hornbaek: Virtual trackballs revisited.
 * @param {number} x  Right, 1 at the ball's rim.
 * @param {number} y  Up.
 * @returns {Triple} a unit vector; z towards the viewer
 */
export function onBall(x, y) {
  const squared = x * x + y * y;
  return unit([x, y, squared <= 0.5 ? Math.sqrt(1 - squared) : 0.5 / Math.sqrt(squared)]);
}

/**
 * The rotation after turning the scene about an axis of the eye.
 * @param {Rotation} rotation
 * @param {Triple} axis      Unit vector in the eye's axes.
 * @param {number} angle     Radians, right-handed.
 * @returns {Rotation}
 */
export function turn(rotation, axis, angle) {
  // Turning what is seen by Q makes the rows R' = Q R; Q by Rodrigues' formula.
  const c = Math.cos(angle), s = Math.sin(angle), [x, y, z] = axis, t = 1 - c;
  const q = [[t * x * x + c, t * x * y - s * z, t * x * z + s * y],
    [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
    [t * x * z - s * y, t * y * z + s * x, t * z * z + c]];
  const rows = q.map(([a, b, d]) => /** @type {Triple} */ (
    [0, 1, 2].map(k => a * rotation[0][k] + b * rotation[1][k] + d * rotation[2][k])));
  // Drags add up many turns: keep the axes square to each other.
  const back = unit(rows[2]);
  const right = unit(blend(rows[0], 1, back, -dot(rows[0], back)));
  return [right, cross(back, right), back];
}

/**
 * The rotation after dragging the ball from one point to another.
 * @param {Rotation} rotation
 * @param {Triple} from  On the ball.
 * @param {Triple} to
 * @returns {Rotation}
 */
export function drag(rotation, from, to) {
  const axis = cross(from, to), sine = Math.hypot(...axis);
  return sine < 1e-9 ? rotation : turn(rotation, unit(axis), 2 * Math.atan2(sine, dot(from, to)));
}
