/** Versions of maps in words, and the parts of their grids that a picture shows. */

/** Cells around a change that its pictures show. */
const MARGIN = 20;

const SHOWN = 8; // characters of the name of a version

/** Whether a user may publish, roll back and remove a map. @param {{owner: string}} map @param {{id: string, role: string}} me */
export function mayChange({ owner }, me) {
  return owner === me.id || me.role === "admin";
}

/** Who else reads a map. @param {{readers: string[]}} map */
export function readersOf({ readers }) {
  if (readers.includes("*")) return "which everybody reads";
  return readers.length ? `read by ${readers.join(", ")}` : "which nobody else reads";
}

/** Name of a version that people can compare. @param {string} version */
export function shortOf(version) {
  return version.slice(0, SHOWN);
}

/** Columns of the table of versions: a title, and the text of a version. @type {[string, (version: object, when: string) => string][]} */
export const OF_VERSION = [
  ["When", (_version, when) => when],
  ["Version", ({ version }) => shortOf(version)],
  ["Who", ({ author }) => author],
  ["Why", ({ message, restored }) => [restored ? "rolled back" : "", message].filter(Boolean).join(": ")],
];

/** What became of a version that waited. @param {object} review */
export function decisionOf({ number, state, closed_by: by, reason }) {
  return `${number} was ${state} by ${by}${reason && `: ${reason}`}`;
}

/**
 * Cells around all that a version changes.
 * @param {{column: number, row: number, width: number, height: number}[]} rectangles @param {import("../grid.js").GridInfo} info
 */
export function cropOf(rectangles, { width, height }) {
  if (!rectangles.length) return { column: 0, row: 0, width, height };
  const [left, bottom] = ["column", "row"].map((edge) => Math.max(0, Math.min(...rectangles.map((one) => one[edge])) - MARGIN));
  const right = Math.min(width, Math.max(...rectangles.map((one) => one.column + one.width)) + MARGIN);
  const top = Math.min(height, Math.max(...rectangles.map((one) => one.row + one.height)) + MARGIN);
  return { column: left, row: bottom, width: right - left, height: top - bottom };
}

/**
 * Where the cells of one grid are in another one, for grids of the same resolution that are not turned.
 * @param {import("../grid.js").GridInfo} from @param {import("../grid.js").GridInfo} to
 */
export function shiftOf(from, to) {
  const cells = (axis) => Math.round((from.origin[axis] - to.origin[axis]) / to.resolution);
  return { columns: cells("x"), rows: cells("y") };
}

/**
 * Cut a part out of a grid; what is beyond it is unknown.
 * @param {import("../grid.js").Grid} grid @param {{column: number, row: number, width: number, height: number}} crop
 * @returns {import("../grid.js").Grid}
 */
export function cut({ info, cells }, { column, row, width, height }) {
  const part = new Int8Array(width * height).fill(-1);
  const [first, end] = [Math.max(0, -column), Math.min(width, info.width - column)];
  for (let y = Math.max(0, -row); y < Math.min(height, info.height - row) && first < end; y += 1) {
    const begin = (row + y) * info.width + column;
    part.set(cells.subarray(begin + first, begin + end), y * width + first);
  }
  return { info: { ...info, width, height }, cells: part };
}
