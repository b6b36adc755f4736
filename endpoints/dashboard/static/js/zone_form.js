/** Form with the properties of a zone. Each change is told at once; it is saved with all others. */

import { make } from "./dom.js";
import { cornersOf, linesOf, withCorners } from "./zone_shapes.js";
import { DAYS, KINDS, USUAL, kindsOf } from "./zones_state.js";

const OFFSET = /(Z|[+-]\d\d:\d\d)$/;
const DEGREE = Math.PI / 180;
const LONGEST = 64;
const TIMELESS = ["lane", "station", "door", "lift", "passage", "dock"];
const HEADED = ["passage", "dock"];
const PLACES = ["door", "lift", ...HEADED];

/** The properties of a zone from what its form says; of a zone that has just become one of another kind, usual ones. @param {Record<string, any>} said */
export function ruleOf({ name, kind, isLine, times, ...values }) {
  const rule = { name, kind };
  if (kind === "speed_limit") rule[values.unit ?? "max_speed"] = values.speed ?? USUAL.speed;
  if (kind === "capacity") rule.robots = values.robots ?? USUAL.robots;
  if (kind === "one_way" && isLine) rule.width = values.width ?? USUAL.width;
  else if (kind === "one_way") rule.direction = turnOf(values.heading ?? 0);
  if (kind === "one_way" && values.strict) rule.strict = true;
  if (kind === "lane" && values.one_way) rule.one_way = true;
  if (kind === "station" && Number.isFinite(values.yaw)) rule.yaw = values.yaw;
  if (kind === "station" && values.uses?.length) rule.uses = values.uses;
  if (["door", "lift"].includes(kind) && values.lift) rule.lift = values.lift;
  if (kind === "passage") rule.way = values.way || USUAL.way;
  if (HEADED.includes(kind)) rule.yaw = Number.isFinite(values.heading) ? turnOf(values.heading) : (values.yaw ?? 0);
  if (kind === "dock" && values.dock_type) rule.dock_type = values.dock_type;
  if (kind === "dock" && values.charges === false) rule.charges = false;
  if (!TIMELESS.includes(kind) && times.length) rule.times = times;
  if (rule.times && values.time_zone) rule.time_zone = values.time_zone;
  return rule;
}

/** @param {number} heading [°] @returns {number} [rad] */
function turnOf(heading) {
  return Math.round(heading * DEGREE * 1e6) / 1e6;
}

/** Hours from what their fields say. The end of a day is 24:00 in the cloud, and 00:00 in a browser. */
export function hoursOf({ days, from, to, since, until }) {
  const hours = {};
  if (days.length && days.length < DAYS.length) hours.days = days;
  if (from && from !== "00:00") hours.from = from;
  if (to && to !== "00:00") hours.to = to;
  if (since) hours.since = since;
  if (until) hours.until = until;
  return hours;
}

export class ZoneForm {
  /** @type {HTMLFormElement} */ element;
  #zone;
  #fields = {};
  #hours = [];
  #changed;

  /** @param {import("./zones_state.js").Zone} zone @param {(zone: import("./zones_state.js").Zone) => void} changed */
  constructor(zone, changed) {
    this.#zone = zone;
    this.#changed = changed;
    const { properties, geometry } = zone;
    this.element = make("form", { className: "name-form zone-form", "aria-label": `Zone ${properties.name}` },
      this.#field("name", "Name", { value: properties.name, maxLength: LONGEST, required: true, autocomplete: "off" }),
      this.#kindField(properties.kind, geometry), ...this.#valueFields(zone), ...this.#cornersField(geometry), ...this.#timesFields(properties));
    this.element.addEventListener("submit", (event) => event.preventDefault());
    this.element.addEventListener("change", () => this.#tell());
  }

  #field(name, title, properties) {
    const input = make("input", { name, ...properties });
    this.#fields[name] = input;
    return make("label", {}, title, input);
  }

  #number(name, title, value, properties = {}) {
    return this.#field(name, title, { type: "number", step: "any", inputMode: "decimal", required: true, value: String(value ?? ""), ...properties });
  }

