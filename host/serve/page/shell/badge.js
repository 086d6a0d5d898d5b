// The status line below the picture: quality, digest, speed and size.
import {byId, h, setText, update} from '../elements/dom.js';
import {grouped} from '../elements/numbers.js';
import {composedSize, partsOf} from '../picture/stereo.js';
import {say} from '../texts/say.js';

/** @typedef {import('../panel/app.js').App} App */
/** @typedef {import('../link/types.js').FrameHeader} FrameHeader */

const RATE_OVER_MS = 2000;
const READ_MS = 250;          // A person cannot read faster changes.
const SETTLE_MS = 200;        // Delay from resizing the panel to resizing the picture.
const MOST_AUTO_PX = 1280 * 1024;
const STEP_PX = 2;            // Sizes are even.
const WARPED_TITLE = say`The newest picture, shown from the newest viewpoint by its depths until
  the next picture arrives. Hatched parts are not known: the picture has not seen them.`;
const SIZES = ['256x256', '512x512', '768x768', '1024x1024', '1280x1024', '1920x1080'];

/** @param {App} app */
export function createBadge(app) {
  const root = byId('badge');
  const quality = h('span', {class: 'quality', 'data-testid': 'badge-quality'});
  const digest = h('code', {'data-testid': 'badge-digest', title: say`Digest of the pixels,
    as printed by the command digest. It is the same on every machine.`});
  const speed = h('span', {class: 'number', 'data-testid': 'badge-speed',
    title: say`Time to render this frame, and displayed frames per second`});
  const size = h('span', {class: 'number', 'data-testid': 'badge-size',
    title: say`Size of this frame in pixels. Frames may be smaller during interaction.`});
  const label = h('span', {class: 'small', title: digest.title, hidden: true}, say`digest`);
  root.append(quality, label, digest, h('span', {class: 'grow'}), speed, size, sizeMenu(app));
  /** @type {number[]} */
  let times = [];
  let shownAt = -Infinity;  // Time of the shown speed.
  app.picture.onShown((header, at) => {
    times = [...times.filter(each => at - each < RATE_OVER_MS), at];
    const [now, before] = [at, times[0]];
    const rate = times.length > 2 ? (times.length - 1) / (now - before) * 1000 : 0;
    showQuality();
    if (header.rests || at - shownAt > READ_MS) {
      shownAt = at;
      setText(speed, `${grouped(header.machine_ms)} ms`
        + (rate > 0 && !header.rests ? ` · ${say`${grouped(rate)} frames/s`}` : ''));
    }
    const eye = [header.width, header.height];
    setText(size, (header.views === 1 ? eye
      : composedSize(eye, app.store.state?.stereo ?? 'off')).join(' × '));
  });
  const showQuality = () => {
    const {header, warp} = app.picture;
    if (header) {
      const isWarped = warp?.figures.warped ?? false;
      update(quality, {title: isWarped ? WARPED_TITLE : qualityTitle(header)});
      setText(quality, isWarped ? warpedText(header) : qualityText(header));
      quality.classList.toggle('good',
        !isWarped && header.kind === 'png' && header.moved_mm === 0);
      setText(digest, isWarped ? '' : header.digest);
      label.toggleAttribute('hidden', digest.textContent === '');
    }
  };
  app.picture.onChange(showQuality);
  app.picture.onCleared(() => {
    shownAt = -Infinity;
    for (const text of [quality, digest, speed, size]) {
      text.textContent = '';
    }
  });
}

/** @param {FrameHeader} header */
function warpedText({moved_mm, ...codec}) {
  return moved_mm > 0 ? say`warped, simplified within ${millimeters(moved_mm)} mm`
    : codec.kind === 'png' ? say`warped` : say`warped, ${codecText(codec)}`;
}

/** @param {FrameHeader} header */
function qualityText({kind, quality, samples, moved_mm, fullColor}) {
  if (moved_mm > 0) {
    return kind === 'png' ? say`simplified within ${millimeters(moved_mm)} mm`
      : say`moving, simplified within ${millimeters(moved_mm)} mm`;
  }
  return kind !== 'png' ? say`moving, ${codecText({kind, quality, fullColor})}`
    : samples > 1 ? say`lossless, ${samples} samples` : say`lossless`;
}

/** @param {Pick<FrameHeader, 'kind' | 'quality' | 'fullColor'>} header */
function codecText({kind, quality, fullColor}) {
  return kind === 'vp8' ? say`VP8 video`
    : fullColor ? say`JPEG ${quality}, full color` : `JPEG ${quality}`;
}

