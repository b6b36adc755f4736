/** Robots that others share with the user, beside the user's own: their id here is their address, `OWNER:ID`. */

import { isNew } from "./growing_map.js";
import { refused } from "./rest.js";

/**
 * Address of a robot, as the cloud takes it from a user.
 * @param {string} owner @param {string | null} id @param {string} me id of the user
 */
function address(owner, id, me) {
  return owner === me || id === null ? id : `${owner}:${id}`;
}

/** The robots of a user and those that are shared. @param {object[]} own @param {object[]} shared @param {string} me */
export function withShared(own, shared, me) {
  return [...own, ...shared.map((robot) => ({ ...robot, id: address(robot.user, robot.id, me) }))];
}

/** The right of the user to send a robot to goals; there is none without a robot. @param {{role: string} | null | undefined} robot */
export function mayDrive(robot) {
  return Boolean(robot) && robot.role !== "look";
}

/** The right of the user to change a robot; a robot that is not listed is the user's own. @param {{role: string} | null | undefined} robot */
export function mayAdminister(robot) {
  return !robot || robot.role === "administer";
}

/**
 * The containers of a user, and those of robots that are shared.
 * @param {object[]} containers @param {object[]} robots of `withShared` @param {string} me
 */
export function containersOf(containers, robots, me) {
  const ids = new Set(robots.map(({ id }) => id));
  return containers
    .map((container) => ({ ...container, robot: address(container.user, container.robot, me) }))
    .filter(({ user, robot }) => user === me || ids.has(robot));
}

/**
 * The maps of a user, and those that shared robots show.
 * @param {import("./rest.js").Rest} rest @param {object[]} maps @param {object[]} robots
 */
export async function mapsOf(rest, maps, robots) {
  const listed = new Set(maps.map(({ id }) => id));
  const others = new Set(robots.map(({ map }) => map).filter((id) => !isNew(id) && !listed.has(id)));
  const leftOut = refused(404, () => null); // a map that is not shown to the user
  const found = await Promise.all([...others].map((id) => rest.get(`v1/maps/${encodeURIComponent(id)}`).catch(leftOut)));
  return [...maps, ...found.filter(Boolean)];
}
