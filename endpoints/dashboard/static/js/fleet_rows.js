/** Rows of the table of all robots: what the cloud says of each, sorted, searched, and cut to what is visible. */

import { duration, number } from "./format.js";

/** Rows above and below the visible ones, so that none is missing while one scrolls. */
const BESIDE = 8;

/** Columns of the table: key of the row, and title. Their meaning is that of the members of `GET /v1/robots`. */
export const COLUMNS = [
  ["id", "Robot"], ["state", "State"], ["battery", "Battery"], ["task", "Task"], ["error", "Error"], ["seen", "Last seen"],
  ["map", "Map"], ["machine", "Machine"], ["software", "Software"],
];

/**
 * @typedef {{id: string, state: string, charge: number, battery: string, task: string, error: string, age: number,
 *            seen: string, map: string, machine: string, software: string}} Row
 */

/** @param {number} age [s] @returns {string} */
function seen(age) {
  if (!Number.isFinite(age)) return "–";
  return age === 0 ? "now" : `${duration(age)} ago`;
}

/** The row of a robot. @param {object} robot as `GET /v1/robots` has it @returns {Row} */
export function rowOf({ id, map, state, battery, seen_ago: ago, task, error, machine, software }) {
  const age = ago ?? Infinity;
  return {
    id, map, state: state ?? "unknown", task: task ?? "", error: error ?? "", age, seen: seen(age),
    charge: battery ?? NaN, battery: battery === null || battery === undefined ? "" : `${number(100 * battery, 0)} %`,
    machine: machine ?? "", software: software ?? "unknown",
  };
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
/** Numbers behind the texts of columns, by which these are sorted. */
const NUMBERS = { seen: "age", battery: "charge" };

/** The rows by a column; empty fields come last, and equal ones by the name of the robot. @param {Row[]} rows @param {string} key @param {boolean} falls */
export function sorted(rows, key, falls) {
  const sign = falls ? -1 : 1;
  const order = (a, b) => {
    if (!a[key] !== !b[key]) return a[key] ? -1 : 1;
    const number = NUMBERS[key];
    if (!number) return sign * collator.compare(a[key], b[key]);
    return Object.is(a[number], b[number]) ? 0 : sign * (a[number] - b[number]);
  };
  return [...rows].sort((a, b) => order(a, b) || collator.compare(a.id, b.id));
}

/** Numbers of the rows to draw, from the first to before the last. @param {number} top [pixels] @param {number} height [pixels] @param {number} row height of one [pixels] @param {number} count */
export function windowOf(top, height, row, count) {
  const from = Math.max(0, Math.min(Math.floor(top / row), count) - BESIDE);
  return { from, to: Math.min(count, Math.ceil((top + height) / row) + BESIDE) };
}
