/** Places that the user picks on the map, a click each, for a form that takes coordinates. */

import { byId, say } from "./dom.js";
import { plural } from "./format.js";
import { label, target } from "./shapes.js";

const HINT = "Click each place, then Done; Backspace takes the last one back";

export class PlacePicker {
  /** @type {import("./theme.js").Theme} */ theme;
  /** @type {import("./geometry.js").Point[]} */ #places = [];
  #most = 0;
  /** Takes the places; null while none are picked. @type {((places: import("./geometry.js").Point[]) => void) | null} */ #done = null;
  #events;

  /** @param {{changed: () => void, draws: (hint: string) => void}} events */
  constructor(events) {
    this.#events = events;
    byId("picking-end").addEventListener("click", () => this.#end(this.#places));
    byId("picking-cancel").addEventListener("click", () => this.#end([]));
    addEventListener("hashchange", () => location.hash.length > 1 && this.drop()); // a page covers the map
  }

  /** Whether the user picks places now, so that clicks on the map are for this. */
  get isDrawing() {
    return this.#done !== null;
  }

  /** Begin to pick. @param {number} most places, after which it ends @param {(places: import("./geometry.js").Point[]) => void} done gets none if the user cancels */
  begin(most, done) {
    this.#most = most;
    this.#done = done;
    this.#places = [];
    this.#show();
    byId("map").focus({ preventScroll: true });
  }

  /** Pick no longer; nobody gets the places. */
  drop() {
    if (!this.isDrawing) return;
    this.#done = null;
    this.#places = [];
    this.#show();
  }

  /** Take a click on the map. @param {import("./geometry.js").Point} point */
  click({ x, y }) {
    this.#places.push({ x, y });
    if (this.#places.length >= this.#most) this.#end(this.#places);
    else this.#show();
  }

  /** Nothing follows the pointer. */
  hover() {}

  /** Take a key; return whether it has a meaning. @param {string} key @param {import("./geometry.js").Point} middle of the map */
  key(key, middle) {
    const meanings = { Enter: () => this.#end(this.#places), Escape: () => this.#end([]), Backspace: () => this.#undo(), " ": () => this.click(middle) };
    if (!(key in meanings)) return false;
    meanings[key]();
    return true;
  }

  /** Draw what is picked. @param {CanvasRenderingContext2D} context @param {import("./view.js").View} view */
  draw(context, view) {
    this.#places.forEach((place, i) => {
      const at = view.toScreen(place);
      target(context, at, null, this.theme.ink, this.theme.halo);
      label(context, String(i + 1), at.x, at.y + 14, this.theme.ink, this.theme.halo, true);
    });
  }

  #undo() {
    this.#places.pop();
    this.#show();
  }

  #end(places) {
    const done = this.#done;
    this.drop();
    done?.(places);
  }

  #show() {
    byId("picking").hidden = !this.isDrawing;
    say(byId("picking-count"), plural(this.#places.length, "place"));
    byId("picking-end").disabled = !this.#places.length;
    byId("map").toggleAttribute("data-drawing", this.isDrawing);
    this.#events.draws(this.isDrawing ? HINT : "");
    this.#events.changed();
  }
}
