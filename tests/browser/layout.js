// Checks of a page's layout. Each function runs inside the page, so it uses nothing else of this
// file. Each returns sentences, unless its comment names another result.

/** Texts whose contrast to their background is below WCAG's 4.5 (3 for large text). */
function faintText() {
  const parse = text => (text.match(/[\d.]+/g) ?? []).map(Number);
  const over = ([r, g, b, a = 1], below) => [r, g, b].map((c, i) => c * a + below[i] * (1 - a));
  const behind = element => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) {
      layers.unshift(parse(getComputedStyle(at).backgroundColor));
    }
    return layers.reduce((below, layer) => over(layer, below), [15, 17, 20]);
  };
  const luminance = color => {
    const [r, g, b] = color.map(c => c / 255)
      .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    const text = walker.currentNode.textContent.trim();
    if (!text || !element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) ||
        element.closest(':disabled, [aria-disabled=true], svg, option')) continue;
    const style = getComputedStyle(element);
    const ground = behind(element);
    const ink = over(parse(style.color), ground);
    const [dark, light] = [luminance(ink), luminance(ground)].sort((a, b) => a - b);
    const contrast = (light + 0.05) / (dark + 0.05);
    const large = parseFloat(style.fontSize) >= 24 ||
      (parseFloat(style.fontSize) >= 18.66 && Number(style.fontWeight) >= 700);
    if (contrast < (large ? 3 : 4.5)) found.push(`'${text.slice(0, 40)}' ${contrast.toFixed(2)}`);
  }
  return found;
}

/** Numbers every control that Tab should reach; returns {mark, what} of each. */
function markFocusable() {
  const controls = document.querySelectorAll(
    'button, input, select, textarea, a[href], summary, [tabindex]');
  return [...controls].filter(element => {
    element.removeAttribute('data-mark');
    if (element.tabIndex < 0 || element.disabled || !element.checkVisibility()) return false;
    return element.type !== 'radio' || element.checked;
  }).map((element, index) => {
    element.setAttribute('data-mark', index);
    const what = element.getAttribute('data-testid') ?? element.outerHTML.slice(0, 120);
    return { mark: String(index), what };
  });
}

/**
 * Returns the mark of the focused element (null if it has none), and whether the focus is visible:
 * whether the element or its parts look different without the focus.
 */
function focused() {
  const element = document.activeElement;
  const places = [element, element.parentElement, ...element.querySelectorAll('*')].filter(Boolean);
  const looks = () => places.map(each => {
    const { outlineStyle, outlineWidth, outlineColor, boxShadow, stroke, strokeWidth,
            backgroundColor, borderColor } = getComputedStyle(each);
    const outline = outlineStyle === 'none' ? '' : outlineStyle + outlineWidth + outlineColor;
    return [outline, boxShadow, stroke, strokeWidth, backgroundColor, borderColor].join();
  }).join('\n');
  const mark = element.getAttribute('data-mark');
  const what = element.getAttribute('data-testid') ?? element.outerHTML.slice(0, 120);
  if (mark === null) return { mark, what, visible: false };
  const before = looks();
  element.blur();
  const visible = looks() !== before;
  element.focus();
  return { mark, what, visible };
}

/** Controls that cannot be reached by a pointer, and texts that are cut off. */
function misplaced() {
  const found = [];
  const nameOf = element => element.getAttribute('data-testid') ?? element.outerHTML.slice(0, 120);
  const root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) {
    found.push(`the page is ${root.scrollWidth} px wide, the window ${root.clientWidth}`);
  }
  const controls = document.querySelectorAll('button, input, select, summary, [role=slider]');
  for (const element of controls) {
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    if (element.type === 'file' || element.closest('.unseen')) continue;
    element.scrollIntoView({ block: 'center', inline: 'nearest' });
    // A handle of the histogram is as wide as its label, which takes no pointer's hold.
    const held = element.querySelector('.reach') ?? element;
    const box = held.getBoundingClientRect();
    const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
    const top = document.elementFromPoint(x, y);
    const own = top && (element.contains(top) || top.contains(element) ||
      top.closest('label')?.contains(element));
    if (x < 0 || y < 0 || x > innerWidth || y > innerHeight) {
      found.push(`${nameOf(element)} lies outside of the window`);
    } else if (!own) {
      found.push(`${nameOf(element)} is covered by ${top ? nameOf(top) : 'nothing'}`);
    }
  }
  const texts = document.querySelectorAll('button, h1, h2, h3, p, dt, dd, label, summary');
  for (const element of texts) {
    if (!element.checkVisibility() || element.closest('.unseen')) continue;
    const style = getComputedStyle(element);
    const cut = style.overflowX !== 'visible' && style.textOverflow !== 'ellipsis' &&
      element.scrollWidth > element.clientWidth + 1;
    const box = element.getBoundingClientRect();
    const holder = element.parentElement.getBoundingClientRect();
    const out = style.position === 'static' && box.right > holder.right + 1;
    if (cut || out) found.push(`'${element.textContent.slice(0, 60)}' is wider than its place`);
  }
  return found;
}

export const lookFor = { faintText, focused, markFocusable, misplaced };
