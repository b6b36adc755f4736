/** Rows of the table of all robots: what the cloud and the page know of each, sorted, searched, and cut to what is visible. */

import { duration } from "./format.js";
import { ENDED_BADLY } from "./messages.js";
import { PRESENCE, doing, sentence } from "./robot_list.js";

/** Rows above and below the visible ones, so that none is missing while one scrolls. */
const BESIDE = 8;

/** Columns of the table: key of the row, and title. */
export const COLUMNS = [["id", "Robot"], ["state", "State"], ["task", "Task"], ["error", "Error"], ["seen", "Last seen"], ["map", "Map"], ["machine", "Machine"]];

/** @typedef {{id: string, state: string, presence: string, task: string, error: string, age: number, seen: string, map: string, machine: string}} Row */

/** How a robot is by its container alone, which is all that the page knows of robots of other maps. @param {object | undefined} container */
function presenceOf(container) {
  if (!container?.connected) return "offline";
  return container.state === "ready" ? "online" : "starting";
}

/** Time since a robot was seen [s]; infinite if it never was. @param {string} presence @param {number} seenAt @param {number} now [s] */
function ageOf(presence, seenAt, now) {
  return presence === "online" ? 0 : now - seenAt;
}

/** @param {number} age @returns {string} */
function seen(age) {
  if (!Number.isFinite(age)) return "–";
  return age === 0 ? "now" : `${duration(age)} ago`;
}

/**
 * The row of a robot.
 * @param {{id: string, map: string, stopped: string | null}} robot @param {object | undefined} container
 * @param {import("./robot_link.js").RobotLink | null} link null for a robot of another map @param {number} now [s]
 * @returns {Row}
 */
export function rowOf({ id, map, stopped }, container, link, now) {
  const presence = link?.presence ?? presenceOf(container);
  const age = ageOf(presence, link?.seenAt ?? -Infinity, now);
  const goal = link?.state.goal;
  const error = goal && ENDED_BADLY.has(goal.code) ? goal.text || goal.word : "";
  const task = stopped ? sentence(stopped) : link && !error ? doing(link) : "";
  return { id, presence, state: PRESENCE[presence], task, error, age, seen: seen(age), map, machine: container?.machine ?? "" };
}

/** The rows in which each word of a text is found. @param {Row[]} rows @param {string} text */
export function matching(rows, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return rows.filter((row) => {
    const whole = COLUMNS.map(([key]) => row[key]).join("\n").toLowerCase();
    return words.every((word) => whole.includes(word));
  });
}

const collator = new Intl.Collator(undefined, { numeric: true });

/** The rows by a column; empty fields come last, and equal ones by the name of the robot. @param {Row[]} rows @param {string} key @param {boolean} falls */
export function sorted(rows, key, falls) {
  const sign = falls ? -1 : 1;
  const order = (a, b) => {
    if (key === "seen") return a.age === b.age ? 0 : sign * (a.age - b.age);
    if (!a[key] !== !b[key]) return a[key] ? -1 : 1;
    return sign * collator.compare(a[key], b[key]);
  };
  return [...rows].sort((a, b) => order(a, b) || collator.compare(a.id, b.id));
}

/** Numbers of the rows to draw, from the first to before the last. @param {number} top [pixels] @param {number} height [pixels] @param {number} row height of one [pixels] @param {number} count */
export function windowOf(top, height, row, count) {
  const from = Math.max(0, Math.min(Math.floor(top / row), count) - BESIDE);
  return { from, to: Math.min(count, Math.ceil((top + height) / row) + BESIDE) };
}
