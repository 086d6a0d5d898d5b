// Functions that run in the page: they keep pairs of pictures, and compare warped eyes.

/**
 * Runs before the page's own code: keeps the newest pair of each pose, and its matrices. Asks for
 * larger pictures than the emulated headset needs.
 */
export function keepPairs() {
  const Plain = globalThis.WebSocket;
  globalThis.pairs = new Map();
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        const pose = view?.getUint32(0, true) === 0x46523550 ? view.getUint32(48, true) : 0;
        if (pose > 0) globalThis.pairs.get(pose).message = event.data;
        take(event);
      });
    }
    send(text) {
      const message = JSON.parse(text), { eyes } = message;
      if (eyes) {
        eyes.size = [512, 512];
        globalThis.pairs.set(eyes.pose, { eyes });
      }
      super.send(JSON.stringify(message));
    }
  };
}

/** After loadModules: functions on kept pairs. */
export function loadPairs() {
  const { modules } = globalThis, { multiply, inverse } = modules.camera;
  /** A pair, decoded; each of its eyes as modules.judge takes it. */
  modules.openPair = async pose => {
    const { eyes, message } = globalThis.pairs.get(pose);
    const frame = modules.messages.parseFrame(message), { header, depths } = frame;
    const { width, height, layers } = header;
    const bitmap = await modules.bitmaps.bitmapOfFile(frame);
    const context = new OffscreenCanvas(width, height * depths.length).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const leans = await Promise.all(depths.map(each => modules.lean.unpack(each, width, height)));
    const views = [eyes.left, eyes.right].map(({ patient_to_eye, projection }, at) => {
      const lean = leans[at * layers];
      return { width, height, eye: patient_to_eye, projection,
        clip: multiply(projection, patient_to_eye),
        pixels: context.getImageData(0, at * layers * height, width, height).data,
        shows: (x, y) => lean.mask[y * Math.ceil(width / 8) + (x >> 3)] >> (x & 7) & 1 };
    });
    return { header, bitmap, leans, views };
  };
  /** The pixels of an eye's picture after a warp, before a background. */
  modules.warpEye = (pair, at, warp, background) => {
    const { width, height, layers } = pair.header;
    const canvas = document.createElement('canvas');
    const painter = new modules.painter.WarpPainter(canvas);
    painter.take(pair.bitmap, pair.leans);
    painter.begin(width, height, background);
    painter.draw(at * layers, warp, 1, 1, { left: 0, width, height });
    const pixels = modules.read(canvas);
    painter.gl.getExtension('WEBGL_lose_context').loseContext();
    return pixels;
  };
  /** As if the eye had turned, but not moved. */
  modules.turnOnly = (from, to) => {
    const turn = matrix => [...matrix.slice(0, 12), 0, 0, 0, 1];
    return multiply(multiply(to.projection, multiply(turn(to.eye), inverse(turn(from.eye)))),
                    inverse(from.projection));
  };
}

/** Each eye of a pair, warped to its own pose, beside the picture itself. */
export async function warpedPair(pose) {
  const { modules } = globalThis, { multiply, inverse } = modules.camera;
  const pair = await modules.openPair(pose);
  return pair.views.map((view, at) => {
    const pixels = modules.warpEye(pair, at, multiply(view.clip, inverse(view.clip)), '#ff00ff');
    const key = [255, 0, 255];
    let differing = 0, covered = 0, beside = 0;
    for (let k = 0; k < pixels.length; k += 4) {
      const shows = view.shows(k / 4 % view.width, Math.floor(k / 4 / view.width));
      const wanted = shows ? [...view.pixels.subarray(k, k + 3)] : key;
      const differs = wanted.some((part, i) => pixels[k + i] !== part);
      covered += shows;
      differing += shows && differs ? 1 : 0;
      beside += !shows && differs ? 1 : 0;
    }
    return { differing, covered, beside };
  });
}

/** A pair warped to the pose of another, beside the other: for each eye. */
export async function comparePairs([first, second]) {
  const { modules } = globalThis, { multiply, inverse } = modules.camera;
  const [late, exact] = [await modules.openPair(first), await modules.openPair(second)];
  const background = globalThis.pxpl5.state.background;
  return exact.views.map((view, at) => {
    const from = late.views[at], warp = multiply(view.clip, inverse(from.clip));
    const { unknown, covered, db } = modules.judge(view, modules.warpEye(late, at, warp, '#ff00ff'),
      [modules.warpEye(late, at, warp, background),
       modules.warpEye(late, at, modules.turnOnly(from, view), background)]);
    return { unknown, covered, warped_db: db[0], turned_db: db[1] };
  });
}
