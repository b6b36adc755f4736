/** Readers of ROS messages. Invalid messages yield nothing and never raise an error. */

import { poseOf } from "./geometry.js";

/** Seconds of a stamp in ROS 1's spelling or ROS 2's. @returns {number} */
export function secondsOf(stamp) {
  const { secs, nsecs, sec, nanosec } = stamp ?? {};
  return (secs ?? sec ?? 0) + (nsecs ?? nanosec ?? 0) * 1e-9;
}

/** A name without its slash: "/map" and "map" are one frame. @param {string | undefined} name */
export function bare(name) {
  return String(name ?? "").replace(/^\/+/, "");
}

/** Points of a nav_msgs/Path: x, y one after the other. */
export function pathOf(message) {
  const points = [];
  for (const { pose } of message.poses ?? []) {
    const at = poseOf(pose);
    if (at) points.push(at.x, at.y);
  }
  return new Float32Array(points);
}

/** Poses of a geometry_msgs/PoseArray: x, y, yaw one after the other. */
export function posesOf(message) {
  const poses = [];
  for (const pose of message.poses ?? []) {
    const at = poseOf(pose);
    if (at) poses.push(at.x, at.y, at.theta);
  }
  return new Float32Array(poses);
}

/**
 * Hit points of a sensor_msgs/LaserScan in the frame of the laser: x, y one after the other. Ranges that are null, 0 or
 * not between range_min and range_max are skipped.
 */
export function scanOf(message) {
  const { angle_min: first, angle_increment: step, range_min: least, range_max: most, ranges = [] } = message;
  const points = [];
  ranges.forEach((range, i) => {
    if (!Number.isFinite(range) || range <= Math.max(least, 0) || range >= most) return;
    points.push(range * Math.cos(first + i * step), range * Math.sin(first + i * step));
  });
  return new Float32Array(points);
}

/**
 * Poses of the children of a tf2_msgs/TFMessage in their parents' frames. @returns {Map<string, object>}
 * A frame that is `flipped` is upside down, as lasers are on some robots.
 */
export function framesOf(message) {
  const frames = new Map();
  for (const { header, child_frame_id: child, transform } of message.transforms ?? []) {
    const at = poseOf({ position: transform?.translation, orientation: transform?.rotation });
    const { x = 0, y = 0 } = transform?.rotation ?? {};
    if (at) frames.set(bare(child), { parent: bare(header?.frame_id), at, flipped: x * x + y * y > 0.5 });
  }
  return frames;
}

/** @typedef {{frontiers: number, area: number, text: string}} Exploration */

/** Return what a robot has explored, from explore_msgs/ExploreActionFeedback. @returns {Exploration} area in m² */
export function explorationOf({ feedback: { frontiers = 0, area = 0, text = "" } = {} }) {
  return { frontiers, area, text: String(text) };
}

/** Names of the states of actionlib_msgs/GoalStatus by number. */
export const STATUS = [
  "waiting", "driving", "stopped", "arrived", "gave up", "refused", "stopping", "stopping", "stopped", "lost",
];
const ACTIVE = new Set([0, 1, 6, 7]);
/** Ends of a goal that are errors: gave up, refused, lost. */
export const ENDED_BADLY = new Set([4, 5, 9]);

/** @typedef {{code: number, word: string, active: boolean, text: string, id: string}} GoalState */

/** Return the state in an actionlib_msgs/GoalStatus. @returns {GoalState | null} */
export function goalOf(status) {
  const code = status?.status;
  if (!(code in STATUS)) return null;
  return {
    code, word: STATUS[code], active: ACTIVE.has(code), text: String(status.text ?? ""), id: status.goal_id?.id ?? "",
  };
}
