/**
 * Zones of the shown map: the last answer of the cloud, and the user's draft of other ones.
 *
 * @typedef {{days?: string[], from?: string, to?: string, since?: string, until?: string}} Hours
 * @typedef {{name: string, kind: string, times?: Hours[], max_speed?: number, percent?: number, direction?: number,
 *            width?: number, strict?: boolean, one_way?: boolean, robots?: number, time_zone?: string, yaw?: number, uses?: string[],
 *            lift?: string, way?: string, dock_type?: string, charges?: boolean}} Rule
 * @typedef {{type: "Feature", geometry: {type: string, coordinates: any[]}, properties: Rule}} Zone
 * @typedef {{type: "FeatureCollection", features: Zone[], time_zone?: string, in_force?: string[]}} Zones
 * @typedef {{zone: string, text: string, place: [number, number] | null}} Fault
 */

import { linesOf, oriented, pointOf, polygonsOf, within } from "./zone_shapes.js";

export const KINDS = { keep_out: "Keep out", speed_limit: "Speed limit", one_way: "One way", no_stop: "No stopping", capacity: "Capacity", lane: "Lane", station: "Station",
  door: "Door", lift: "Lift", passage: "Way", dock: "Dock" };
const OF_POINTS = ["station", "passage", "dock"];
const OF_LINES = ["lane", "one_way", "door"];
const NOT_OF_AREAS = ["lane", "door", ...OF_POINTS];

export const DAYS = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];

/** Values of new zones: speed [m/s], number of robots, width along a line [m], name of a way. */
export const USUAL = { speed: 0.5, robots: 1, width: 1, way: "ramp" };
const NEW = { speed_limit: { max_speed: USUAL.speed }, capacity: { robots: USUAL.robots }, passage: { way: USUAL.way, yaw: 0 }, dock: { yaw: 0 } };

/** Kinds that a zone of a geometry may have. @param {Zone["geometry"]} geometry @returns {string[]} */
export function kindsOf(geometry) {
  if (pointOf(geometry)) return OF_POINTS;
  return linesOf(geometry).length ? OF_LINES : Object.keys(KINDS).filter((kind) => !NOT_OF_AREAS.includes(kind));
}

/** The value of a rule; empty if it has none. @param {Rule} rule */
export function valueOf(rule) {
  return [numberOf(rule), ...wordsOf(rule)].filter(Boolean).join(", ");
}

/** The number of a rule with its unit. @param {Rule} rule */
function numberOf({ kind, max_speed: speed, percent, robots, direction, width }) {
  if (kind === "speed_limit") return Number.isFinite(percent) ? `${percent} %` : `${speed} m/s`;
  if (kind === "capacity") return `${robots} robot${robots === 1 ? "" : "s"}`;
  if (kind === "one_way" && Number.isFinite(width)) return `${width} m wide`;
  return kind === "one_way" && Number.isFinite(direction) ? `${Math.round((direction * 180) / Math.PI)}°` : "";
}

/** What a rule says beside its number. @param {Rule} rule */
function wordsOf({ kind, strict, one_way: oneWay, uses, lift, way, dock_type: type, charges }) {
  const places = [lift && `of lift ${lift}`, way, type, kind === "dock" && charges === false && "no charger"];
  return [strict && "strict", kind === "lane" && oneWay && "one way", ...(uses ?? []), ...places].filter(Boolean);
}

/** When a zone is in force, in words; empty if always. @param {Hours[] | undefined} times */
export function timesOf(times) {
  return (times ?? []).map(({ days = [], from, to, since, until }) => {
    const parts = [];
    if (days.length) parts.push(daysOf(days));
    if (from || to) parts.push(`${from ?? "00:00"} to ${to ?? "24:00"}`);
    if (since) parts.push(`since ${since.replace("T", " ")}`);
    if (until) parts.push(`until ${until.replace("T", " ")}`);
    return parts.join(" ") || "always";
  }).join("; ");
}

/** A zone in words. @param {Zone} zone */
export function told({ properties }) {
  const kind = KINDS[properties.kind] ?? properties.kind;
  const what = [[kind, numberOf(properties)].filter(Boolean).join(" "), ...wordsOf(properties)].join(", ");
  return [what, timesOf(properties.times), properties.time_zone].filter(Boolean).join("; ");
}

/** Days in words: three or more in a row are one span. @param {string[]} days */
function daysOf(days) {
  const first = DAYS.indexOf(days[0]);
  const isSpan = days.length > 2 && days.every((day, i) => day === DAYS[first + i]);
  return isSpan ? `${days[0]} to ${days.at(-1)}` : days.join(", ");
}

export class ZonesState {
  /** What the cloud answered; null if the map has no zones to ask for. @type {Zones | null} */ answer = null;
  /** Tag of the answer. @type {string | null} */ tag = null;
  /** What the user has changed; null if nothing. @type {{features: Zone[], time_zone: string} | null} */ draft = null;
  /** Tag of the answer that the draft was made of. @type {string | null} */ base = null;
  /** Number of the zone that the user has picked. @type {number | null} */ picked = null;
  /** Whether the user may change zones. */
  mayEdit = false;
  /** Number of times that all zones have become others, as by a reload. */
  generation = 0;
  /** Why the cloud does not take the draft. */
  problem = "";
  /** What is wrong with which zone of the draft, and where. @type {Fault[]} */ faults = [];
  /** What the cloud mends in the draft, and what may be wrong in it. @type {string[]} */ warnings = [];
  /** Zones of the answer that the draft was made of. @type {Set<Zone>} */ #saved = new Set();
  /** Names of zones that are in force; null if the cloud does not say. @type {Set<string> | null} */ #inForce = null;

