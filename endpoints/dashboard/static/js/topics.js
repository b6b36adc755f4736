/** Topics of a robot that the dashboard subscribes to: type, minimum interval [ms], and layer. */

/** @typedef {"plan" | "scan" | "particles"} Layer */

/** @type {Record<string, {type: string, throttle: number, layer?: Layer}>} */
export const TOPICS = {
  amcl_pose: { type: "geometry_msgs/PoseWithCovarianceStamped", throttle: 0 }, // each, to find that of a scan
  tf_static: { type: "tf2_msgs/TFMessage", throttle: 0 },
  "move_base/status": { type: "actionlib_msgs/GoalStatusArray", throttle: 0 },
  "move_base/result": { type: "move_base_msgs/MoveBaseActionResult", throttle: 0 },
  "move_base/current_goal": { type: "geometry_msgs/PoseStamped", throttle: 0 },
  plan: { type: "nav_msgs/Path", throttle: 500, layer: "plan" },
  scan: { type: "sensor_msgs/LaserScan", throttle: 200, layer: "scan" },
  particlecloud: { type: "geometry_msgs/PoseArray", throttle: 500, layer: "particles" },
};

/** @type {Record<Layer, string>} */
export const LAYERS = { plan: "Paths", scan: "Laser scans", particles: "Particles" };

/** Return the topics without a layer and those of the shown layers. @param {Set<string>} shown */
export function wanted(shown) {
  return Object.keys(TOPICS).filter((name) => !TOPICS[name].layer || shown.has(TOPICS[name].layer));
}
