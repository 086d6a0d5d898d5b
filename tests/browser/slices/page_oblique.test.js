// The place of oblique slices in the patient: the module that needs no browser.
import assert from 'node:assert/strict';
import test from 'node:test';

import {dot, moved, normalOf, onPlane, planeThrough, sidesOf, voxelOnPlane}
  from '../../../host/serve/page/slices/oblique_plane.js';
import {toPatient, toVoxel} from '../../../host/serve/page/slices/patient_grid.js';

const close = (a, b, what) => a.forEach((value, k) =>
  assert.ok(Math.abs(value - b[k]) < 1e-9, `${what}: ${a} is not ${b}`));

/** A volume with a tilted gantry and unevenly spaced slices. */
const VOLUME = {voxel_to_patient: [0.8, 0.1, 0, 0, -0.1, 0.9, 0, 0, 0, 0.4, 1.5, 0, -4, 5, -60, 1],
  slice_places: [0, 1, 2, 2.5, 4, 6, 6.5, 7], size: [12, 10, 8], spacing_mm: [0.8, 0.9, 1.5]};

test('angles of 0 and 90 degrees are the three planes as radiologists show them', () => {
  const [left, posterior, inferior] = [[1, 0, 0], [0, 1, 0], [0, 0, -1]];
  for (const [tilt, turn, right, down] of [[0, 0, left, posterior], [90, 0, left, inferior],
    [90, 90, posterior, inferior]]) {
    const sides = sidesOf({tilt, turn});
    close(sides.right, right, `right at ${tilt}, ${turn}`);
    close(sides.down, down, `down at ${tilt}, ${turn}`);
  }
});

test('sides have the length 1 and a right angle at any angles', () => {
  for (let tilt = -90; tilt <= 90; tilt += 15) {
    for (let turn = -90; turn <= 90; turn += 15) {
      const {right, down} = sidesOf({tilt, turn}), normal = normalOf({right, down});
      close([dot(right, right), dot(down, down), dot(right, down), dot(normal, normal)],
        [1, 1, 0, 1], `${tilt}, ${turn}`);
    }
  }
});

test('the plane goes through the place, and its picture shows the whole volume', () => {
  for (const angles of [{tilt: 30, turn: -20}, {tilt: -75, turn: 66}, {tilt: 0, turn: 0}]) {
    const through = toPatient(VOLUME, [3, 7, 5]);
    const plane = planeThrough(VOLUME, angles, through);
    const normal = normalOf(plane);
    close([dot(normal, moved(through, plane.center_mm, -1))], [0], 'distance');
    for (let corner = 0; corner < 8; ++corner) {
      const voxel = VOLUME.size.map((count, axis) => corner >> axis & 1 ? count - 1 : 0);
      const {pixel: [x, y]} = onPlane(VOLUME, plane, voxel);
      assert.ok(x >= -0.5 && y >= -0.5 && x <= plane.width - 0.5 && y <= plane.height - 0.5,
        `corner ${voxel} is at ${x}, ${y} of ${plane.width}, ${plane.height}`);
    }
    assert.ok(plane.width <= 512, `${plane.width}`);
  }
});

test('pixels and voxels are inverse, and a depth counts pixels along the normal', () => {
  const plane = planeThrough(VOLUME, {tilt: 30, turn: -20}, toPatient(VOLUME, [3, 7, 5]));
  for (const [x, y] of [[0, 0], [3.25, 7.5], [12, 2]]) {
    const voxel = voxelOnPlane(VOLUME, plane, x, y);
    const {pixel, depth} = onPlane(VOLUME, plane, voxel);
    close([...pixel, depth], [x, y, 0], 'pixel');
    const away = moved(toPatient(VOLUME, voxel), normalOf(plane), 3 * plane.pixel_mm);
    close([onPlane(VOLUME, plane, toVoxel(VOLUME, away)).depth], [3], 'depth');
  }
});
