// The camera of a view, as host/scene/camera.cpp makes it, and 4 x 4 matrices, column-major.
import {rotationOf} from './arcball.js';

/** @typedef {import('../link/types.js').Triple} Triple */
/** @typedef {import('../link/vocabulary.js').CameraState} CameraState */
/** @typedef {import('./stereo.js').Stereo} Stereo */

/**
 * The part of a camera that a gesture changes.
 * @typedef {Pick<CameraState, 'azimuth_deg' | 'elevation_deg' | 'roll_deg' | 'zoom' | 'pan_mm'>}
 *   View
 */

const HALF_ANGLE = 15 * Math.PI / 180;
const FILL = 1.3;
const DEPTH_MARGIN = 1.02;
const SEPARATION = 0.035;  // Of the eyes, as a share of the camera's distance at zoom 1.
const SAME = 1e-6;  // Degrees, millimeters and zoom: commands have 2 to 4 digits.

/**
 * @param {View} view
 * @param {Pick<CameraState, 'center_mm' | 'radius_mm'>} subject
 * @param {number} aspect  Width over height of the picture.
 * @returns {CameraState}
 */
export function cameraAt(view, subject, aspect) {
  return camerasAt(view, subject, aspect, {mode: 'off', separation_mm: 0, convergence_mm: 0})[0];
}

/**
 * The cameras that draw a view: one, or in stereo those of the left and the right eye, as
 * eye_matrices() in host/scene/stereo.cpp makes them.
 * @param {View} view
 * @param {Pick<CameraState, 'center_mm' | 'radius_mm'>} subject
 * @param {number} aspect  Width over height of the picture of one camera.
 * @param {Stereo} stereo
 * @returns {CameraState[]}
 */
export function camerasAt(view, {center_mm, radius_mm}, aspect, stereo) {
  const {azimuth_deg, elevation_deg, roll_deg, zoom, pan_mm} = view;
  const rows = rotationOf(view);
  const distance = radius_mm / Math.sin(HALF_ANGLE);
  const eye = [0, 1, 2].flatMap(axis => [...rows.map(row => row[axis]), 0]);
  const [right, up, back] = rows.map(row =>
    row[0] * center_mm[0] + row[1] * center_mm[1] + row[2] * center_mm[2]);
  eye.push(pan_mm[0] - right, pan_mm[1] - up, -back - distance, 1);

  const near = distance - radius_mm * DEPTH_MARGIN, far = distance + radius_mm * DEPTH_MARGIN;
  const scale = zoom * FILL / Math.tan(HALF_ANGLE);
  // The subject fills the shorter side of the picture.
  const projection = [aspect > 1 ? scale / aspect : scale, 0, 0, 0,
    0, aspect > 1 ? scale : scale * aspect, 0, 0,
    0, 0, -(far + near) / (far - near), -1,
    0, 0, -2 * far * near / (far - near), 0];
  const separation = stereo.separation_mm > 0 ? stereo.separation_mm : SEPARATION * distance / zoom;
  const convergence = stereo.convergence_mm > 0 ? stereo.convergence_mm : distance;
  return (stereo.mode === 'off' ? [0] : [-0.5, 0.5]).map(side => {
    const shift = side * separation;
    const patient_to_eye = [...eye], lens = [...projection];
    patient_to_eye[12] -= shift;
    // Moves the frustum back, so that both eyes see the plane of convergence alike.
    lens[8] -= projection[0] * shift / convergence;
    return {azimuth_deg, elevation_deg, roll_deg, zoom, pan_mm, center_mm, radius_mm,
      patient_to_eye, patient_to_clip: multiply(lens, patient_to_eye)};
  });
}

/**
 * Whether two views show the same picture.
 * @param {View} a
 * @param {View} b
 */
export function isSameView(a, b) {
  const turned = (/** @type {number} */ degrees) => Math.abs(degrees - 360 * Math.round(degrees
    / 360));
  return turned(a.azimuth_deg - b.azimuth_deg) < SAME
    && Math.abs(a.elevation_deg - b.elevation_deg) < SAME
    && turned(a.roll_deg - b.roll_deg) < SAME && Math.abs(a.zoom - b.zoom) < SAME
    && a.pan_mm.every((mm, axis) => Math.abs(mm - b.pan_mm[axis]) < SAME);
}

/**
 * @param {number[]} a
 * @param {number[]} b
 */
export function multiply(a, b) {
  return Array.from({length: 16}, (_, at) => {
    const row = at % 4, column = at - row;
    return a[row] * b[column] + a[row + 4] * b[column + 1] + a[row + 8] * b[column + 2]
      + a[row + 12] * b[column + 3];
  });
}

/**
 * The inverse of a matrix that has one, by elimination with the largest pivots.
 * @param {number[]} matrix
 */
export function inverse(matrix) {
  // Each row of the matrix, and behind it the same row of the inverse.
  const rows = [0, 1, 2, 3].map(row => [0, 1, 2, 3, 4, 5, 6, 7].map(column =>
    column < 4 ? matrix[column * 4 + row] : Number(column - 4 === row)));
  for (let step = 0; step < 4; ++step) {
    let pivot = step;
    for (let row = step + 1; row < 4; ++row) {
      pivot = Math.abs(rows[row][step]) > Math.abs(rows[pivot][step]) ? row : pivot;
    }
    [rows[step], rows[pivot]] = [rows[pivot], rows[step]];
    const first = rows[step][step];
    rows[step] = rows[step].map(value => value / first);
    for (let row = 0; row < 4; ++row) {
      const factor = row === step ? 0 : rows[row][step];
      rows[row] = rows[row].map((value, column) => value - factor * rows[step][column]);
    }
  }
  return Array.from({length: 16}, (_, at) => rows[at % 4][4 + Math.floor(at / 4)]);
}
