/** Form of a new task. */

import { make, say } from "../dom.js";
import { orderForm } from "../order_form.js";
import { MOST_PLACES, floorsOf, labelsOf, lineOf, placesOf } from "./task_words.js";

const KINDS = { go_to: "Go to a place", pick_drop: "Pick at one place, drop at another", patrol: "Patrol along places" };

export class TaskForm {
  #kind = make("select", { name: "kind" }, ...Object.entries(KINDS).map(([value, textContent]) => make("option", { value, textContent })));
  #places = make("textarea", { name: "places", rows: 3, required: true, spellcheck: false, maxLength: 4000, placeholder: "10.0 8.0 90" });
  #rounds = make("input", { name: "rounds", type: "number", min: 1, max: 1000, step: 1, value: 1, inputMode: "numeric" });
  #priority = make("input", { name: "priority", type: "number", min: -100, max: 100, step: 1, value: 0, inputMode: "numeric" });
  #minutes = make("input", { name: "minutes", type: "number", min: 1, max: 100_000, step: 1, inputMode: "numeric", placeholder: "none" });
  #labels = make("input", { name: "labels", placeholder: "lift=yes", maxLength: 400, autocapitalize: "none", spellcheck: false });
  #roundsLabel = make("label", {}, "Rounds", this.#rounds);
  #error = make("p", { className: "error", role: "alert" });
  #now;
  #pick;

  element = make("details", { className: "go" }, make("summary", { textContent: "Add a task" }));

  /**
   * @param {(task: object) => Promise<void>} add @param {() => number} now clock of the cloud [s since the epoch]
   * @param {(most: number, done: (places: import("../geometry.js").Point[]) => void) => void} pick asks for places on the map
   */
  constructor(add, now, pick) {
    this.#now = now;
    this.#pick = pick;
    const onMap = make("button", { className: "button", type: "button", textContent: "Pick on the map", onclick: () => this.#pickPlaces() });
    this.#kind.addEventListener("change", () => this.#showRounds());
    const row = make("div", { className: "fields" }, this.#roundsLabel, make("label", {}, "Priority", this.#priority),
      make("label", {}, "Must begin within [min]", this.#minutes), make("label", {}, "Robot with labels", this.#labels));
    const form = orderForm("Add a task", "Add", () => this.#send(add), make("label", {}, "What", this.#kind),
      make("label", {}, "Places, one a line: x and y [m], heading [°] if it matters; on another floor L2: x y", this.#places), onMap, row, this.#error);
    this.element.append(form);
    this.#showRounds();
  }

  #showRounds() {
    this.#roundsLabel.hidden = this.#kind.value !== "patrol";
  }

  /** Add the places that the user picks on the map, as many as are missing. */
  #pickPlaces() {
    const written = this.#places.value.split("\n").filter((line) => line.trim());
    const before = written.length < MOST_PLACES[this.#kind.value] ? written : []; // else they are replaced
    this.#pick(MOST_PLACES[this.#kind.value] - before.length, (places) => {
      if (places.length) this.#places.value = [...before, ...places.map(lineOf)].join("\n");
    });
  }

  async #send(add) {
    say(this.#error, "");
    try {
      await add(this.#task());
      this.#places.value = "";
    } catch (error) {
      say(this.#error, error.message);
    }
  }

  #task() {
    const kind = this.#kind.value;
    const minutes = this.#minutes.valueAsNumber;
    const floors = floorsOf(this.#places.value);
    return {
      kind, ...(floors.length && { floors }), places: placesOf(this.#places.value), priority: this.#priority.valueAsNumber || 0, labels: labelsOf(this.#labels.value),
      ...(kind === "patrol" && { rounds: this.#rounds.valueAsNumber || 1 }), ...(minutes > 0 && { deadline: this.#now() + 60 * minutes }),
    };
  }
}