  /** Take an answer of the cloud; the tag of the same zones may be another one. @param {Zones | null} given @param {string | null} tag */
  take(given, tag) {
    const answer = given && withoutCommonTimeZone(given);
    const isNew = !same(zonesOf(answer), zonesOf(this.answer));
    if (!isNew && this.base === this.tag) this.base = tag;
    this.answer = isNew || !answer ? answer : { ...answer, features: this.answer.features }; // the draft may have some of them
    this.tag = tag;
    this.#inForce = answer?.in_force ? new Set(answer.in_force) : null;
    if (!this.draft && isNew) this.#renew();
  }

  /** Forget everything, because another map is shown. */
  clear() {
    this.draft = this.base = this.answer = this.tag = null;
    this.mayEdit = false;
    this.#renew();
  }

  /** The zones to show: those of the draft, if there is one. */
  get features() {
    return this.draft?.features ?? this.answer?.features ?? [];
  }

  get timeZone() {
    return this.draft?.time_zone ?? this.answer?.time_zone ?? "UTC";
  }

  get isChanged() {
    return this.draft !== null;
  }

  /** Whether somebody else has changed the zones since the draft was begun. */
  get isOutdated() {
    return this.draft !== null && this.base !== this.tag;
  }

  /** How things are with a zone: in force or not, or not saved. @param {number} index */
  standing(index) {
    const zone = this.features[index];
    if (this.draft && !this.#saved.has(zone)) return "not saved";
    return !this.#inForce || this.#inForce.has(zone.properties.name) ? "in force" : "not in force";
  }

  /** Number of the zone at a point that was drawn last; null if there is none. @param {{x: number, y: number}} point */
  at(point, reach) {
    const found = this.features.findLastIndex((zone) => within(zone, point, reach));
    return found < 0 ? null : found;
  }

  /** @param {Zone} zone */
  add(zone) {
    this.#change((features) => [...features, zone]);
    this.picked = this.features.length - 1;
  }

  /** @param {number} index @param {Zone} zone */
  replace(index, zone) {
    if (!same(this.features[index], zone)) this.#change((features) => features.map((one, i) => (i === index ? zone : one)));
  }

  /** @param {number} index */
  remove(index) {
    this.#change((features) => features.filter((_, i) => i !== index));
    this.picked = null;
    this.generation += 1;
  }

  /** @param {string} name of a time zone */
  setTimeZone(name) {
    if (name === this.timeZone) return;
    this.#change((features) => features);
    this.draft.time_zone = name;
  }

  /** Forget the draft: what the cloud has is shown again. */
  discard() {
    this.draft = this.base = null;
    this.#renew();
  }

  /** Take what the cloud says on the draft. @param {{problem?: string, faults?: Fault[], warnings?: string[]}} check */
  judge({ problem = "", faults = [], warnings = [] }) {
    this.problem = problem;
    this.faults = faults;
    this.warnings = warnings;
  }

  /** The body of a request that saves the draft. @returns {Zones} */
  get body() {
    const features = this.draft.features.map((zone) => ({ ...zone, geometry: oriented(zone.geometry) }));
    return { type: "FeatureCollection", ...this.draft, features };
  }

  /** A zone with usual values, and a name that no other zone has. @param {string} kind @param {Zone["geometry"]} geometry */
  proposal(kind, geometry) {
    const names = new Set(this.features.map(({ properties }) => properties.name));
    let number = 1;
    while (names.has(`${KINDS[kind]} ${number}`)) number += 1;
    return { type: "Feature", geometry, properties: { name: `${KINDS[kind]} ${number}`, kind, ...NEW[kind], ...along(kind, geometry) } };
  }

  #change(changed) {
    if (!this.draft) {
      this.base = this.tag;
      this.#saved = new Set(this.features);
    }
    this.draft = { features: changed(this.features), time_zone: this.timeZone };
    this.judge({});
  }

  #renew() {
    this.picked = null;
    this.judge({});
    this.generation += 1;
  }
}

/** The way of a new one-way zone: its width along a line, or the direction of the first edge that was drawn. */
function along(kind, geometry) {
  if (kind !== "one_way") return {};
  if (linesOf(geometry).length) return { width: USUAL.width };
  const [[[x0, y0], [x1, y1]]] = polygonsOf(geometry)[0];
  return { direction: Math.round(Math.atan2(y1 - y0, x1 - x0) * 1000) / 1000 };
}

/** Zones name their time zone, also if it is that of all: so do they here only if it is another one. */
function withoutCommonTimeZone(answer) {
  const features = answer.features.map((zone) => {
    const { time_zone: own, ...rest } = zone.properties;
    return own === undefined || own !== answer.time_zone ? zone : { ...zone, properties: rest };
  });
  return { ...answer, features };
}

function zonesOf(answer) {
  return answer && [answer.features, answer.time_zone];
}

function same(one, other) {
  return JSON.stringify(one) === JSON.stringify(other);
}
