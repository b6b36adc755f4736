/**
 * Poses in the plane, and ROS's messages of them. Metres and radians, x forward, y left, counter-clockwise.
 *
 * @typedef {{x: number, y: number}} Point
 * @typedef {{x: number, y: number, theta: number}} Pose
 */

/** Yaw of a quaternion. @param {{x?: number, y?: number, z: number, w: number}} q @returns {number} */
export function yawOf({ x = 0, y = 0, z, w }) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

/** The planar pose of a geometry_msgs/Pose, or null if it is invalid. @returns {Pose | null} */
export function poseOf(message) {
  const { position, orientation } = message ?? {};
  if (!position || !orientation) return null;
  const pose = { x: position.x, y: position.y, theta: yawOf(orientation) };
  return [pose.x, pose.y, pose.theta].every(Number.isFinite) ? pose : null;
}

/** A geometry_msgs/Pose. @param {Pose} pose */
export function poseMessage({ x, y, theta }) {
  return {
    position: { x, y, z: 0 },
    orientation: { x: 0, y: 0, z: Math.sin(theta / 2), w: Math.cos(theta / 2) },
  };
}

/** The same angle within (-π, π]. @param {number} angle */
export function wrap(angle) {
  const turned = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return turned === -Math.PI ? Math.PI : turned;
}

/** Transform a point out of a frame with this pose. @param {Pose} frame @param {Point} point @returns {Point} */
export function place(frame, { x, y }) {
  const c = Math.cos(frame.theta);
  const s = Math.sin(frame.theta);
  return { x: frame.x + c * x - s * y, y: frame.y + s * x + c * y };
}

/** Transform a pose out of a frame into the frame's parent. @param {Pose} frame @param {Pose} pose */
export function compose(frame, pose) {
  return { ...place(frame, pose), theta: wrap(frame.theta + pose.theta) };
}

/** Points moved out of a frame: x, y one after the other. @param {Pose} frame @param {Float32Array} points */
export function placeAll(frame, points) {
  const c = Math.cos(frame.theta);
  const s = Math.sin(frame.theta);
  const moved = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 2) {
    moved[i] = frame.x + c * points[i] - s * points[i + 1];
    moved[i + 1] = frame.y + s * points[i] + c * points[i + 1];
  }
  return moved;
}

/** @param {Point} a @param {Point} b */
export function distance(a, b) {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

/** Length of a line. @param {Float32Array} points x, y one after the other */
export function lengthOf(points) {
  let length = 0;
  for (let i = 2; i < points.length; i += 2) {
    length += Math.hypot(points[i] - points[i - 2], points[i + 1] - points[i - 1]);
  }
  return length;
}
