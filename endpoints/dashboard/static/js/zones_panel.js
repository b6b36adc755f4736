/** Panel of the zones of the shown map: which there are and which are in force; for the map's owner, how to change them. */

import { byId, make, say, show } from "./dom.js";
import { ZoneForm } from "./zone_form.js";
import { linesOf } from "./zone_shapes.js";
import { KINDS, told } from "./zones_state.js";

const PRESENCES = { "in force": "online", "not in force": "offline", "not saved": "silent" };
/** What may be drawn: zones of all kinds, and both kinds of lines. */
const { station: _station, ...DRAWN } = KINDS; // stations come with graphs and files
const SHAPES = { ...DRAWN, one_way: "One way, an area", one_way_line: "One way, a line" };
const KINDS_OF_LINES = { lane: "lane", one_way_line: "one_way", door: "door" };
const KINDS_OF_POINTS = ["passage", "dock"];

/** What the user may do next, in words. @param {import("./zone_shapes.js").Drawing} drawing */
export function guide({ missing, isLine, isPoint }) {
  if (isPoint) return "Click the place on the map, or press the space bar to put it in its middle. Escape cancels.";
  const left = missing ? `${missing} more ${missing === 1 ? "is" : "are"} needed. ` : "";
  return `Click the ${isLine ? "points of the line" : "corners"} on the map, or press the space bar to put one in its middle. ${left}` +
    "A double-click or Enter ends it, Backspace takes one back, Escape cancels.";
}

/** How things are with the zones, in words; empty if all is well. @param {import("./zones_state.js").ZonesState} state */
export function noteOf({ problem, warnings = [], isOutdated, isChanged }) {
  if (problem && !isOutdated) return problem;
  if (isOutdated) return `${problem ? `${problem} ` : ""}Somebody else has changed the zones meanwhile: reload them, and make your changes again.`;
  return isChanged ? ["Not saved yet", ...warnings].join(". ") : "";
}

export class ZonesPanel {
  #panel = byId("panel-zones");
  #orders;
  #parts;
  #isSaving = false;
  #isOutdated = false;
  /** Forms by the keys of their items. @type {Map<string, {made: string, form: ZoneForm}>} */ #forms = new Map();

  /**
   * @param {{pick: (index: number) => void, colourOf: (kind: string) => string, draw: (kind: string, isLine: boolean, isPoint: boolean) => void,
   *          end: () => void, undo: () => void, cancel: () => void, replace: (index: number, zone: object) => void,
   *          remove: (index: number) => void, zone: (name: string) => void, save: () => Promise<void>, discard: () => void}} orders
   */
  constructor(orders) {
    this.#orders = orders;
    const button = (textContent, onclick, className = "button") => make("button", { className, type: "button", textContent, onclick });
    const kind = make("select", { name: "new-zone" }, ...Object.entries(SHAPES).map(([value, textContent]) => make("option", { value, textContent })));
    const add = () => orders.draw(KINDS_OF_LINES[kind.value] ?? kind.value, kind.value in KINDS_OF_LINES, KINDS_OF_POINTS.includes(kind.value));
    const timeZone = make("input", { name: "time-zone", autocomplete: "off", spellcheck: false, maxLength: 64, onchange: () => orders.zone(timeZone.value.trim() || "UTC") });
    this.#parts = {
      adding: make("div", { className: "zone-add" }, make("label", {}, "New zone", kind), button("Add zone", add)),
      drawing: make("div", { className: "actions" }, button("Finish", orders.end), button("Undo corner", orders.undo), button("Cancel", orders.cancel)),
      guide: make("p", { className: "muted", role: "status" }),
      timeZone,
      zone: make("label", {}, "Time zone of all hours", timeZone),
      save: button("Save", () => this.#save(), "button primary"),
      discard: button("Discard", orders.discard),
      changes: make("div", { className: "actions" }),
    };
    const { adding, drawing, guide: text, zone, save, discard, changes } = this.#parts;
    changes.append(save, discard);
    byId("zones-edit").append(adding, text, drawing, zone, changes);
  }

