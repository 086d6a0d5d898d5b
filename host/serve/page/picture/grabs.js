// Marks over the picture that a pointer drags, instead of turning the patient.

/**
 * A mark that a pointer drags.
 * @typedef {object} Grab
 * @property {(event: PointerEvent) => void} move
 * @property {(event: PointerEvent) => void} drop
 * @property {() => void} cancel
 */

export class Grabs {
  constructor() {
    /**
     * What a pressed pointer would grab; null for nothing. A panel sets it.
     * @type {(event: PointerEvent) => Grab | null}
     */
    this.at = () => null;
    /** @private @type {Grab | null} */ this.held_ = null;
    /** @private Finger or mouse that holds it. */ this.pointer_ = 0;
    /** @private Whether the pointer has moved. */ this.isUsed_ = false;
    /** @private Esc was pressed: the rest of the movement has no effect. */ this.isOver_ = false;
  }

  /** @param {PointerEvent | null} event  Null: this pointer cannot grab, and ends a drag. */
  press(event) {
    this.cancel();
    this.held_ = event && this.at(event);
    this.pointer_ = event?.pointerId ?? 0;
    this.isUsed_ = false;
    this.isOver_ = false;
  }

  /**
   * The pointer was dragged. Returns whether it drags a mark.
   * @param {PointerEvent} event
   */
  move(event) {
    if (event.pointerId !== this.pointer_) {
      return false;
    }
    if (this.held_) {
      this.isUsed_ = true;
      this.held_.move(event);
    }
    return this.isOver_ || this.held_ !== null;
  }

  /**
   * The pointer was lifted or lost.
   * @param {PointerEvent} event
   */
  end(event) {
    if (event.pointerId === this.pointer_) {
      const held = this.held_;
      this.held_ = null;
      this.isOver_ = false;
      if (event.type === 'pointerup' && this.isUsed_) {
        held?.drop(event);
      } else {
        held?.cancel();
      }
    }
  }

  /** Puts the mark back. Returns whether one was dragged. */
  cancel() {
    const held = this.held_;
    this.held_ = null;
    this.isOver_ = held !== null;
    held?.cancel();
    return held !== null && this.isUsed_;
  }
}
