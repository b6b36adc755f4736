/** Stops of robots, as the cloud lists them: which apply to a robot, and in words. */

/** @typedef {{user: string, scope: "robot" | "map" | "all", name: string, by: string, since: number, reason: string}} Stop */

const WHAT = { all: () => "All robots are", map: ({ name }) => `All robots on map ${name} are`, robot: ({ name }) => `${name} is` };

/** @param {Stop} stop @param {string} me id of the user @returns {string} */
export function inWords(stop, me) {
  const whose = stop.user === me ? "" : `${stop.user}: `;
  const at = new Date(stop.since * 1000).toLocaleString([], { dateStyle: "short", timeStyle: "medium" });
  return `${whose}${WHAT[stop.scope](stop)} stopped by ${stop.by} since ${at}${stop.reason ? `: ${stop.reason}` : ""}`;
}

/** Whether a stop applies to a robot; robots of others have their address as their id. @param {Stop} stop @param {{id: string, user: string, map: string}} robot */
export function appliesTo(stop, robot) {
  if (stop.user !== robot.user) return false;
  if (stop.scope === "all") return true;
  return stop.name === (stop.scope === "map" ? robot.map : robot.id.split(":").pop());
}

/** Path of the resource to which the end of a stop is posted. @param {Stop} stop @param {string} me */
export function releasePath({ user, scope, name }, me) {
  if (scope === "all") return "v1/release";
  if (scope === "map") return `v1/maps/${encodeURIComponent(name)}/release`;
  return `v1/robots/${encodeURIComponent(user === me ? name : `${user}:${name}`)}/release`;
}
