/** Users and tokens in words, and what is asked of the cloud for them. */

import { duration } from "../format.js";

export const DAY = 86_400; // [s]

/** What a token may do, in words. @param {{scope: object | null}} token */
export function scopeText({ scope }) {
  if (!scope) return "All that its user may do";
  const { role, robots } = scope;
  const does = { look: "Looks at", drive: "Drives", administer: "Administers", robot: "Connects as" }[role];
  return `${does} ${robots.join(", ")}`;
}

/** How long a token is good. @param {{expires: number}} token @param {number} now [s since the epoch] */
export function expiryText({ expires }, now) {
  if (expires <= now) return "expired";
  const days = Math.floor((expires - now) / DAY);
  return days > 1 ? `good for ${days} days` : `good for ${duration(expires - now)}`;
}

/** Names of a text that separates them by spaces or commas. @param {string} text @returns {string[]} */
export function namesOf(text) {
  return text.split(/[\s,]+/).filter(Boolean);
}

/** The file of variables with which a robot's program finds its cloud and logs in. @param {string} url of the cloud @param {string} token */
export function variablesOf(url, token) {
  return `PPAAS_URL=${url}\nPPAAS_TOKEN=${token}\n`;
}

/** A password that nobody knows: it locks a user out. */
export function unknownPassword() {
  return Array.from(crypto.getRandomValues(new Uint8Array(24)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
