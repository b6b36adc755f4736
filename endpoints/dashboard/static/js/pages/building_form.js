/** Form with the record of a building: its floors, and the settings of lifts, doors and ways, each a row of fields. */

import { make } from "../dom.js";
import { PARTS, WAYS, partOf, valuesOf } from "./building_words.js";

const LONGEST = 512;

export class BuildingForm {
  /** @type {HTMLFormElement} */ element;
  /** Rows of each part: what they were, their fields and their element. @type {Record<string, {before: object, inputs: Record<string, HTMLInputElement>, element: HTMLElement}[]>} */ #rows = {};
  #lists = {};
  #maps;
  #changed;
  #mayEdit;

  /**
   * @param {Record<string, object[]>} building @param {string[]} maps ids of maps that a floor may have
   * @param {boolean} mayEdit @param {() => void} changed
   */
  constructor(building, maps, mayEdit, changed) {
    this.#maps = maps;
    this.#mayEdit = mayEdit;
    this.#changed = changed;
    this.element = make("form", { className: "building-form", "aria-label": "Building" });
    for (const [part, { title, one }] of Object.entries(PARTS)) {
      this.#rows[part] = [];
      this.#lists[part] = make("div", { className: "building-rows" });
      const more = make("button", { className: "button", type: "button", textContent: `Add ${one}`, hidden: !mayEdit, onclick: () => this.#add(part) });
      this.element.append(make("section", { "aria-label": title }, make("h4", { textContent: title }), this.#lists[part], more));
      for (const given of building[part] ?? []) this.#addRow(part, given);
    }
    this.element.addEventListener("submit", (event) => event.preventDefault());
    this.element.addEventListener("input", () => changed());
    this.element.addEventListener("change", (event) => event.target.name === "name" && this.#renameFloors());
  }

  /** What the fields say. @returns {Record<string, object[]>} */
  get building() {
    const made = {};
    for (const [part, rows] of Object.entries(this.#rows)) {
      const found = rows.map(({ inputs, before }) => partOf(part, Object.fromEntries(Object.entries(inputs).map(([key, input]) => [key, input.value])), before));
      if (found.length || part === "floors") made[part] = found;
    }
    return made;
  }

  #add(part) {
    const row = this.#addRow(part, {});
    this.#changed();
    row.querySelector("input, select").focus();
  }

  #addRow(part, given) {
    const { one, fields } = PARTS[part];
    const values = valuesOf(part, given);
    const inputs = Object.fromEntries(fields.map((field) => [field.key, this.#input(field, values[field.key])]));
    const labels = fields.map((field) => make("label", {}, field.title, inputs[field.key]));
    const remove = make("button", { className: "button stop", type: "button", textContent: "Remove", hidden: !this.#mayEdit, onclick: () => this.#remove(part, row) });
    const name = make("legend", { textContent: `${one[0].toUpperCase()}${one.slice(1)} ${given[fields[0].key === "floor" ? "door" : fields[0].key] ?? ""}`.trim() });
    const row = { before: given, inputs, element: make("fieldset", { className: "fields building-row", disabled: !this.#mayEdit }, name, ...labels, remove) };
    this.#rows[part].push(row);
    this.#lists[part].append(row.element);
    return row.element;
  }

  #remove(part, row) {
    this.#rows[part] = this.#rows[part].filter((one) => one !== row);
    row.element.remove();
    this.#renameFloors();
    this.#changed();
  }

  /** @param {import("./building_words.js").Field} field @param {string} value */
  #input({ key, kind, required = false, min, max, step = "any", placeholder = "" }, value) {
    if (kind === "number") {
      return make("input", { name: key, type: "number", step, inputMode: "decimal", value, placeholder, required, ...(min !== undefined && { min }), ...(max !== undefined && { max }) });
    }
    const choices = this.#choices(kind);
    if (!choices) return make("input", { name: key, value, placeholder, required, maxLength: LONGEST, autocapitalize: "none", autocomplete: "off", spellcheck: false });
    const select = make("select", { name: key, required });
    fillSelect(select, choices, value);
    return select;
  }

  #choices(kind) {
    if (kind === "map") return this.#maps;
    if (kind === "way") return WAYS;
    if (kind === "floor") return this.#floors;
    return kind === "floors" ? ["", ...this.#floors] : null;
  }

  get #floors() {
    return this.#rows.floors.map(({ inputs }) => inputs.name.value.trim()).filter(Boolean);
  }

  /** Offer the floors that there are now. */
  #renameFloors() {
    for (const { inputs } of this.#rows.doors) fillSelect(inputs.floor, this.#floors, inputs.floor.value);
    for (const { inputs } of this.#rows.ways) fillSelect(inputs.one_way, ["", ...this.#floors], inputs.one_way.value);
  }
}

/** Offer choices; one that is chosen already stays, also if it is no choice any more. */
function fillSelect(select, choices, value) {
  const all = value && !choices.includes(value) ? [...choices, value] : choices;
  select.replaceChildren(...all.map((each) => make("option", { value: each, textContent: each || "both ends" })));
  select.value = value || all[0] || "";
}
