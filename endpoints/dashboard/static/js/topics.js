/**
 * Topics of a robot that the dashboard subscribes to: type, minimum interval [ms], and layer; for some, whether only
 * robots that make a map publish them, and how many messages may wait.
 */

/** @typedef {"plan" | "scan" | "particles" | "people" | "traffic" | "zones"} Layer */

/** Topic with the places of other robots, which few robots of many are asked for. */
export const OTHERS = "robots";

/** @type {Record<string, {type: string, throttle: number, layer?: Layer, mapping?: true, queue?: number, asked?: true}>} */
export const TOPICS = {
  amcl_pose: { type: "geometry_msgs/PoseWithCovarianceStamped", throttle: 0 }, // each, to find that of a scan
  pose: { type: "geometry_msgs/PoseWithCovarianceStamped", throttle: 0, mapping: true },
  map: { type: "nav_msgs/OccupancyGrid", throttle: 0, mapping: true },
  map_updates: { type: "map_msgs/OccupancyGridUpdate", throttle: 0, mapping: true, queue: 100 }, // each counts
  "explore/feedback": { type: "explore_msgs/ExploreActionFeedback", throttle: 500, mapping: true },
  "explore/result": { type: "explore_msgs/ExploreActionResult", throttle: 0, mapping: true },
  [OTHERS]: { type: "ppaas_msgs/RobotStates", throttle: 200, asked: true },
  tf_static: { type: "tf2_msgs/TFMessage", throttle: 0 },
  "move_base/status": { type: "actionlib_msgs/GoalStatusArray", throttle: 0 },
  "move_base/result": { type: "move_base_msgs/MoveBaseActionResult", throttle: 0 },
  "move_base/current_goal": { type: "geometry_msgs/PoseStamped", throttle: 0 },
  plan: { type: "nav_msgs/Path", throttle: 500, layer: "plan" },
  scan: { type: "sensor_msgs/LaserScan", throttle: 200, layer: "scan" },
  particlecloud: { type: "geometry_msgs/PoseArray", throttle: 500, layer: "particles" },
};

/** @type {Record<Layer, string>} */
export const LAYERS = { plan: "Paths", scan: "Laser scans", particles: "Particles", people: "People", traffic: "Traffic", zones: "Zones", building: "Lifts and doors" };

/**
 * Return the topics without a layer and those of the shown layers.
 * @param {Set<string>} shown @param {boolean} mapping whether the robot makes a map
 */
export function wanted(shown, mapping) {
  return Object.keys(TOPICS).filter((name) => {
    const { layer, mapping: only, asked } = TOPICS[name];
    return !asked && (!layer || shown.has(layer)) && (mapping || !only);
  });
}
