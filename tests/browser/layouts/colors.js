// Colors as people see them: contrast, differences, and eyes that lack a kind of cones.

/**
 * Linear RGB of a color as eyes see it. G. M. Machado, M. M. Oliveira, L. A. F. Fernandes: A
 * Physiologically-based Model for Simulation of Color Vision Deficiency, IEEE TVCG 15 (6), 2009;
 * severity 1.0.
 */
export const EYES = {
  'all cones': [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
               [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                 [-0.011820, 0.042940, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
               [0.004733, 0.691367, 0.303900]],
};

/** Red, green, blue and opacity of `#rgb`, `#rgba`, `#rrggbb` or `#rrggbbaa`, from 0 to 1. */
export function parsed(hex) {
  const digits = hex.length < 6 ? [...hex.slice(1)].map(each => each + each)
    : hex.slice(1).match(/../g);
  const [r, g, b, a = 1] = digits.map(each => parseInt(each, 16) / 255);
  return [r, g, b, a];
}

/** A color with opacity over another one, as browsers mix them. */
export function over([r, g, b, a], below) {
  return [r, g, b].map((each, k) => each * a + below[k] * (1 - a));
}

const linear = c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;

/** Relative luminance of sRGB. */
export function luminance([r, g, b]) {
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

/** WCAG's contrast of two colors, 1 to 21. */
export function contrast(a, b) {
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light + 0.05) / (dark + 0.05);
}

/** CIELAB (D65) of an sRGB color as `eyes`, of EYES, see it. */
export function labOf(color, eyes = 'all cones') {
  const light = color.slice(0, 3).map(linear);
  const [r, g, b] = EYES[eyes].map(row =>
    Math.min(1, Math.max(0, row.reduce((sum, each, k) => sum + each * light[k], 0))));
  const [x, y, z] = [(0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047,
                     0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
                     (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883]
    .map(t => t > 216 / 24389 ? Math.cbrt(t) : (24389 / 27 * t + 16) / 116);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

const degrees = radians => radians * 180 / Math.PI, radians = degrees => degrees * Math.PI / 180;
const hue = (b, a) => a === 0 && b === 0 ? 0 : (degrees(Math.atan2(b, a)) + 360) % 360;

/**
 * CIEDE2000 of two colors in CIELAB. G. Sharma, W. Wu, E. N. Dalal: The CIEDE2000 Color-Difference
 * Formula, Color Research and Application 30 (1), 2005.
 */
export function difference([l1, a1, b1], [l2, a2, b2]) {
  const mean7 = ((Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2) ** 7;
  const g = 0.5 * (1 - Math.sqrt(mean7 / (mean7 + 25 ** 7)));
  const [c1, c2] = [Math.hypot(a1 * (1 + g), b1), Math.hypot(a2 * (1 + g), b2)];
  const [h1, h2] = [hue(b1, a1 * (1 + g)), hue(b2, a2 * (1 + g))];
  let turn = c1 * c2 === 0 ? 0 : h2 - h1;
  if (Math.abs(turn) > 180) turn -= 360 * Math.sign(turn);
  const dh = 2 * Math.sqrt(c1 * c2) * Math.sin(radians(turn / 2));
  const l = (l1 + l2) / 2, c = (c1 + c2) / 2;
  const h = c1 * c2 === 0 ? h1 + h2 : Math.abs(h1 - h2) <= 180 ? (h1 + h2) / 2
    : (h1 + h2 + (h1 + h2 < 360 ? 360 : -360)) / 2;
  const t = 1 - 0.17 * Math.cos(radians(h - 30)) + 0.24 * Math.cos(radians(2 * h)) +
    0.32 * Math.cos(radians(3 * h + 6)) - 0.2 * Math.cos(radians(4 * h - 63));
  const sl = 1 + 0.015 * (l - 50) ** 2 / Math.sqrt(20 + (l - 50) ** 2);
  const sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const rc = 2 * Math.sqrt(c ** 7 / (c ** 7 + 25 ** 7));
  const rt = -Math.sin(radians(60 * Math.exp(-(((h - 275) / 25) ** 2)))) * rc;
  const [x, y, z] = [(l2 - l1) / sl, (c2 - c1) / sc, dh / sh];
  return Math.sqrt(x * x + y * y + z * z + rt * y * z);
}

/** The least difference of two colors over all kinds of eyes, and the eyes that see it. */
export function least(a, b) {
  return Object.keys(EYES)
    .map(eyes => ({ eyes, value: difference(labOf(a, eyes), labOf(b, eyes)) }))
    .reduce((x, y) => y.value < x.value ? y : x);
}
