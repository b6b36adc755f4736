/** Events of the audit log and of robots in words, and which of them are asked for. */

/** Kinds of events. */
export const KINDS = { all: "All", changes: "Changes", access: "Logins and rights", connections: "Connections", refusals: "Refused and failed", robots: "Robots seen by this page" };

const ACCESS = /log_in|token|ticket|user|group|session|share/;

/**
 * A line of the timeline.
 * @typedef {{key: string, time: number, kind: string, who: string, what: string, object: string, outcome: string, details: string}} Line
 */

/** @param {{action: string, outcome: string}} event @returns {string} */
export function kindOf({ action, outcome }) {
  if (outcome !== "ok") return "refusals";
  if (action === "connect" || action === "disconnect") return "connections";
  return ACCESS.test(action) ? "access" : "changes";
}

const shown = (value) => (typeof value === "object" ? JSON.stringify(value) : String(value));

/** What an event changed, and why it was refused. */
function detailsOf({ address, reason, status, details, repeats }) {
  const parts = Object.entries(details).map(([name, value]) => `${name.replaceAll("_", " ")} ${shown(value)}`);
  if (reason) parts.unshift(`${reason.replaceAll("-", " ")}${status ? ` (${status})` : ""}`);
  if (address) parts.push(`from ${address}`);
  if (repeats) parts.push(`and ${repeats} more like it`);
  return parts.join(", ");
}

/** The line of an event of the audit log. @param {object} event @returns {Line} */
export function lineOf(event) {
  const { number, time, user, action, object, outcome } = event;
  return {
    key: `event ${number}`, time, kind: kindOf(event), who: user ?? "unknown", what: action.replaceAll("_", " "),
    object: object ?? "", outcome, details: detailsOf(event),
  };
}

/** The line of what the page saw of a robot. @param {import("../journal.js").Entry} entry @returns {Line} */
export function lineOfEntry({ number, time, robot, text, bad }) {
  return { key: `seen ${number}`, time, kind: "robots", who: robot, what: text, object: `robots/${robot}`, outcome: bad ? "failed" : "ok", details: "" };
}

/** The path of a page of the audit log. @param {{user: string, robot: string}} wanted @param {Record<string, string | number>} more */
export function pathOf({ user, robot }, more) {
  const query = new URLSearchParams(more);
  if (user) query.set("user", user);
  if (robot) query.set("object", `robots/${robot}`);
  return `v1/audit?${query}`;
}

/** The lines that are asked for, the newest first. @param {Line[]} lines @param {{kind: string, user: string, robot: string}} wanted */
export function chosen(lines, { kind, user, robot }) {
  const isChosen = (line) =>
    (kind === "all" || line.kind === kind) &&
    (line.kind !== "robots" || ((!robot || line.who === robot) && !user));
  return lines.filter(isChosen).sort((a, b) => b.time - a.time || b.key.localeCompare(a.key, undefined, { numeric: true }));
}

/** The time of an event, with its day if that is another one. @param {number} time [s since the epoch] @param {number} now */
export function timeText(time, now) {
  const [at, today] = [new Date(time * 1000), new Date(now * 1000)];
  const clock = at.toLocaleTimeString();
  return at.toDateString() === today.toDateString() ? clock : `${at.toLocaleDateString()} ${clock}`;
}
