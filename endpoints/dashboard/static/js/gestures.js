/**
 * Gestures on the map. One finger or the left button aims or pans, depending on the tool; two fingers or any other
 * button always pan; two fingers and the wheel zoom.
 *
 * @typedef {import("./geometry.js").Point} Point pixels
 * @typedef {{
 *   aims: () => boolean,
 *   aim: (from: Point, to: Point | null) => void,
 *   tap: (at: Point) => void,
 *   release: (from: Point, to: Point) => void,
 *   drop: () => void,
 *   pan: (dx: number, dy: number) => void,
 *   zoom: (at: Point, factor: number) => void,
 * }} Meaning
 */

/** Movement of a finger that still counts as a tap [pixels]. */
const TREMBLE = 8;

export class Gestures {
  /** @type {Map<number, Point>} */ #fingers = new Map();
  /** Where the one finger went down, and what it does. */
  #from = null;
  #aiming = false;
  #moved = false;
  #many = false;
  #meaning;
  #canvas;

  /** @param {HTMLElement} canvas @param {Meaning} meaning */
  constructor(canvas, meaning) {
    this.#canvas = canvas;
    this.#meaning = meaning;
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#move(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", (event) => this.#cancel(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  /** Cancel the gesture in progress. */
  #reset() {
    if (this.#aiming) this.#meaning.drop();
    this.#from = null;
    this.#aiming = false;
  }

  #point(event) {
    const box = this.#canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  #down(event) {
    this.#canvas.setPointerCapture(event.pointerId);
    const at = this.#point(event);
    this.#fingers.set(event.pointerId, at);
    if (this.#fingers.size > 1) {
      this.#many = true;
      this.#reset();
      return;
    }
    this.#many = false;
    this.#moved = false;
    this.#from = event.button === 0 ? at : null;
    this.#aiming = event.button === 0 && this.#meaning.aims();
    if (this.#aiming) this.#meaning.aim(at, null);
  }

  #move(event) {
    const before = this.#fingers.get(event.pointerId);
    if (!before) return;
    const at = this.#point(event);
    if (this.#many) this.#pinch(event.pointerId, before, at);
    this.#fingers.set(event.pointerId, at);
    if (this.#many) return;
    this.#moved ||= !this.#from || Math.hypot(at.x - this.#from.x, at.y - this.#from.y) > TREMBLE;
    if (this.#aiming) this.#meaning.aim(this.#from, this.#moved ? at : null);
    else if (this.#moved) this.#meaning.pan(at.x - before.x, at.y - before.y);
  }

  #pinch(moving, before, at) {
    const still = [...this.#fingers].find(([id]) => id !== moving)?.[1];
    if (!still) return;
    const [was, is] = [Math.hypot(before.x - still.x, before.y - still.y), Math.hypot(at.x - still.x, at.y - still.y)];
    this.#meaning.pan((at.x - before.x) / 2, (at.y - before.y) / 2);
    if (was > 1 && is > 1) this.#meaning.zoom({ x: (at.x + still.x) / 2, y: (at.y + still.y) / 2 }, is / was);
  }

  #up(event) {
    const at = this.#point(event);
    this.#fingers.delete(event.pointerId);
    if (this.#many || !this.#from) return;
    const [from, aimed] = [this.#from, this.#aiming];
    this.#from = null;
    this.#aiming = false;
    if (!this.#moved) this.#meaning.tap(from);
    else if (aimed) this.#meaning.release(from, at);
  }

  #cancel(event) {
    this.#fingers.delete(event.pointerId);
    this.#reset();
  }

  #wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    this.#meaning.zoom(this.#point(event), Math.exp(-event.deltaY * lines * 0.0015));
  }
}
