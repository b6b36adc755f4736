/** What wakes a person: faults of the cloud, of robots and of their goals and tasks, in words. */

import { ENDED_BADLY } from "../messages.js";

/** Time for which a failed task is an alert [s]. */
export const KEPT = 86_400;

/**
 * A fault. `since` is when it began [s since the epoch], null if the cloud does not know; `robot` is where to look.
 * @typedef {{key: string, text: string, advice: string, since: number | null, robot?: string}} Alert
 */

const STORES = { store: "The store", map_store: "The map store", audit: "The audit log" };

/** Faults of the cloud itself. @param {object | null} health @returns {Alert[]} */
export function faultsOf(health) {
  if (!health) return [];
  const found = Object.entries(STORES).filter(([name]) => health[name].state === "away").map(([name, text]) => (
    { key: name, text: `${text} is away`, advice: health[name].reason ?? "Robots drive on; look at its server", since: null }
  ));
  if (health.master === "away") found.push({ key: "master", text: "No master leads the cloud", advice: "Robots with a container drive on; new ones wait", since: null });
  if (health.disk && health.disk.state !== "ok") found.push({ key: "disk", text: `The disk is ${health.disk.state}`, advice: health.disk.reason ?? "", since: null });
  if (health.plans_waiting) found.push({ key: "plans", text: `${health.plans_waiting} paths wait for the store`, advice: "They are stored when it answers", since: null });
  return found;
}

/** Endpoints that have gone silent. @param {object[] | null} endpoints @returns {Alert[]} */
export function silentEndpoints(endpoints) {
  return (endpoints ?? []).filter(({ state }) => state === "silent").map(({ id, machine }) => (
    { key: `endpoint ${id}`, text: `Endpoint ${id} is silent`, advice: `It has not reported its load for a while: look at machine ${machine}`, since: null }
  ));
}

/** Robots whose connection was lost. @param {object[]} robots @param {Map<string, number>} lost since when, by robot @returns {Alert[]} */
export function lostRobots(robots, lost) {
  return robots.filter(({ id, connected }) => connected === false && lost.has(id)).map(({ id }) => (
    { key: `lost ${id}`, text: `${id} is lost`, advice: "Its connection broke off, and it has not come back", since: lost.get(id), robot: id }
  ));
}

/** Robots whose last goal ended badly. @param {import("../robot_link.js").RobotLink[]} links of the shown map @returns {Alert[]} */
export function failedGoals(links) {
  return links.filter(({ state }) => state.goal && ENDED_BADLY.has(state.goal.code)).map(({ robot, state: { goal } }) => (
    { key: `goal ${robot.id} ${goal.id}`, text: `${robot.id} ${goal.word}`, advice: goal.text || "Its goal was not reached", since: null, robot: robot.id }
  ));
}

/** Tasks that have failed. @param {object[]} tasks @param {number} now [s since the epoch] @returns {Alert[]} */
export function failedTasks(tasks, now) {
  return tasks.filter(({ state, ended }) => state === "failed" && now - ended < KEPT).map(({ id, map, robot, reason, ended }) => (
    { key: `task ${id}`, text: `A task on ${map} has failed`, advice: reason, since: ended, ...(robot && { robot }) }
  ));
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