  /** @param {import("./zones_state.js").ZonesState} state @param {import("./zone_shapes.js").Drawing | null} drawing */
  update(state, drawing) {
    this.#panel.hidden = !state.features.length && !(state.answer && state.mayEdit);
    if (this.#panel.hidden) return;
    say(byId("zone-count"), state.features.length ? String(state.features.length) : "");
    byId("zones-note").classList.toggle("error", Boolean(state.problem) || state.isOutdated);
    say(byId("zones-note"), noteOf(state));
    const items = state.features.map((zone, index) => ({ zone, index, key: `${state.generation} ${index}` }));
    show(byId("zones"), items, ({ key }) => key, (item) => this.#create(item), (element, item) => this.#fill(element, item, state));
    for (const key of this.#forms.keys()) if (!items.some((item) => item.key === key && item.index === state.picked)) this.#forms.delete(key);
    this.#showEditing(state, drawing);
  }

  /** Make the entry of a zone visible, which was picked on the map. @param {number} index */
  reveal(index) {
    byId("zones").children[index]?.scrollIntoView({ block: "nearest" });
  }

  #create({ index }) {
    const head = make("button", { className: "robot", type: "button", onclick: () => this.#orders.pick(index) },
      make("span", { className: "swatch" }), make("span", { className: "name" }), make("span", { className: "presence" }), make("span", { className: "doing" }));
    return make("li", {}, head, make("div", { className: "zone-more" }));
  }

  #fill(element, { zone, index, key }, state) {
    const [head, more] = element.children;
    const [swatch, name, presence, what] = head.children;
    swatch.style.background = this.#orders.colourOf(zone.properties.kind);
    say(name, zone.properties.name);
    name.title = zone.properties.name;
    const standing = state.standing(index);
    presence.dataset.presence = PRESENCES[standing];
    say(presence, standing);
    say(what, told(zone));
    head.setAttribute("aria-pressed", String(state.picked === index));
    more.hidden = !state.mayEdit || state.picked !== index;
    if (more.hidden) more.replaceChildren();
    else this.#showForm(more, zone, index, key);
  }

  /** Keep the form while the user fills it in, unless the zone becomes one of another kind. */
  #showForm(more, zone, index, key) {
    const made = `${zone.properties.kind} ${linesOf(zone.geometry).length}`;
    if (this.#forms.get(key)?.made === made && more.children.length) return;
    const form = new ZoneForm(zone, (changed) => this.#orders.replace(index, changed));
    const refocus = more.contains(document.activeElement);
    this.#forms.set(key, { made, form });
    more.replaceChildren(form.element, make("button", { className: "button stop", type: "button", textContent: "Remove zone", onclick: () => this.#orders.remove(index) }));
    if (refocus) form.element.elements.namedItem("kind").focus();
  }

  #showEditing(state, drawing) {
    const { adding, drawing: whileDrawing, guide: text, zone, timeZone, save, discard, changes } = this.#parts;
    this.#isOutdated = state.isOutdated;
    byId("zones-edit").hidden = !state.mayEdit;
    adding.hidden = Boolean(drawing);
    whileDrawing.hidden = text.hidden = !drawing;
    if (drawing) {
      say(text, guide(drawing));
      whileDrawing.firstChild.disabled = drawing.missing > 0;
      whileDrawing.children[1].disabled = !drawing.corners.length;
    }
    zone.hidden = !state.features.some(({ properties }) => properties.times?.length);
    if (document.activeElement !== timeZone) timeZone.value = state.timeZone;
    changes.hidden = !state.isChanged;
    save.disabled = state.isOutdated || this.#isSaving;
    say(discard, state.isOutdated ? "Reload" : "Discard");
  }

  async #save() {
    this.#isSaving = true;
    this.#parts.save.disabled = true;
    await this.#orders.save();
    this.#isSaving = false;
    this.#parts.save.disabled = this.#isOutdated;
  }
}
