// Functions that run in the page: they keep frames with depths, and compare warped pictures.

/** The page's painters of warped pictures. */
export const PAINTERS = ['webgl', 'software'];

/**
 * Runs before the page's own code: keeps resting frames of one sample with depths, frames of two
 * layers, and refined frames.
 */
export function keepFrames() {
  const Plain = globalThis.WebSocket;
  Object.assign(globalThis, { kept: [], layered: [], refined: [] });
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        if (view?.getUint32(0, true) === 0x46523550) {
          const frame = { message: event.data, state: globalThis.pxpl5.state,
                          revision: view.getUint32(8, true) };
          const [samples, flags, layers] = [18, 19, 53].map(at => view.getUint8(at));
          const hasDepths = view.getUint32(44, true) > 0;
          if (flags & 1 && samples === 1 && hasDepths) globalThis.kept.push(frame);
          if (layers === 2 && hasDepths) globalThis.layered.push(frame);
          if (flags & 2) globalThis.refined.push(frame);
        }
        take(event);
      });
    }
  };
}

/** Loads the page's own modules, and functions on kept frames, into globalThis.modules. */
export async function loadModules() {
  const load = name => import(new URL(name, location.href).href);
  const modules = { camera: await load('picture/camera.js'),
                    lean: await load('picture/lean_depths.js'),
                    painter: await load('picture/warp_painter.js'),
                    software: await load('picture/software_painter.js'),
                    bitmaps: await load('picture/bitmaps.js'),
                    messages: await load('link/messages.js') };
  /**
   * A kept frame, decoded. `pixels` has red, green, blue, alpha of the layers over each other, each
   * where it shows a surface; `flat` has the mean of both layers everywhere.
   */
  modules.open = async ({ message, state }) => {
    const frame = modules.messages.parseFrame(message), { header, depths } = frame;
    const bitmap = await modules.bitmaps.bitmapOfFile(frame);  // Decoders of JPEG differ a little.
    const { width, height, layers } = header;
    const context = new OffscreenCanvas(width, layers * height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const leans = await Promise.all(depths.map(each =>
      modules.lean.unpack(each, width, height)));
    const isIn = ({ mask }, x, y) => mask[y * Math.ceil(width / 8) + (x >> 3)] >> (x & 7) & 1;
    const shows = (x, y) => leans.some(lean => isIn(lean, x, y)) ? 1 : 0;
    const pixels = context.getImageData(0, 0, width, height).data;
    const flat = pixels.slice();
    const share = header.opacity / 16;
    const front = layers > 1 && context.getImageData(0, height, width, height).data;
    const empty = [1, 3, 5].map(at => parseInt(state.background.slice(at, at + 2), 16));
    for (let at = 0; front && at < pixels.length; at++) {
      const x = (at >> 2) % width, y = Math.floor((at >> 2) / width), channel = at & 3;
      flat[at] = Math.round(front[at] * share + pixels[at] * (1 - share));
      if (!isIn(leans[0], x, y) && channel < 3) pixels[at] = empty[channel];
      if (isIn(leans[1], x, y)) pixels[at] = Math.round(front[at] * share +
                                                        pixels[at] * (1 - share));
    }
    return { header, bitmap, leans, shows, width, height, camera: state.camera, state, pixels, flat,
             depth_bytes: depths.reduce((sum, each) => sum + each.length, 0),
             bytes: message.byteLength };
  };
  /** A painter of PAINTERS. */
  modules.painterOf = (name, canvas) => name === 'software'
    ? new modules.software.SoftwarePainter(canvas) : new modules.painter.WarpPainter(canvas);
  /** What pixelAt() of a painter says of the front layer, for the pixels of a grid. */
  modules.placesOf = (name, frame, view) => {
    const painter = modules.painterOf(name, document.createElement('canvas'));
    const { cameraAt, multiply, inverse } = modules.camera, aspect = frame.width / frame.height;
    const clip = each => cameraAt(each, frame.camera, aspect).patient_to_clip;
    painter.take(frame.bitmap, frame.leans);
    const warp = multiply(clip(view), inverse(clip(frame.camera)));
    const found = [];
    for (let y = 5; y < frame.height; y += 37) {
      for (let x = 5; x < frame.width; x += 37) {
        found.push(painter.pixelAt({ x, y }, frame, frame.leans.length - 1, warp,
                                   view.zoom / frame.camera.zoom));
      }
    }
    painter.gl?.getExtension('WEBGL_lose_context').loseContext();
    return found;
  };
  /** The pixels of a frame as seen from a view. With `tests`, each cell is tested for tearing. */
  modules.warp = (name, frame, view, background, { hatches = true, tests = false } = {}) => {
    const canvas = document.createElement('canvas');
    const painter = modules.painterOf(name, canvas);
    if (!hatches) painter.hatch_ = () => {};
    const { cameraAt, multiply, inverse } = modules.camera, aspect = frame.width / frame.height;
    const clip = each => cameraAt(each, frame.camera, aspect).patient_to_clip;
    painter.take(frame.bitmap, frame.leans);
    if (tests) {
      for (const mesh of painter.meshes_) {
        const { meshOf } = mesh;
        mesh.meshOf = hasBlocks => {
          const made = meshOf(hasBlocks);
          made.fullEnds.fill(0);
          made.partialEnds.fill(made.triangles.length);
          return made;
        };
      }
    }
    painter.begin(frame.width, frame.height, background);
    const warp = multiply(clip(view), inverse(clip(frame.camera)));
    frame.leans.forEach((_, layer) => painter.draw(layer, warp, view.zoom / frame.camera.zoom,
                                                   layer ? frame.header.opacity / 16 : 1,
                                                   { left: 0, ...frame }));
    painter.end();
    const pixels = modules.read(canvas);
    painter.gl?.getExtension('WEBGL_lose_context').loseContext();
    return pixels;
  };
  /** The pixels that a painter has drawn on a canvas, before the task ends. */
  modules.read = canvas => {
    const { width, height } = canvas, context = new OffscreenCanvas(width, height).getContext('2d');
    context.drawImage(canvas, 0, 0);
    return context.getImageData(0, 0, width, height).data;
  };
  /** The share of pixels of which a channel differs by more than their rounding. */
  modules.unlike = (a, b) => {
    let count = 0;
    for (let at = 0; at < a.length; at += 4) {
      count += [0, 1, 2].some(k => Math.abs(a[at + k] - b[at + k]) > 8) ? 1 : 0;
    }
    return 4 * count / a.length;
  };
  /** A background that no surface has, to find what is not known. */
  modules.key = '#ff00ff';
  /** Over this background: nothing is known of the pixel at byte `at`. */
  modules.isHatched = (pixels, at) => {
    const [red, green, blue] = pixels.subarray(at, at + 3);
    return red === blue && (red > 228 && red < 241 && green > 75 && green < 88 ||
                            red > 242 && red < 255 && green > 18 && green < 31);
  };
  modules.isEmpty = (pixels, at) => [255, 0, 255].every((part, k) => pixels[at + k] === part);
  /** The mean of a channel of the 4 x 4 pixels at (x, y). */
  modules.mean = (pixels, width, x, y, k) => {
    let sum = 0;
    for (let i = 0; i < 16; i++) sum += pixels[((y + (i >> 2)) * width + x + (i & 3)) * 4 + k];
    return sum / 16;
  };
  /**
   * Compares pictures with the exact one where it shows a surface.
   * @param exact     {width, height, pixels, shows(x, y)}
   * @param keyed     The first picture before modules.key: what it does not know is seen there.
   * @param pictures  Pixels.
   * @returns the unknown share of the surface, and the PSNR of each picture in means of 4 x 4
   */
  modules.judge = (exact, keyed, pictures) => {
    const { width, height } = exact;
    const isDark = at => modules.isEmpty(keyed, at) || modules.isHatched(keyed, at);
    let unknown = 0, covered = 0;
    for (let at = 0; at < keyed.length; at += 4) {
      const shows = exact.shows(at / 4 % width, Math.floor(at / 4 / width));
      covered += shows;
      unknown += shows && isDark(at) ? 1 : 0;
    }
    const inBlock = (x, y, holds) => [0, 1, 2, 3].some(i => [0, 1, 2, 3].some(j =>
      holds(x + i, y + j)));
    const isUnknown = (x, y) => exact.shows(x, y) && isDark((y * width + x) * 4);
    // Blocks that show a surface. Unknown pixels are counted above, and have no color to compare.
    const db = pixels => {
      let sum = 0, count = 0;
      for (let y = 0; y + 4 <= height; y += 4) {
        for (let x = 0; x + 4 <= width; x += 4) {
          if (!inBlock(x, y, exact.shows) || inBlock(x, y, isUnknown)) continue;
          for (let k = 0; k < 3; k++) {
            sum += (modules.mean(pixels, width, x, y, k) -
                    modules.mean(exact.pixels, width, x, y, k)) ** 2;
            ++count;
          }
        }
      }
      return 10 * Math.log10(255 * 255 * count / sum);
    };
    return { unknown: unknown / covered, covered, db: pictures.map(db) };
  };
  globalThis.modules = modules;
}

/**
 * A kept frame, warped to its own viewpoint, beside the frame itself. `differing` counts the pixels
 * of which a channel differs by more than `least`.
 */
export async function warpedFrame([painter, list, index, least]) {
  const { modules } = globalThis;
  const frame = await modules.open(globalThis[list][index]);
  const pixels = modules.warp(painter, frame, frame.camera, frame.state.background);
  let differing = 0, covered = 0;
  for (let at = 0; at < pixels.length; at += 4) {
    covered += frame.shows(at / 4 % frame.width, Math.floor(at / 4 / frame.width));
    differing += [0, 1, 2].some(k => Math.abs(pixels[at + k] - frame.pixels[at + k]) > least)
      ? 1 : 0;
  }
  frame.bitmap.close();
  return { differing, covered, background: frame.width * frame.height - covered };
}

/**
 * A kept frame warped by each painter to the viewpoint of another frame, beside the other. Each
 * frame is a list with an index. `unlike` is the share of the pixels in which the painters differ;
 * of the pixels of a grid, `shown` show the front layer, and `elsewhere` show another place of it
 * with the other painter.
 */
export async function comparePictures(pair) {
  const { modules } = globalThis, names = ['webgl', 'software'];
  const [late, exact] = await Promise.all(pair.map(([list, index]) =>
    modules.open(globalThis[list].at(index))));
  const warped = (name, background) => modules.warp(name, late, exact.camera, background);
  const keyed = names.map(name => warped(name, modules.key));
  const unlike = modules.unlike(...keyed);
  const [ours, others] = names.map(name => modules.placesOf(name, late, exact.camera));
  const elsewhere = ours.filter((at, k) => Math.hypot((at?.x ?? -9) - (others[k]?.x ?? -9),
                                                      (at?.y ?? -9) - (others[k]?.y ?? -9)) > 1.5);
  const found = names.map((name, at) => {
    const { unknown, db } = modules.judge(exact, keyed[at],
                                          [warped(name, exact.state.background), late.pixels]);
    return [name, { warped_db: db[0], late_db: db[1], unknown, unlike,
                    shown: ours.filter(Boolean).length, elsewhere: elsewhere.length,
                    bytes: late.bytes, depth_bytes: late.depth_bytes }];
  });
  for (const { bitmap } of [late, exact]) bitmap.close();
  return Object.fromEntries(found);
}

/** Whether kept frames have one size. Each is a list with an index. */
export function sameSize(frames) {
  const sizes = frames.map(([list, index]) => {
    const view = new DataView(globalThis[list][index].message);
    return view.getUint32(12, true);  // Width and height.
  });
  return sizes.every(size => size === sizes[0]);
}

/** The PSNR of kept layers and the refined picture of their state, as small pictures. */
export async function meanSimilarity(index) {
  const { modules, layered, refined } = globalThis;
  const layers = await modules.open(layered[index]);
  const exact = await modules.open(refined.findLast(each =>
    each.revision === layers.header.revision));
  const size = [exact.width, exact.height].map(px => Math.floor(px / 8));
  const [a, b] = [layers, exact].map(({ pixels, width, height }) => {
    const whole = new OffscreenCanvas(width, height);
    whole.getContext('2d').putImageData(new ImageData(pixels, width), 0, 0);
    const context = new OffscreenCanvas(...size).getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(whole, 0, 0, ...size);
    return context.getImageData(0, 0, ...size).data;
  });
  const sum = a.reduce((total, value, k) => total + (value - b[k]) ** 2, 0);
  return 10 * Math.log10(255 * 255 * a.length / sum);
}

/** Keeps the canvas below while it shows a moving picture that has layers. */
export function watchMoving() {
  globalThis.moving = null;
  const look = () => {
    const { revision, rests } = globalThis.pxpl5;
    if (!rests && globalThis.layered.some(each => each.revision === revision)) {
      const canvas = document.querySelector('[data-testid=frame]');
      const { width, height } = canvas;
      globalThis.moving = { revision, data: canvas.getContext('2d')
        .getImageData(0, 0, width, height).data };
    } else {
      requestAnimationFrame(look);
    }
  };
  look();
}

/** How many pixels of that canvas differ by more than `least` from the blended layers. */
export async function compareMoving(least) {
  const { modules, layered, moving } = globalThis;
  const frame = await modules.open(layered.find(each => each.revision === moving.revision));
  frame.bitmap.close();
  let differing = 0, covered = 0;
  for (let at = 0; at < moving.data.length; at += 4) {
    covered += frame.shows(at / 4 % frame.width, Math.floor(at / 4 / frame.width));
    differing += [0, 1, 2].some(k => Math.abs(moving.data[at + k] - frame.flat[at + k]) > least)
      ? 1 : 0;
  }
  return { differing, covered };
}

/**
 * What a kept frame, warped by each painter to the viewpoint of another, knows about its pixels.
 * `hatched` counts the hatched pixels among those that show a surface and are not known, `false`
 * the hatched pixels that show the background, `changed` the known pixels that the hatch changes,
 * `untested` those that would differ if each cell were tested for tearing, `unlike` is the share in
 * which the painters differ.
 */
export async function hatchedPixels(pair) {
  const { modules } = globalThis, names = ['webgl', 'software'];
  const [late, exact] = await Promise.all(pair.map(([list, index]) =>
    modules.open(globalThis[list].at(index))));
  const warped = (name, how) => modules.warp(name, late, exact.camera, modules.key, how);
  const pictures = names.map(name => warped(name));
  const unlike = modules.unlike(...pictures);
  const counts = names.map((name, picture) => {
    const found = pictures[picture], plain = warped(name, { hatches: false });
    const tested = warped(name, { tests: true });
    const count = { covered: 0, unknown: 0, hatched: 0, false: 0, changed: 0, untested: 0, unlike };
    for (let at = 0; at < found.length; at += 4) {
      const shows = exact.shows(at / 4 % exact.width, Math.floor(at / 4 / exact.width));
      const isKnown = !modules.isEmpty(plain, at), isHatched = modules.isHatched(found, at);
      count.covered += shows;
      count.unknown += shows && !isKnown ? 1 : 0;
      count.hatched += shows && !isKnown && isHatched ? 1 : 0;
      count.false += !shows && isHatched ? 1 : 0;
      count.untested += [0, 1, 2].some(k => found[at + k] !== tested[at + k]) ? 1 : 0;
      count.changed += isKnown && [0, 1, 2].some(k => found[at + k] !== plain[at + k]) ? 1 : 0;
    }
    return [name, count];
  });
  for (const { bitmap } of [late, exact]) bitmap.close();
  return Object.fromEntries(counts);
}
