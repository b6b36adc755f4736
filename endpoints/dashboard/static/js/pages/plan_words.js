/** Stored paths and how often they were used again, in words. */

import { number, plural } from "../format.js";

/** @param {number | null} fraction @returns {string} */
export function percent(fraction) {
  return Number.isFinite(fraction) ? `${number(100 * fraction, 0)} %` : "–";
}

/** @param {number | null} seconds @returns {string} */
export function milliseconds(seconds) {
  return Number.isFinite(seconds) ? `${number(1000 * seconds, 1)} ms` : "–";
}

/** The columns of a planner's row: title, and text. @type {[string, (planner: object) => string][]} */
export const OF_PLANNER = [
  ["Planner", ({ planner }) => planner],
  ["Requests", ({ queries }) => String(queries)],
  ["With a path", ({ success }) => percent(success)],
  ["Used again", ({ reuse_rate: rate }) => percent(rate)],
  ["Computed", ({ computed }) => String(computed)],
  ["As stored", ({ reused }) => String(reused)],
  ["Stitched", ({ stitched }) => String(stitched)],
  ["Mean time to compute", ({ seconds }) => milliseconds(seconds)],
];

const ORIGINS = { computed: "computed", reused: "as stored", stitched: "stitched", given: "given by a program" };
const placeText = ([x, y]) => `${number(x)}, ${number(y)}`;

/** The columns of a stored path: title, and text. @type {[string, (plan: object, when: string) => string][]} */
export const OF_PLAN = [
  ["When", (_plan, when) => when],
  ["By", ({ user, robot }) => (robot ? `${robot} of ${user}` : user)],
  ["From", ({ start }) => placeText(start)],
  ["To", ({ goal }) => placeText(goal)],
  ["Length", ({ length }) => `${number(length)} m`],
  ["Planner", ({ planner }) => planner],
  ["Origin", ({ origin }) => ORIGINS[origin] ?? origin],
  ["Time", ({ seconds }) => milliseconds(seconds)],
];

/** The share of all paths that were not computed. @param {object[]} planners @returns {number | null} */
function reuseOf(planners) {
  const sum = (name) => planners.reduce((total, planner) => total + planner[name], 0);
  const again = sum("reused") + sum("stitched");
  return again + sum("computed") ? again / (again + sum("computed")) : null;
}

/** How often paths were used again, in words. @param {object[]} planners */
export function reuseText(planners) {
  const reuse = reuseOf(planners);
  return reuse === null ? "No path was asked for yet." : `Of the paths that were asked for, ${percent(reuse)} were not computed.`;
}

/** What is stored, and what that saves. @param {object} statistics @param {(bytes: number) => string} size */
export function storedText({ plans, waypoints, kept, bytes }, size) {
  const shared = waypoints ? `, ${percent(1 - kept / waypoints)} of their waypoints shared` : "";
  return `${plural(plans, "path")} stored in ${size(bytes)}${shared}`;
}
