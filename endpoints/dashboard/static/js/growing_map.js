/** Map that a robot makes while it drives: the last whole grid with the changes since. */

import { poseOf } from "./geometry.js";
import { Refused } from "./rest.js";

/** Prefix of the map of a robot that makes one. */
const NEW = "new:";

/** Whether a robot's map is one that it makes. @param {string | null} map */
export function isNew(map) {
  return map?.startsWith(NEW) ?? false;
}

/** Name under which a map that is being made is to be published. @param {string} map */
export function nameOf(map) {
  return map.slice(NEW.length);
}

/**
 * Ask the cloud for the map that a robot makes; null if it makes none, has none yet, or has just left.
 * @param {import("./rest.js").Rest} rest @param {import("./robot_link.js").RobotLink | null} link
 */
export async function mapMadeBy(rest, link) {
  if (!link?.mapping || !link.connected) return null;
  try {
    return await rest.get(`v1/robots/${encodeURIComponent(link.robot.id)}/map`);
  } catch (error) {
    if (!(error instanceof Refused) || error.status === 401) throw error;
    return null;
  }
}

const STAGES = {
  transfer: "the map is fetched", waiting: "other work comes first", loops: "missing loops are searched",
  alignment: "all scans are aligned", drawing: "the map is drawn", storing: "the map is stored",
};

/**
 * Say how far the publication of a robot's map is; otherwise with which robots it makes the map, as the cloud tells.
 * @param {{joined_with: string[], refused: string | null, publishing?: {stage: string, part: number} | null} | null} map
 */
export function sharing(map) {
  if (!map) return "";
  if (map.publishing) {
    const { stage, part } = map.publishing;
    return `Publishing: ${STAGES[stage] ?? stage}${part > 0 ? `, ${Math.floor(100 * part)} %` : ""}`;
  }
  const reason = map.refused ? `not joined with another map: ${map.refused}` : "";
  if (!map.joined_with.length) return reason ? `Map ${reason}` : "";
  const others = `Map made together with ${map.joined_with.join(", ")}`;
  return reason ? `${others}; ${reason}` : others;
}

export class GrowingMap {
  /** @type {import("./grid.js").Grid | null} another object after each change */ grid = null;

  /** Replace the grid. @param {any} message nav_msgs/OccupancyGrid */
  replace({ info = {}, data = [] }) {
    const { resolution, width, height } = info;
    const origin = poseOf(info.origin);
    if (!origin || !(resolution > 0) || data.length !== width * height) return;
    this.grid = { info: { resolution, width, height, origin }, cells: Int8Array.from(data) };
  }

  /** Change a rectangle; one outside the grid belongs to another grid. @param {any} message map_msgs/OccupancyGridUpdate */
  change({ x, y, width, height, data = [] }) {
    if (!this.grid || data.length !== width * height) return;
    const { info, cells } = this.grid;
    if (!(x >= 0 && y >= 0 && x + width <= info.width && y + height <= info.height)) return;
    for (let row = 0; row < height; row += 1) {
      cells.set(data.slice(row * width, (row + 1) * width), (y + row) * info.width + x);
    }
    this.grid = { info, cells };
  }
}
