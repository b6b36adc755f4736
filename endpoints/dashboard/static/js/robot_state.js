/** State of one robot from the messages of its clone, without sockets or clocks. */

import { distance, lengthOf, placeAll, poseOf } from "./geometry.js";
import { GrowingMap } from "./growing_map.js";
import { bare, explorationOf, framesOf, goalOf, pathOf, posesOf, scanOf, secondsOf } from "./messages.js";

/** Time without a pose after which the robot counts as lost [s]. */
export const SILENCE = 3;
/** Most scans that wait for their poses: some lasers' clocks are ahead of that of the odometry. */
const WAITING = 20;
/** Most frames between a laser and the robot. */
const LINKS = 20;
/** Frame of the robot in which its pose is given. */
const BASE = "base_link";
const NOTHING = new Float32Array(0);

export class RobotState {
  /** @type {import("./geometry.js").Pose | null} */ pose = null;
  /** Time of the last pose [s]. */
  heardAt = -Infinity;
  /** Hit points of the laser in the map frame: x, y one after the other. */
  scan = NOTHING;
  /** x, y one after the other. */
  path = NOTHING;
  /** x, y, yaw one after the other. */
  particles = NOTHING;
  /** @type {import("./geometry.js").Pose | null} */ target = null;
  /** @type {import("./messages.js").GoalState | null} */ goal = null;
  /** What the robot has explored, while it does. @type {import("./messages.js").Exploration | null} */ exploration = null;
  map = new GrowingMap();

  #frames = new Map();
  /** The last scans, until the poses that they were taken at are known. */
  #waiting = [];

  /**
   * Take a message.
   * @param {string} topic @param {any} message @param {number} now seconds
   * @returns {import("./messages.js").GoalState | null} how a goal ended, if this says so
   */
  take(topic, message, now) {
    if (topic === "amcl_pose" || topic === "pose") this.#localized(message, now);
    else if (topic === "scan") this.#waiting = [...this.#waiting.slice(1 - WAITING), message];
    else if (topic === "plan") this.path = pathOf(message);
    else if (topic === "particlecloud") this.particles = posesOf(message);
    else if (topic === "map") this.map.replace(message);
    else if (topic === "map_updates") this.map.change(message);
    else if (topic === "explore/feedback") this.exploration = explorationOf(message);
    else if (topic === "explore/result") return this.#explored(goalOf(message.status));
    else if (topic === "tf_static") framesOf(message).forEach((frame, child) => this.#frames.set(child, frame));
    else if (topic === "move_base/current_goal") this.target = poseOf(message.pose);
    else if (topic === "move_base/status") this.#status(goalOf(message.status_list?.at(-1)));
    else if (topic === "move_base/result") return this.#ended(goalOf(message.status));
    return null;
  }

  /** Forget what is only true while somebody says it again. @param {string} layer */
  forget(layer) {
    if (layer === "scan") this.scan = NOTHING;
    if (layer === "particles") this.particles = NOTHING;
    if (layer === "plan") this.path = NOTHING;
  }

  /** @param {number} now seconds */
  silent(now) {
    return now - this.heardAt > SILENCE;
  }

  /** Return the goal, or the end of the path if the goal is unknown. @returns {import("./geometry.js").Point | null} */
  get destination() {
    if (!this.goal?.active) return null;
    return this.target ?? (this.path.length ? { x: this.path.at(-2), y: this.path.at(-1) } : null);
  }

  /** Return the remaining distance [m], along the path if there is one. @returns {number | null} */
  get remaining() {
    if (!this.pose || !this.destination) return null;
    return this.path.length > 2 ? lengthOf(this.path) : distance(this.pose, this.destination);
  }

  #localized(message, now) {
    const pose = poseOf(message.pose?.pose);
    if (!pose) return;
    this.pose = pose;
    this.heardAt = now;
    const at = secondsOf(message.header?.stamp);
    const scan = this.#waiting.findLast((waiting) => secondsOf(waiting.header?.stamp) <= at);
    if (!scan) return;
    this.scan = placeAll(pose, this.#onRobot(bare(scan.header?.frame_id), scanOf(scan)));
    this.#waiting = this.#waiting.filter((waiting) => secondsOf(waiting.header?.stamp) > at);
  }

  /** Move points out of the frame of a laser into that of the robot. @param {string} name @param {Float32Array} points */
  #onRobot(name, points) {
    for (let link = 0; link < LINKS && name !== BASE && this.#frames.has(name); link++) {
      const { at, flipped, parent } = this.#frames.get(name);
      points = placeAll(at, flipped ? points.map((value, i) => (i % 2 ? -value : value)) : points);
      name = parent;
    }
    return points;
  }

  #explored(goal) {
    this.exploration = null;
    return goal && { ...goal, word: goal.word === "arrived" ? "has explored all it can reach" : goal.word };
  }

  #status(goal) {
    if (goal) this.#set(goal);
  }

  #ended(goal) {
    const another = this.goal?.active && this.goal.id !== goal?.id; // which took its place
    if (goal && !another) this.#set(goal);
    return goal;
  }

  #set(goal) {
    this.goal = goal;
    if (!goal.active) {
      this.target = null;
      this.path = NOTHING;
    }
  }
}
