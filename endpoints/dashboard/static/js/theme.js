/** The colours of the drawing, which are those of the page: light or dark, as the system wants it. */

/** @typedef {{ground: string, ink: string, halo: string, bad: string, heat: string, zones: Record<string, string>, palette: import("./grid.js").Palette, robots: string[]}} Theme */

/** Number of colours of robots. */
export const ROBOTS = 8;
const ZONES = ["keep_out", "speed_limit", "one_way", "no_stop", "capacity", "lane", "station", "door", "lift", "passage", "dock"];

/** @param {string} text as "#rrggbb" @returns {import("./grid.js").Colour} */
export function colourOf(text) {
  const value = Number.parseInt(text.trim().slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

/** Read the theme from the page's style. @returns {Theme} */
export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const read = (name) => style.getPropertyValue(`--map-${name}`).trim();
  return {
    ground: read("ground"),
    ink: read("ink"),
    halo: read("halo"),
    bad: style.getPropertyValue("--bad").trim(),
    heat: read("heat"),
    zones: Object.fromEntries(ZONES.map((kind) => [kind, read(kind.replace("_", "-"))])),
    palette: { free: colourOf(read("free")), occupied: colourOf(read("occupied")), unknown: colourOf(read("unknown")) },
    robots: Array.from({ length: ROBOTS }, (_, i) => style.getPropertyValue(`--robot-${i}`).trim()),
  };
}

/** @param {() => void} changed */
export function onTheme(changed) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
}
