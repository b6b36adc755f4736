/** The record of a building as fields of a form, and the other way round. */

import { plural } from "../format.js";

const DEGREE = Math.PI / 180;
const LABEL = /^[^=,]+=[^=,]*$/;

/** Kinds of ways. */
export const WAYS = ["ramp", "stairs", "bridge"];

/**
 * A field: `kind` is text, number, map, floor, floors (with none), way or labels; `usual` is the value of a part that
 * does not have it.
 * @typedef {{key: string, title: string, kind: string, usual?: unknown, required?: boolean, min?: number, max?: number, step?: string, placeholder?: string}} Field
 */

/** @type {Record<string, {title: string, one: string, fields: Field[]}>} */
export const PARTS = {
  floors: {
    title: "Floors", one: "floor",
    fields: [
      { key: "name", title: "Name", kind: "text", required: true, placeholder: "L1" },
      { key: "map", title: "Map", kind: "map", required: true },
      { key: "elevation", title: "Elevation [m]", kind: "number", usual: 0, min: -2000, max: 2000 },
      { key: "x", title: "Anchor x [m]", kind: "number", usual: 0 },
      { key: "y", title: "Anchor y [m]", kind: "number", usual: 0 },
      { key: "turn", title: "Anchor turned [°]", kind: "number", usual: 0 },
    ],
  },
  lifts: {
    title: "Lifts", one: "lift",
    fields: [
      { key: "lift", title: "Id, as zones name it", kind: "text", required: true, placeholder: "north" },
      { key: "robots", title: "Robots in the car", kind: "number", usual: 1, min: 1, max: 100, step: "1" },
      { key: "speed", title: "Speed [m/s]", kind: "number", usual: 1, min: 0.01, max: 20 },
      { key: "wait", title: "Mean wait [s]", kind: "number", usual: 20, min: 0, max: 3600 },
      { key: "doors", title: "Doors open in [s]", kind: "number", usual: 3, min: 0, max: 3600 },
      { key: "device", title: "Device", kind: "text", usual: "", placeholder: "http://…" },
    ],
  },
  doors: {
    title: "Doors", one: "door",
    fields: [
      { key: "floor", title: "Floor", kind: "floor", required: true },
      { key: "door", title: "Name of its zone", kind: "text", required: true, placeholder: "gate" },
      { key: "opens", title: "Opens in [s]", kind: "number", usual: 3, min: 0, max: 3600 },
      { key: "device", title: "Device", kind: "text", usual: "", placeholder: "http://…" },
    ],
  },
  ways: {
    title: "Stairs, ramps and bridges", one: "way",
    fields: [
      { key: "way", title: "Id, as zones name it", kind: "text", required: true, placeholder: "ramp" },
      { key: "kind", title: "Kind", kind: "way", usual: "ramp" },
      { key: "length", title: "Length [m]", kind: "number", min: 0.01, max: 10_000, placeholder: "as far as its ends" },
      { key: "labels", title: "Labels that a robot needs", kind: "labels", placeholder: "legs=4" },
      { key: "one_way", title: "Entered from", kind: "floors", usual: "" },
    ],
  },
};

/** A part of a record as values of its fields. @param {string} part @param {Record<string, any>} given @returns {Record<string, string>} */
export function valuesOf(part, given) {
  const [x = 0, y = 0, yaw = 0] = given.anchor ?? [];
  const flat = part === "floors" ? { ...given, x, y, turn: rounded(yaw / DEGREE) } : given;
  return Object.fromEntries(PARTS[part].fields.map(({ key, kind, usual = "" }) => [key, kind === "labels" ? labelText(flat[key]) : String(flat[key] ?? usual)]));
}

/** A part of a record from the values of its fields, without those that are as usual. @param {string} part @param {Record<string, string>} values @param {Record<string, any>} before what it was */
export function partOf(part, values, before = {}) {
  const made = {};
  for (const { key, kind, usual } of PARTS[part].fields) {
    const text = values[key].trim();
    const value = kind === "number" ? (text === "" ? usual : Number(text)) : kind === "labels" ? labelsOf(text) : text;
    if (value !== usual && value !== undefined && !(kind === "labels" && !text)) made[key] = value;
  }
  return part === "floors" ? withAnchor(made, before) : made;
}

/** Anchors that were not changed keep all of their digits. */
function withAnchor({ x = 0, y = 0, turn = 0, ...floor }, { anchor = [0, 0, 0] }) {
  const [, , yaw] = anchor;
  const made = [x, y, rounded(yaw / DEGREE) === turn ? yaw : turn * DEGREE];
  return made.some(Boolean) ? { ...floor, anchor: made } : floor;
}

/** @param {string} text as "name=value, name=value" @returns {Record<string, string>} */
export function labelsOf(text) {
  const pairs = text.split(",").map((pair) => pair.trim()).filter(Boolean);
  for (const pair of pairs) if (!LABEL.test(pair)) throw new Error(`Write labels as legs=4, arm=1; not ${pair}`);
  return Object.fromEntries(pairs.map((pair) => pair.split("=").map((side) => side.trim())));
}

function labelText(labels) {
  return Object.entries(labels ?? {}).map(([name, value]) => `${name}=${value}`).join(", ");
}

function rounded(value) {
  return Math.round(value * 1e4) / 1e4;
}

/** What is known of a building beside its record. @param {{version: number, author: string, owner: string, readers: string[]}} building @param {string} me */
export function aboutText({ version, author, owner, readers }, me) {
  const shared = readers.includes("*") ? "everybody may read it" : readers.length ? `${readers.join(", ")} may read it` : "nobody else may read it";
  return `Version ${version} by ${author}${owner === me ? "" : `, of ${owner}`}; ${shared}.`;
}

/** What a check found on the maps. @param {{floors: number, lifts: number, ways: number, doors: number, docks: number}} found */
export function foundText({ floors, lifts, ways, doors, docks }) {
  const counts = [[floors, "floor"], [lifts, "lift"], [ways, "way"], [doors, "door"], [docks, "dock"]].map(([count, noun]) => plural(count, noun));
  return `It may be saved. On its maps: ${counts.join(", ")}`;
}

/** Whether the user may change a building. @param {{owner: string}} building @param {{id: string, role: string}} me */
export function mayEdit({ owner }, { id, role }) {
  return owner === id || role === "admin";
}
