// Counters of the page for tests: window.pxpl5.

const KEPT = 256;  // Length of each list; older values are dropped.

/**
 * Figures of the headset, see headset/. Lists have the newest values.
 * @typedef {object} HeadsetFigures
 * @property {'off' | 'visible' | 'visible-blurred' | 'hidden'} state  Off: no session.
 * @property {string} reason                   Why the page offers no headset, or ''.
 * @property {string} refusal                  Why the machine draws no pairs, or ''.
 * @property {number} frames                   Of the headset, since the page was opened.
 * @property {number} pairs                    Shown since the session began.
 * @property {number} pose                     Number of the pose that the newest pair is of.
 * @property {number[]} size                   Of each picture of that pair, pixels.
 * @property {number[]} pose_to_pixels_ms      From the pose of a frame until it is drawn.
 * @property {number[]} pose_age_ms            Of each frame: age of the pose that its pair is of.
 * @property {number[]} round_trip_ms          From sending a pose to its pair.
 * @property {number[]} prediction_error_mm    Of the head, between prediction and later pose.
 * @property {number[]} unpredicted_error_mm   The same, had the last pose been sent instead.
 */

/** @returns {HeadsetFigures} */
export function noHeadsetFigures() {
  return {state: 'off', reason: '', refusal: '', frames: 0, pairs: 0, pose: 0, size: [0, 0],
    pose_to_pixels_ms: [], pose_age_ms: [], round_trip_ms: [], prediction_error_mm: [],
    unpredicted_error_mm: []};
}

/**
 * @typedef {object} Metrics
 * @property {number} frames            Shown since the page was opened.
 * @property {number} revision          Revision of the last frame.
 * @property {boolean} rests            Whether it was a resting picture.
 * @property {boolean} last             Whether it was the last refinement.
 * @property {number} samples           Samples per pixel of it.
 * @property {string} digest            Digest of the last resting frame.
 * @property {number[]} latency_ms      Latest inputs: from sending until a frame with a revision at
 *                                      or after the reply's is drawn. The next refresh shows it.
 * @property {number[]} frame_times_ms  When the last frames were drawn (performance.now()).
 * @property {import('./warp.js').WarpFigures | null} warp
 * @property {HeadsetFigures} headset
 * @property {import('./video.js').VideoFigures | null} video
 * @property {string} kind              Encoding of the last frame: jpeg, png or vp8.
 * @property {import('../link/vocabulary.js').State | null} state
 */

/**
 * Watches the connection and the picture.
 * @param {import('../link/connection.js').Connection} connection
 * @param {import('../state/store.js').Store} store
 * @param {import('./picture.js').PictureView} picture
 * @returns {Metrics}
 */
export function measure(connection, store, picture) {
  /** @type {{sentAt: number, revision: number}[]} */
  let awaited = [];
  /** @type {{revision: number, at: number}[]} */
  const shown = [];
  /** @type {Metrics} */
  const metrics = {frames: 0, revision: 0, rests: false, last: false, samples: 0, digest: '',
    latency_ms: [], frame_times_ms: [], warp: picture.warp?.figures ?? null,
    headset: noHeadsetFigures(),
    video: picture.video?.figures ?? null, kind: '',
    get state() { return store.state; }};

  const keep = (/** @type {any[]} */ list, /** @type {any} */ value) => {
    list.push(value);
    if (list.length > KEPT) {
      list.shift();
    }
  };
  const settle = () => {
    awaited = awaited.filter(({sentAt, revision}) => {
      const frame = shown.find(each => each.revision >= revision && each.at >= sentAt);
      if (frame) {
        keep(metrics.latency_ms, frame.at - sentAt);
      }
      return !frame;
    });
  };
  connection.on('reply', ({line, reply, sentAt}) => {
    // A command that changed nothing leads to no frame and is not timed.
    const before = shown.filter(each => each.at <= sentAt).at(-1)?.revision ?? 0;
    if (line !== '' && reply.ok && reply.revision > before) {
      keep(awaited, {sentAt, revision: reply.revision});
      settle();
    }
  });
  picture.onShown((header, at) => {
    metrics.frames += 1;
    metrics.revision = header.revision;
    metrics.rests = header.rests;
    metrics.last = header.last;
    metrics.samples = header.samples;
    metrics.kind = header.kind;
    metrics.digest = header.rests ? header.digest : metrics.digest;
    keep(metrics.frame_times_ms, at);
    keep(shown, {revision: header.revision, at});
    settle();
  });
  return metrics;
}
