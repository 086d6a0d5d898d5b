// The inside of contours as closed lines, to be filled by the even-odd rule. Pure functions.

/**
 * A contour ends at the border of the slice, where the inside of its surface ends, too. So lines
 * that begin and end there are closed along the border.
 * @typedef {object} Contoured
 * @property {ArrayLike<number>} segments   x, y, x, y of each; the inside is on the right.
 * @property {number} width                 Pixels of the slice. Contours lie between their middles.
 * @property {number} height
 * @property {boolean} isInside             Whether the first pixel of the slice is inside.
 */

const STEPS = 4096;  // Ends of two segments meet in one of so many places per pixel.

/**
 * Closed lines, each as x, y, x, y, ...
 * @param {Contoured} contoured
 * @returns {number[][]}
 */
export function insideOf(contoured) {
  const {closed, open} = linesOf(contoured.segments);
  const {width, height} = contoured;
  if (open.length > 0) {
    return [...closed, ...closedAlongBorder(open, width - 1, height - 1)];
  }
  return contoured.isInside
    ? [...closed, [0, 0, width - 1, 0, width - 1, height - 1, 0, height - 1]] : closed;
}

/** @param {ArrayLike<number>} segments */
function linesOf(segments) {
  const key = (/** @type {number} */ at) =>
    `${Math.round(segments[at] * STEPS)},${Math.round(segments[at + 1] * STEPS)}`;
  /** Segments that begin at a place. @type {Map<string, number[]>} */
  const from = new Map();
  /** How many segments end there. @type {Map<string, number>} */
  const ends = new Map();
  for (let i = 0; i < segments.length; i += 4) {
    from.set(key(i), [...from.get(key(i)) ?? [], i]);
    ends.set(key(i + 2), (ends.get(key(i + 2)) ?? 0) + 1);
  }
  const used = new Set();
  const follow = (/** @type {number} */ first) => {
    const line = [segments[first], segments[first + 1]];
    for (let at = /** @type {number | undefined} */ (first); at !== undefined;
      at = from.get(key(at + 2))?.find(next => !used.has(next))) {
      used.add(at);
      line.push(segments[at + 2], segments[at + 3]);
    }
    return line;
  };
  // Lines that begin at the border: more segments begin there than end.
  const open = [...from].flatMap(([place, list]) =>
    list.slice(0, Math.max(list.length - (ends.get(place) ?? 0), 0))).map(follow);
  const closed = [];
  for (let i = 0; i < segments.length; i += 4) {
    if (!used.has(i)) {
      closed.push(follow(i));
    }
  }
  return {closed, open};
}

/**
 * Joins lines along the border, clockwise from the end of one to the begin of the next, since the
 * inside is on the right.
 * @param {number[][]} lines
 * @param {number} right    The border is the rectangle from (0, 0) to there.
 * @param {number} bottom
 */
function closedAlongBorder(lines, right, bottom) {
  const around = 2 * (right + bottom);
  /** Corners, clockwise, with their places along the border. */
  const corners = [[0, 0, 0], [right, right, 0], [right + bottom, right, bottom],
    [2 * right + bottom, 0, bottom]];
  const along = (/** @type {number} */ x, /** @type {number} */ y) => {
    const sides = [[y, x], [right - x, right + y], [bottom - y, 2 * right + bottom - x],
      [x, around - y]];
    return sides.reduce((a, b) => Math.abs(b[0]) < Math.abs(a[0]) ? b : a)[1];
  };
  const left = new Set(lines);
  const closed = [];
  for (const first of lines) {
    if (!left.delete(first)) {
      continue;
    }
    const whole = [...first];
    for (;;) {
      const end = along(whole[whole.length - 2], whole[whole.length - 1]);
      const ahead = (/** @type {number} */ place) => (place - end + around) % around;
      // The line itself is the last that can follow: it closes the ring.
      const next = [...left, first].reduce((a, b) =>
        ahead(along(b[0], b[1])) < ahead(along(a[0], a[1])) ? b : a);
      const until = ahead(along(next[0], next[1]));
      corners.map(([place, x, y]) => ({far: ahead(place), x, y}))
        .filter(({far}) => far > 0 && far < until).sort((a, b) => a.far - b.far)
        .forEach(({x, y}) => whole.push(x, y));
      if (next === first) {
        break;
      }
      left.delete(next);
      whole.push(...next);
    }
    closed.push(whole);
  }
  return closed;
}