/** @param {FrameHeader} header */
function qualityTitle({kind, quality, samples, moved_mm, fullColor}) {
  const codec = {
    png: samples > 1 ? say`Every pixel is exactly as rendered, averaged over ${samples} samples`
      : say`Every pixel is exactly as rendered`,
    jpeg: fullColor ? say`Compressed during interaction (quality ${quality} of 100, with all
        colors), lossless at rest`
      : say`Compressed during interaction (quality ${quality} of 100, 2 x 2 pixels share a
        color), lossless at rest`,
    vp8: say`Compressed as a video during interaction, because the link is slow. Lossless at rest`,
  }[kind];
  return moved_mm > 0 ? say`${codec}. Surfaces have fewer triangles; no point is farther from the
    exact surface. Small parts may be missing. The command detail sets this.` : codec;
}

/**
 * Rounds up, because the number is a bound.
 * @param {number} mm
 */
function millimeters(mm) {
  return grouped(Math.ceil(mm * 100) / 100, 2);
}

/**
 * The size of the picture follows the panel unless the user chooses a size.
 * @param {App} app
 */
function sizeMenu(app) {
  const menu = h('select', {'aria-label': say`Picture size`, 'data-testid': 'size-menu',
    title: say`Picture size in pixels`, class: 'small'},
    h('option', {value: ''}, say`fit to panel`), ...SIZES.map(each => h('option', {value: each},
      each.replace('x', ' × '))));
  let timer = 0;
  // The size that this page has requested and has not seen in a state yet.
  let requested = '', requestedRevision = 0;
  const request = (/** @type {string} */ size) => {
    requested = size;
    requestedRevision = Infinity;
    void app.connection.set({name: 'size', words: [size]}).then(({ok, revision = 0}) => {
      if (requested === size) {
        requestedRevision = ok ? revision : 0;
      }
    });
  };
  const newestSize = (/** @type {import('../link/vocabulary.js').State} */ {revision, size}) =>
    revision < requestedRevision ? requested : size.join('x');
  // Another viewer may have set the size for its own panel. It stays until this page is used:
  // two pages that follow at once would take the size from each other for ever.
  // Not before a click is answered: it names a pixel of the size that is shown.
  for (const use of ['pointerup', 'keyup', 'focus', 'visibilitychange']) {
    addEventListener(use, () => follow());
  }
  app.picture.stage.addEventListener('pointerenter', event => {
    if (event.pointerType === 'mouse') {
      follow();
    }
  });
  const follow = () => {
    const isFollowing = menu.value === '' && !app.picture.stage.hidden;
    if (isFollowing && app.store.state && !app.connection.watches) {
      const wished = sizeOf(app.picture.stage, partsOf(app.store.state.stereo).length);
      if (wished !== newestSize(app.store.state)) {
        request(wished);
      }
    }
  };
  menu.addEventListener('change', () => {
    if (menu.value === '') {
      follow();
    } else {
      request(menu.value);
    }
    menu.blur();
  });
  new ResizeObserver(() => {
    clearTimeout(timer);
    timer = window.setTimeout(follow, SETTLE_MS);
  }).observe(app.picture.stage);
  let ownRevision = 0;
  app.connection.on('reply', ({reply}) => {
    ownRevision = Math.max(ownRevision, reply.revision ?? 0);
  });
  app.connection.on('lost', () => { ownRevision = requestedRevision = 0; });
  // One eye's picture fits half of the panel if the pictures lie side by side.
  app.store.subscribe(['stereo'], ({revision}) => {
    if (revision <= ownRevision) {
      follow();
    }
  });
  let isGreeted = false;
  app.connection.on('hello', () => {
    menu.disabled = app.connection.watches;
    isGreeted = true;
  });
  // The state follows `hello`, possibly late. `follow` needs the size in the state.
  app.connection.on('state', () => {
    if (isGreeted) {
      isGreeted = false;
      follow();
    }
  });
  return menu;
}

/**
 * @param {HTMLElement} stage
 * @param {number} parts  Pictures that lie side by side.
 */
function sizeOf(stage, parts) {
  const box = stage.getBoundingClientRect();
  const width = box.width * devicePixelRatio / parts, height = box.height * devicePixelRatio;
  const scale = Math.min(1, Math.sqrt(MOST_AUTO_PX / Math.max(1, width * height)));
  const even = (/** @type {number} */ px) =>
    Math.max(16, Math.floor(px * scale / STEP_PX) * STEP_PX);
  return `${even(width)}x${even(height)}`;
}
