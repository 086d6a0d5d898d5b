// Functions that run in the page: they keep frames with depths, and compare warped pictures.

/** Runs before the page's own code: keeps resting frames of one sample with depths. */
export function keepFrames() {
  const Plain = globalThis.WebSocket;
  globalThis.kept = [];
  globalThis.WebSocket = class extends Plain {
    set onmessage(take) {
      this.addEventListener('message', event => {
        const view = typeof event.data === 'string' ? null : new DataView(event.data);
        if (view?.getUint32(0, true) === 0x46523550 && view.getUint8(19) & 1 &&
            view.getUint8(18) === 1 && view.getUint32(44, true) > 0) {
          globalThis.kept.push({ message: event.data, state: globalThis.pxpl5.state,
                                 revision: view.getUint32(8, true) });
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
                    messages: await load('link/messages.js') };
  /** A kept frame, decoded; `pixels` has red, green, blue, alpha. */
  modules.open = async ({ message, state }) => {
    const { header, picture, depths } = modules.messages.parseFrame(message);
    const bitmap = await createImageBitmap(new Blob([picture], { type: 'image/png' }));
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const lean = await modules.lean.unpack(depths[0], width, height);
    const shows = (x, y) => lean.mask[y * Math.ceil(width / 8) + (x >> 3)] >> (x & 7) & 1;
    return { header, bitmap, lean, shows, width, height, camera: state.camera, state,
             depth_bytes: depths[0].length, bytes: message.byteLength,
             pixels: context.getImageData(0, 0, width, height).data };
  };
  /** The pixels of a frame as seen from a view, and the share that is drawn. */
  modules.warp = (frame, view, background) => {
    const canvas = document.createElement('canvas');
    const painter = new modules.painter.WarpPainter(canvas);
    const { cameraAt, multiply, inverse } = modules.camera, aspect = frame.width / frame.height;
    const clip = each => cameraAt(each, frame.camera, aspect).patient_to_clip;
    painter.take(frame.bitmap, [frame.lean]);
    painter.begin(frame.width, frame.height, background);
    painter.draw(0, multiply(clip(view), inverse(clip(frame.camera))),
                 view.zoom / frame.camera.zoom);
    const gl = canvas.getContext('webgl2'), { width, height } = frame;
    const bottomUp = new Uint8Array(width * height * 4), pixels = new Uint8Array(bottomUp.length);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bottomUp);
    for (let y = 0; y < height; y++) {
      pixels.set(bottomUp.subarray((height - 1 - y) * width * 4, (height - y) * width * 4),
                 y * width * 4);
    }
    gl.getExtension('WEBGL_lose_context').loseContext();
    return pixels;
  };
  globalThis.modules = modules;
}

/** A kept frame, warped to its own viewpoint, beside the frame itself. */
export async function warpedFrame(index) {
  const { modules, kept } = globalThis;
  const frame = await modules.open(kept[index]);
  const pixels = modules.warp(frame, frame.camera, frame.state.background);
  let differing = 0, covered = 0;
  for (let at = 0; at < pixels.length; at += 4) {
    covered += frame.shows(at / 4 % frame.width, Math.floor(at / 4 / frame.width));
    differing += [0, 1, 2].some(k => pixels[at + k] !== frame.pixels[at + k]) ? 1 : 0;
  }
  return { differing, covered, background: frame.width * frame.height - covered };
}

/** A kept frame warped to the viewpoint of another, beside the other. */
export async function comparePictures([first, second]) {
  const { modules, kept } = globalThis;
  const [late, exact] = [await modules.open(kept[first]), await modules.open(kept[second])];
  const { width, height } = exact;
  // A background that no surface has, to find what is not known.
  const key = [255, 0, 255];
  const keyed = modules.warp(late, exact.camera, '#ff00ff');
  const warped = modules.warp(late, exact.camera, exact.state.background);
  let unknown = 0, covered = 0;
  for (let at = 0; at < keyed.length; at += 4) {
    const shows = exact.shows(at / 4 % width, Math.floor(at / 4 / width));
    covered += shows;
    unknown += shows && key.every((part, k) => keyed[at + k] === part) ? 1 : 0;
  }
  const mean = (pixels, x, y, k) => {
    let sum = 0;
    for (let i = 0; i < 16; i++) sum += pixels[((y + (i >> 2)) * width + x + (i & 3)) * 4 + k];
    return sum / 16;
  };
  const inBlock = (x, y, holds) => [0, 1, 2, 3].some(i => [0, 1, 2, 3].some(j =>
    holds(x + i, y + j)));
  const isUnknown = (x, y) => exact.shows(x, y) &&
    key.every((part, k) => keyed[(y * width + x) * 4 + k] === part);
  // Blocks that show a surface. Unknown pixels are counted above, and have no color to compare.
  const db = pixels => {
    let sum = 0, count = 0;
    for (let y = 0; y + 4 <= height; y += 4) {
      for (let x = 0; x + 4 <= width; x += 4) {
        if (!inBlock(x, y, exact.shows) || inBlock(x, y, isUnknown)) continue;
        for (let k = 0; k < 3; k++) {
          sum += (mean(pixels, x, y, k) - mean(exact.pixels, x, y, k)) ** 2;
          ++count;
        }
      }
    }
    return 10 * Math.log10(255 * 255 * count / sum);
  };
  return { warped_db: db(warped), late_db: db(late.pixels), unknown: unknown / covered,
           bytes: late.bytes, depth_bytes: late.depth_bytes };
}
