// The behavior that modal dialogs share.

/**
 * Closes `dialog` by a click beside it. A press inside that ends beside it, as when text is
 * selected, does not count.
 * @param {HTMLDialogElement} dialog
 * @param {() => void} [close]
 */
export function closeBeside(dialog, close = () => dialog.close()) {
  let pressed = false;
  dialog.addEventListener('pointerdown', event => {
    pressed = event.target === dialog;
  });
  dialog.addEventListener('click', event => {
    if (pressed && event.target === dialog) {
      close();
    }
  });
}