  #switch(name, title, checked) {
    const box = make("input", { type: "checkbox", role: "switch", name, checked: Boolean(checked) });
    this.#fields[name] = box;
    return make("label", { className: "switch" }, box, title);
  }

  #kindField(kind, geometry) {
    const select = make("select", { name: "kind" }, ...kindsOf(geometry).map((each) => make("option", { value: each, textContent: KINDS[each] })));
    select.value = kind;
    this.#fields.kind = select;
    return make("label", {}, "Kind", select);
  }

  /** What a place of a building says: of which lift or way it is, and the heading of a robot there. */
  #placeFields({ kind, lift, way, yaw, dock_type: type, charges }) {
    const text = (name, title, value, required) => this.#field(name, title, { value: value ?? "", maxLength: LONGEST, required, autocomplete: "off", spellcheck: false });
    const heading = () => this.#number("heading", "Heading [°]", Math.round(((yaw ?? 0) / DEGREE) * 100) / 100);
    if (kind === "door") return [text("lift", "Lift behind it, if it is a landing door", lift, false)];
    if (kind === "lift") return [text("lift", "Id of the lift, if it is not the name", lift, false)];
    if (kind === "passage") return [text("way", "Way, whose other end has the same", way, true), heading()];
    return [heading(), text("dock_type", "How robots find it, if not as usual", type, false), this.#switch("charges", "Robots charge here", charges !== false)];
  }

  #valueFields({ properties, geometry }) {
    const { kind, max_speed: speed, percent, robots, width, direction, strict, one_way: oneWay } = properties;
    if (kind === "speed_limit") {
      const units = [["max_speed", "m/s"], ["percent", "% of the robot's"]].map(([value, textContent]) => make("option", { value, textContent }));
      const unit = make("select", { name: "unit" }, ...units);
      unit.value = Number.isFinite(percent) ? "percent" : "max_speed";
      this.#fields.unit = unit;
      return [make("div", { className: "zone-pair" }, this.#number("speed", "Highest speed", percent ?? speed, { min: 0.01, max: 100 }), make("label", {}, "Unit", unit))];
    }
    if (kind === "capacity") return [this.#number("robots", "Most robots at a time", robots, { min: 1, max: 1000, step: 1, inputMode: "numeric" })];
    if (kind === "lane") return [this.#switch("one_way", "One way", oneWay)];
    if (PLACES.includes(kind)) return this.#placeFields(properties);
    if (kind !== "one_way") return [];
    const way = linesOf(geometry).length ? this.#number("width", "Width [m]", width, { min: 0.01, max: 100 }) : this.#number("heading", "Direction [°]", Math.round(((direction ?? 0) / DEGREE) * 100) / 100);
    return [way, this.#switch("strict", "Crossing is forbidden too", strict)];
  }

  #cornersField(geometry) {
    const corners = cornersOf(geometry);
    return corners === null ? [] : [this.#field("corners", "Corners: x y, x y … [m]", { value: corners, required: true, autocomplete: "off", spellcheck: false })];
  }

  /** The hours of a zone, and a button that adds some; a lane is always in force, and a station is no rule. */
  #timesFields({ kind, times = [] }) {
    if (TIMELESS.includes(kind)) return [];
    const rows = make("div", { className: "zone-times" }, ...times.map((hours) => this.#hoursFields(hours)));
    const more = make("button", { className: "link", type: "button", textContent: "Add hours", onclick: () => { rows.append(this.#hoursFields({ from: "08:00", to: "18:00" })); this.#tell(); } });
    return [rows, more];
  }

  #hoursFields({ days = [], from = "00:00", to = "24:00", since = "", until = "" }) {
    const boxes = DAYS.map((day) => make("input", { type: "checkbox", value: day, checked: !days.length || days.includes(day) }));
    const time = (value) => make("input", { type: "time", value: value === "24:00" ? "00:00" : value, required: true });
    const moment = (value) => make("input", { type: OFFSET.test(value) ? "text" : "datetime-local", value });
    const fields = { boxes, from: time(from), to: time(to), since: moment(since), until: moment(until) };
    const remove = make("button", { className: "link", type: "button", textContent: "Remove these hours", onclick: () => this.#drop(fields, row) });
    const row = make("fieldset", { className: "zone-hours" }, make("legend", { textContent: "Hours" }),
      make("div", { className: "zone-days" }, ...boxes.map((box, i) => make("label", {}, box, DAYS[i]))),
      make("div", { className: "zone-pair" }, make("label", {}, "From", fields.from), make("label", {}, "To", fields.to)),
      make("label", {}, "Since", fields.since), make("label", {}, "Until", fields.until), remove);
    this.#hours.push(fields);
    return row;
  }

  #drop(fields, row) {
    this.#hours = this.#hours.filter((one) => one !== fields);
    row.remove();
    this.#tell();
  }

  /** Say what the zone is now, if the fields are valid. */
  #tell() {
    const { corners } = this.#fields;
    const geometry = corners ? withCorners(this.#zone.geometry, corners.value) : this.#zone.geometry;
    corners?.setCustomValidity(geometry ? "" : "Write each corner as x y in metres, with a comma between corners");
    for (const { boxes } of this.#hours) boxes[0].setCustomValidity(boxes.some(({ checked }) => checked) ? "" : "Choose one day or more");
    if (!this.element.reportValidity()) return;
    this.#zone = { ...this.#zone, geometry, properties: ruleOf(this.#said()) };
    this.#changed(this.#zone);
  }

  #said() {
    const values = Object.entries(this.#fields).map(([name, field]) => [name, { checkbox: field.checked, number: field.valueAsNumber }[field.type] ?? field.value]);
    const times = this.#hours.map(({ boxes, from, to, since, until }) =>
      hoursOf({ days: boxes.filter(({ checked }) => checked).map(({ value }) => value), from: from.value, to: to.value, since: since.value, until: until.value }));
    const { time_zone, yaw, uses, lift, way, dock_type, charges } = this.#zone.properties;
    return { lift, way, dock_type, charges, ...Object.fromEntries(values), time_zone, yaw, uses, isLine: linesOf(this.#zone.geometry).length > 0, times };
  }
}
