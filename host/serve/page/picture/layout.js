// The place of the picture in its panel.

const MOST_MARGIN_PX = 4;

/**
 * Scales a picture so that all of it fits into its panel. Alternate rows are shown pixel by pixel
 * in any case.
 * @param {DOMRect} box            Of the panel.
 * @param {number[]} pixels        Width and height of the picture.
 * @param {boolean} areRows        Whether each row of the picture is one of the screen.
 * @returns {{width: number, height: number, left: string, top: string, isCut: boolean}}
 *     CSS pixels; CSS offsets from the middle; whether the panel is too small
 */
export function placed(box, [width, height], areRows) {
  const fit = Math.min(box.width / width, box.height / height), sharp = 1 / devicePixelRatio;
  // A picture that was made for this panel is shown pixel by pixel, with a narrow margin.
  const scale = areRows || fit >= sharp
    && (fit - sharp) * Math.min(width, height) < MOST_MARGIN_PX ? sharp : fit;
  const across = width * scale, down = height * scale;
  // In the middle of the panel, a row may lie between two rows of the screen.
  const offset = (/** @type {number} */ first, /** @type {number} */ space) =>
    areRows ? `${Math.round((first + space / 2) * devicePixelRatio) / devicePixelRatio
      - first - space / 2}px` : '';
  return {width: across, height: down, left: offset(box.left, box.width - across),
    top: offset(box.top, box.height - down), isCut: areRows && fit < sharp};
}

/**
 * Gives a panel the shape of a picture while `act` runs, at least as large as it was. A hidden
 * panel is shown meanwhile.
 * @param {number[]} pixels        Width and height of the picture.
 * @param {HTMLElement} panel
 * @param {number[]} former        Size of the picture that a hidden panel had, pixels.
 * @param {() => void} act
 * @param {() => void} then        Called afterwards in any case, in the former shape.
 */
export function inShapeOf([width, height], panel, former, act, then) {
  const wasHidden = panel.hidden, box = panel.getBoundingClientRect();
  const [across, down] = wasHidden ? former.map(each => each / devicePixelRatio)
    : [box.width, box.height];
  const scale = Math.min(width / across, height / down);
  panel.hidden = false;
  try {
    Object.assign(panel.style,
      {flex: 'none', width: `${width / scale}px`, height: `${height / scale}px`});
    act();
  } finally {
    Object.assign(panel.style, {flex: '', width: '', height: ''});
    panel.hidden = wasHidden;
    then();
  }
}
