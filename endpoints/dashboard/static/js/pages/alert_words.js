/** What wakes a person: faults of the cloud, of robots and of their goals and tasks, in words. */

import { isBroken } from "../building_state.js";
import { ENDED_BADLY } from "../messages.js";
import { mayDrive } from "../shared_robots.js";

/** Time for which a failed task is an alert [s]. */
export const KEPT = 86_400;

/** Time for which an acknowledgement hides what began before this page looked [s]. */
export const HELD = 86_400;

const LONGEST = 200; // of the name of an alert [characters]

/**
 * A fault. `object` and `alert` are its name in the cloud; `since` is when it began [s since the epoch], null if the
 * cloud does not know, and `once` whether it cannot begin again; `robot` is where to look.
 * @typedef {{key: string, object: string, alert: string, text: string, advice: string, since: number | null, once?: boolean, robot?: string}} Alert
 */

/** @returns {Alert} */
function alertOf(object, alert, text, advice, more = {}) {
  return { key: keyOf({ object, alert }), object, alert, text, advice, since: null, ...more };
}

/** Key of an alert, which is that of its acknowledgement. @param {{object: string, alert: string}} named */
export function keyOf({ object, alert }) {
  return `${object} ${alert}`;
}

const shortened = (text) => [...text].slice(0, LONGEST).join("");

const STORES = { store: "The store", map_store: "The map store", audit: "The audit log" };

/** Faults of the cloud itself. @param {object | null} health @returns {Alert[]} */
export function faultsOf(health) {
  if (!health) return [];
  const fault = (...alert) => alertOf("cloud", ...alert);
  const found = Object.entries(STORES).filter(([name]) => health[name].state === "away").map(([name, text]) => (
    fault(name, `${text} is away`, health[name].reason ?? "Robots drive on; look at its server")
  ));
  if (health.master === "away") found.push(fault("master", "No master leads the cloud", "Robots with a container drive on; new ones wait"));
  if (health.disk && health.disk.state !== "ok") found.push(fault("disk", `The disk is ${health.disk.state}`, health.disk.reason ?? ""));
  if (health.plans_waiting) found.push(fault("plans", `${health.plans_waiting} paths wait for the store`, "They are stored when it answers"));
  return found;
}

/** Endpoints that have gone silent. @param {object[] | null} endpoints @returns {Alert[]} */
export function silentEndpoints(endpoints) {
  return (endpoints ?? []).filter(({ state }) => state === "silent").map(({ id, machine }) => (
    alertOf(`endpoints/${id}`, "silent", `Endpoint ${id} is silent`, `It has not reported its load for a while: look at machine ${machine}`)
  ));
}

/** Robots whose connection was lost. @param {object[]} robots @param {Map<string, number>} lost since when, by robot @returns {Alert[]} */
export function lostRobots(robots, lost) {
  return robots.filter(({ id, connected }) => connected === false && lost.has(id)).map(({ id }) => (
    alertOf(`robots/${id}`, "lost", `${id} is lost`, "Its connection broke off, and it has not come back", { since: lost.get(id), robot: id })
  ));
}

/** Robots whose last goal ended badly. @param {import("../robot_link.js").RobotLink[]} links of the shown map @returns {Alert[]} */
export function failedGoals(links) {
  return links.filter(({ state }) => state.goal && ENDED_BADLY.has(state.goal.code)).map(({ robot: { id }, state: { goal } }) => (
    alertOf(`robots/${id}`, shortened(`goal ${goal.id}`), `${id} ${goal.word}`, goal.text || "Its goal was not reached", { once: true, robot: id })
  ));
}

/** Lifts and doors of the shown building that have a fault. @param {{address: string, state: import("../building_state.js").State} | null} building @returns {Alert[]} */
export function brokenParts(building) {
  const { lifts = [], doors = [] } = building?.state ?? {};
  const parts = [...lifts.map((lift) => ({ ...lift, name: `lift ${lift.lift}` })), ...doors.map((door) => ({ ...door, name: `door ${door.door} on ${door.floor}` }))];
  return parts.filter(isBroken).map(({ name, fault }) => (
    alertOf(`buildings/${building.address}`, shortened(name), `${name[0].toUpperCase()}${name.slice(1)} does not serve robots`, fault)
  ));
}

/** Tasks that have failed. @param {object[]} tasks @param {number} now [s since the epoch] @returns {Alert[]} */
export function failedTasks(tasks, now) {
  return tasks.filter(({ state, ended }) => state === "failed" && now - ended < KEPT).map(({ id, map, robot, reason, ended }) => (
    alertOf(`maps/${map}/tasks/${id}`, "failed", `A task on ${map} has failed`, reason, { since: ended, ...(robot && { robot }) })
  ));
}

/**
 * Whether somebody has seen to an alert: it was acknowledged after it began. Of one that was there when the page first
 * looked, nobody knows when it began; it counts as acknowledged for a day.
 * @param {Alert & {earlier: boolean}} alert @param {{time: number} | undefined} acknowledged @param {number} now [s since the epoch]
 */
export function isAcknowledged({ since, once, earlier }, acknowledged, now) {
  if (!acknowledged) return false;
  if (once) return true;
  return earlier ? now - acknowledged.time < HELD : since <= acknowledged.time;
}

/** Whether the user may acknowledge an alert, as the cloud decides it. @param {Alert} alert @param {object[]} robots @param {boolean} isAdmin */
export function mayAcknowledge({ object }, robots, isAdmin) {
  const [, kind, name] = /^(\w+)\/?(.*)$/.exec(object);
  if (kind === "robots") return mayDrive(robots.find(({ id }) => id === name) ?? null);
  if (kind === "buildings") return !name.includes(":");
  return kind === "maps" || isAdmin;
}

/** Whether the end of a robot's socket was no farewell. @param {{details: {role?: string, code?: number}}} event of the audit log */
export function brokeOff({ details }) {
  return details.role === "robot" && ![1000, 1001].includes(details.code);
}

/** The name of a robot in an event, as the user knows it. @param {{user: string, object: string}} event @param {string} me */
export function robotOf({ user, object }, me) {
  const name = /^robots\/([^/]+)/.exec(object ?? "")?.[1] ?? "";
  return !name || user === me || name.includes(":") ? name : `${user}:${name}`;
}
