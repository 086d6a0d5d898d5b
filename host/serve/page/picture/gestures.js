// Pointers on the picture: one rotates or drags a mark, two or another button move and zoom, a
// click picks.
import {onBall} from './arcball.js';

/** @typedef {import('./picture.js').PictureView} PictureView */
/** @typedef {import('./viewpoint.js').Viewpoint} Viewpoint */
/** @typedef {{x: number, y: number}} Point */

const CLICK_PX = 4;            // A pointer that moves less is a click.
const WHEEL_PAUSE_MS = 400;    // A wheel starts a new gesture after this pause.
const WHEEL_ZOOM = 0.0015;     // Per pixel of a wheel's step.
const LINE_PX = 16;

/**
 * @param {PictureView} picture
 * @param {Viewpoint} viewpoint
 * @param {(event: PointerEvent) => void} click
 * @param {import('./grabs.js').Grabs} grabs
 */
export function watchPointers(picture, viewpoint, click, grabs) {
  const {stage} = picture;
  /** @type {Map<number, Point>} */
  const pointers = new Map();
  let isPanning = false;
  /** @type {Point | null} where the first pointer went down; null once it has been dragged */
  let down = null;
  let ball = {x: 0, y: 0, radius: 1};

  stage.addEventListener('pointerdown', event => {
    if (event.target instanceof Element && event.target.closest('button, a, [role=button]')) {
      return;
    }
    stage.classList.add('by-pointer');
    stage.focus({preventScroll: true});
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    ball = picture.circleAt(event);
    isPanning = event.button !== 0 || event.shiftKey;
    down = pointers.size === 1 ? {x: event.clientX, y: event.clientY} : null;
    grabs.press(down && !isPanning ? event : null);
  });
  stage.addEventListener('pointermove', event => {
    const before = pointers.get(event.pointerId);
    if (!before) {
      return;
    }
    const now = {x: event.clientX, y: event.clientY};
    if (down && Math.hypot(now.x - down.x, now.y - down.y) < CLICK_PX) {
      return;
    }
    if (grabs.move(event)) {
      down = null;
      pointers.set(event.pointerId, now);
      return;
    }
    if (down) {
      viewpoint.begin();
      stage.classList.add('dragging');
      down = null;
    }
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    pointers.set(event.pointerId, now);
    if (other) {
      moveTwo(viewpoint, other, before, now);
    } else if (isPanning) {
      viewpoint.pan(now.x - before.x, now.y - before.y);
    } else {
      viewpoint.drag(ballAt(ball, before), ballAt(ball, now));
    }
  });
  const end = (/** @type {PointerEvent} */ event) => {
    const wasThere = pointers.delete(event.pointerId);
    if (pointers.size === 0) {
      stage.classList.remove('dragging');
    }
    if (wasThere && down && event.type === 'pointerup' && event.button === 0) {
      grabs.cancel();
      click(event);
    }
    grabs.end(event);
    down = null;
  };
  stage.addEventListener('pointerup', end);
  stage.addEventListener('pointercancel', end);
  stage.addEventListener('contextmenu', event => event.preventDefault());
  watchWheel(stage, viewpoint);
  watchFocus(stage, grabs);
}

/**
 * A frame around the picture shows the keyboard's focus, and no click. Esc ends a drag of a mark.
 * @param {HTMLElement} stage
 * @param {import('./grabs.js').Grabs} grabs
 */
function watchFocus(stage, grabs) {
  stage.addEventListener('keydown', event => {
    stage.classList.remove('by-pointer');
    if (event.key === 'Escape' && grabs.cancel()) {
      event.stopPropagation();
    }
  });
  stage.addEventListener('blur', () => stage.classList.remove('by-pointer'));
}

/**
 * Two fingers: the midpoint moves, the distance zooms, the direction rolls.
 * @param {Viewpoint} viewpoint
 * @param {Point} still
 * @param {Point} before
 * @param {Point} now
 */
function moveTwo(viewpoint, still, before, now) {
  const length = (/** @type {Point} */ p) => Math.hypot(p.x - still.x, p.y - still.y);
  const angle = (/** @type {Point} */ p) => Math.atan2(p.y - still.y, p.x - still.x);
  viewpoint.pan((now.x - before.x) / 2, (now.y - before.y) / 2);
  if (length(before) > 0 && length(now) > 0) {
    viewpoint.zoom(length(now) / length(before));
    // The screen's y points down: its angles run clockwise.
    viewpoint.turn([0, 0, 1], angle(before) - angle(now));
  }
}

/**
 * @param {HTMLElement} stage
 * @param {Viewpoint} viewpoint
 */
function watchWheel(stage, viewpoint) {
  let last = -Infinity;
  stage.addEventListener('wheel', event => {
    event.preventDefault();
    if (event.timeStamp - last > WHEEL_PAUSE_MS) {
      viewpoint.begin();
    }
    last = event.timeStamp;
    const px = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : LINE_PX);
    // A pinch on a touchpad comes as a wheel with ctrl, in small steps.
    viewpoint.zoom(Math.exp(-px * WHEEL_ZOOM * (event.ctrlKey ? 6 : 1)));
  }, {passive: false});
}

/**
 * @param {{x: number, y: number, radius: number}} circle  Of the ball, client coordinates.
 * @param {Point} point                                    Client coordinates.
 */
function ballAt({x, y, radius}, point) {
  return onBall((point.x - x) / radius, (y - point.y) / radius);
}
