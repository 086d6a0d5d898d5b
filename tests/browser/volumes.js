// Small volumes that tests write as NRRD files.
import { writeFileSync } from 'node:fs';

/**
 * A NRRD file of an ellipsoid with its surface at 0, 1 mm voxels.
 * @param {[number, number, number]} size      voxels
 * @param {[number, number, number]} radii_mm
 * @param {boolean} [isPlaced]  Whether the file states place and spacing; else they are assumed.
 */
export function writeEllipsoid(file, size, radii_mm, isPlaced = true) {
  const [nx, ny, nz] = size;
  const values = new Float32Array(nx * ny * nz).map((_, at) => {
    const place = [at % nx, Math.floor(at / nx) % ny, Math.floor(at / nx / ny)];
    return 1 - Math.hypot(...place.map((p, axis) => (p - (size[axis] - 1) / 2) / radii_mm[axis]));
  });
  const place = isPlaced ? ['space: left-posterior-superior',
    'space directions: (1,0,0) (0,1,0) (0,0,1)', 'space origin: (0,0,0)'] : [];
  const header = ['NRRD0004', 'type: float', 'dimension: 3', `sizes: ${size.join(' ')}`,
    ...place, 'endian: little', 'encoding: raw', '', ''].join('\n');
  writeFileSync(file, Buffer.concat([Buffer.from(header), Buffer.from(values.buffer)]));
  return file;
}
