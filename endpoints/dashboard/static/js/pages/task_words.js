/** Tasks in words and by columns, and what is written in the form of one. */

import { duration, number, plural } from "../format.js";

/** Most ended tasks of a column. */
export const MOST_ENDED = 30;

/** Columns of the board. */
export const COLUMNS = [
  { id: "queued", title: "Waiting", states: ["queued"] },
  { id: "assigned", title: "Assigned", states: ["assigned"] },
  { id: "active", title: "Running", states: ["active"] },
  { id: "done", title: "Done", states: ["done"] },
  { id: "failed", title: "Failed", states: ["failed", "cancelled"] },
];

const OPEN = new Set(["queued", "assigned", "active"]);

/** Whether a task has not ended. @param {{state: string}} task */
export function isOpen({ state }) {
  return OPEN.has(state);
}

/**
 * The tasks of a column: those that have not ended by age, the oldest first, as they are assigned; ended ones by their
 * end, the newest first.
 * @param {{states: string[]}} column @param {object[]} tasks @returns {{count: number, tasks: object[]}}
 */
export function columnOf({ states }, tasks) {
  const found = tasks.filter(({ state }) => states.includes(state));
  const order = (a, b) => (isOpen(a) ? b.priority - a.priority || a.created - b.created : b.ended - a.ended);
  const sorted = found.sort((a, b) => order(a, b) || a.id.localeCompare(b.id));
  return { count: found.length, tasks: found.some(isOpen) ? sorted : sorted.slice(0, MOST_ENDED) };
}

const placeText = ([x, y], floor) => `${number(x)}, ${number(y)}${floor ? ` on ${floor}` : ""}`;

/** What is to be done. @param {{kind: string, places: number[][], floors?: string[], rounds: number}} task */
export function titleOf({ kind, places, floors = [], rounds, trip }) {
  const [first, second] = places.map((place, at) => placeText(place, floors[at]));
  if (trip === "charge") return `Charge at ${first}`;
  if (trip === "park") return `Park at ${first}`;
  if (kind === "go_to") return `Go to ${first}`;
  if (kind === "pick_drop") return `Pick at ${first}, drop at ${second}`;
  const over = [...new Set(floors)].join(", ");
  return `Patrol ${plural(places.length, "place")}${over && ` on ${over}`}${rounds > 1 ? `, ${plural(rounds, "round")}` : ""}`;
}

/** How long it has been in its state. @param {object} task @param {number} now [s since the epoch] */
export function ageOf({ state, created, not_before: start, assigned, begun, holding, ended }, now) {
  const since = (time) => duration(Math.max(0, now - (time ?? created)));
  if (state === "queued") return start > now ? `starts in ${duration(start - now)}` : `waits for ${since(start ?? created)}`;
  if (holding) return `holds for ${since(holding)}`;
  if (state === "assigned") return `on its way for ${since(assigned)}`;
  if (state === "active") return `runs for ${since(begun)}`;
  return `${state === "cancelled" ? "cancelled " : ""}${since(ended)} ago`;
}

/** What else is known of it. @param {object} task @param {number} now [s since the epoch] @returns {string} */
export function notesOf(task, now) {
  const { priority, deadline, labels, failures, visited, places, rounds, weight, after = [], run } = task;
  const legs = places.length * rounds;
  const parts = [];
  if (task.needs_confirmation) parts.push("waits for your confirmation");
  if (task.named_robot) parts.push(`only for ${task.named_robot}`);
  if (weight) parts.push(`${number(weight)} kg`);
  if (run > 1) parts.push(`run ${run}`);
  if (task.state === "queued" && after.length) parts.push(`after ${plural(after.length, "other task")}`);
  if (priority) parts.push(`priority ${priority}`);
  if (legs > 1) parts.push(`${visited} of ${plural(legs, "place")} visited`);
  if (isOpen(task) && deadline) parts.push(deadline > now ? `due in ${duration(deadline - now)}` : "late");
  if (failures) parts.push(`failed ${plural(failures, "time")}`);
  return [...parts, ...Object.entries(labels).map(([name, value]) => `${name}=${value}`)].join(" · ");
}

/** The task to add, to do one again; a deadline that has passed is left out. @param {object} task @param {number} now [s since the epoch] */
export function againOf({ kind, places, floors, rounds, priority, labels, deadline, holds, named_robot, weight, preempts }, now) {
  return {
    kind, places, priority, labels, ...(floors?.length && { floors }), ...(holds?.length && { holds }), ...(named_robot && { named_robot }), ...(weight && { weight }), ...(preempts && { preempts }),
    ...(kind === "patrol" && { rounds }), ...(deadline > now && { deadline }),
  };
}

/** Most places of a task, by its kind. */
export const MOST_PLACES = { go_to: 1, pick_drop: 2, patrol: 64 };

/** The line of a place, as `placesOf` takes it. @param {import("../geometry.js").Point} place */
export function lineOf({ x, y }) {
  return `${number(x, 2)} ${number(y, 2)}`;
}

const FLOOR = /^([^:]+):/;
const linesOf = (text) => text.split("\n").map((line) => line.trim()).filter(Boolean);

/** Floors of the places of a text, null for those on the map; nothing if all are. @param {string} text @returns {(string | null)[]} */
export function floorsOf(text) {
  const floors = linesOf(text).map((line) => FLOOR.exec(line)?.[1].trim() || null);
  return floors.some(Boolean) ? floors : [];
}

/** Places of a text, one a line: x, y [m] and, if given, the heading in degrees, behind a floor. @param {string} text @returns {number[][]} */
export function placesOf(text) {
  const lines = linesOf(text);
  if (!lines.length) throw new Error("Give a place: x and y in metres");
  return lines.map((line) => {
    const words = line.replace(FLOOR, "").split(/[\s,;]+/).filter(Boolean);
    const [x, y, heading] = words.map(Number);
    if (![2, 3].includes(words.length) || ![x, y, heading ?? 0].every(Number.isFinite)) {
      throw new Error(`“${line}” is no place: give x and y in metres and, if you want, the heading in degrees`);
    }
    return words.length === 3 ? [x, y, (heading * Math.PI) / 180] : [x, y];
  });
}

/** Labels of a text such as “lift=yes, arm=2”. @param {string} text @returns {Record<string, string>} */
export function labelsOf(text) {
  const words = text.split(",").map((word) => word.trim()).filter(Boolean);
  return Object.fromEntries(words.map((word) => {
    const at = word.indexOf("=");
    if (at < 1) throw new Error(`“${word}” is no label: give NAME=VALUE`);
    return [word.slice(0, at).trim(), word.slice(at + 1).trim()];
  }));
}
