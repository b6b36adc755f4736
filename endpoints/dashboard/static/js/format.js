/** Numbers for people. */

const UNITS = ["B", "KiB", "MiB", "GiB", "TiB"];

/** @param {number | null | undefined} bytes */
export function bytes(bytes) {
  if (!Number.isFinite(bytes)) return "–";
  const power = Math.min(UNITS.length - 1, Math.max(0, Math.floor(Math.log2(Math.max(bytes, 1)) / 10)));
  const value = bytes / 1024 ** power;
  return `${value.toFixed(power && value < 100 ? 1 : 0)} ${UNITS[power]}`;
}

/** @param {number | null | undefined} value @param {number} digits */
export function number(value, digits = 1) {
  return Number.isFinite(value) ? value.toFixed(digits).replace(/^-(0(\.0+)?)$/, "$1") : "–";
}

/** A time in its largest unit. @param {number} seconds */
export function duration(seconds) {
  if (seconds < 60) return `${number(Math.floor(seconds), 0)} s`;
  return seconds < 3600 ? `${number(Math.floor(seconds / 60), 0)} min` : `${number(Math.floor(seconds / 3600), 0)} h`;
}

/** @param {number} radians */
export function degrees(radians) {
  return `${number((radians * 180) / Math.PI, 0)}°`;
}

/** @param {number} count @param {string} noun */
export function plural(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}
