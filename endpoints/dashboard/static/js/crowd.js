/**
 * Many robots on one map. A browser opens 255 sockets to a cloud at most, and each socket costs time: where more robots
 * than `MOST_FOLLOWED` have containers, only the selected one and one of each owner have a socket, and the cloud tells
 * this one where the others of its owner are, in one message.
 */

import { poseOf } from "./geometry.js";

/** Most robots of a map that all have sockets. */
export const MOST_FOLLOWED = 64;

/** The part of a robot's address before its name: empty for one of the user's own. @param {string} id */
function ownerOf(id) {
  return id.slice(0, id.indexOf(":") + 1);
}

/**
 * Which robots have a socket, and whether each hears of the others through it.
 * @template {{robot: {id: string}, observes: boolean}} Link
 * @param {Link[]} ready robots with a container, by name @param {Link | null} selected @returns {Map<Link, boolean>}
 */
export function followed(ready, selected) {
  if (ready.length <= MOST_FOLLOWED) return new Map(ready.map((link) => [link, false]));
  const chosen = new Map(ready.includes(selected) ? [[selected, false]] : []);
  const observers = new Map();
  for (const link of [...ready.filter(({ observes }) => observes), ...ready]) {
    const owner = ownerOf(link.robot.id);
    if (!observers.has(owner)) observers.set(owner, link);
  }
  for (const link of observers.values()) chosen.set(link, true);
  return chosen;
}

/**
 * Where other robots of the owner of a robot are.
 * @param {string} observer id of the robot that heard of them @param {any} message ppaas_msgs/RobotStates
 * @returns {[string, import("./geometry.js").Pose][]} by id
 */
export function posesOfOthers(observer, { names = [], poses = [] }) {
  const owner = ownerOf(observer);
  return names.flatMap((name, i) => {
    const pose = name ? poseOf(poses[i]) : null;
    return pose ? [[owner + name, pose]] : [];
  });
}
