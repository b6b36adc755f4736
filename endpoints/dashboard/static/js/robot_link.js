/** Link to one robot of the map: its file, the state of its clone, and its socket while it has a container. */

import { poseMessage } from "./geometry.js";
import { isNew } from "./growing_map.js";
import { bare } from "./messages.js";
import { RobotState } from "./robot_state.js";
import { Rosbridge } from "./rosbridge.js";
import { OTHERS, TOPICS, wanted } from "./topics.js";

/**
 * State of a robot: not connected, with a starting container, with a container that receives nothing from the robot, or
 * alive.
 * @typedef {"offline" | "starting" | "silent" | "online"} Presence
 */

const RETRY = 2; // seconds until a socket that was lost is tried again
const COVARIANCE = Array.from({ length: 36 }, (_, i) => ({ 0: 0.25, 7: 0.25, 35: 0.068 })[i] ?? 0); // as RViz says it

/** The clock of the page [s]. */
export const seconds = () => performance.now() / 1000;

/** A new id, of a goal or a driver. */
export function unique() {
  return `dashboard-${Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join("")}`;
}

export class RobotLink {
  /** @type {{id: string, map: string, model: string, radius: number, colour: number}} */ robot;
  /** @type {RobotState} */ state = new RobotState();
  /** Time of the last pose that came, on this socket or one before [s]. */
  seenAt = -Infinity;
  /** Why the traffic lets it stand now, in words; empty while it drives. */
  held = "";
  /** The last goal that was sent from here. */
  sent = "";
  /** Whether it is known by the lists of the cloud and by other robots alone: it is one of too many for a socket. */
  listed = false;
  /** Whether it hears of the other robots of its owner, too. */ observes = false;
  #container = null;
  #socket = null;
  #opening = null;
  #lostAt = -Infinity;
  #shown;
  #events;

  /**
   * @param {RobotLink["robot"]} robot
   * @param {Set<string>} shown layers
   * @param {{changed: () => void, ended: (link: RobotLink, goal: object) => void,
   *          told: (link: RobotLink, text: string) => void, others: (link: RobotLink, message: any) => void}} events
   */
  constructor(robot, shown, events) {
    this.robot = robot;
    this.#shown = shown;
    this.#events = events;
  }

  /** @returns {Presence} */
  get presence() {
    if (!this.#container?.connected) return "offline";
    if (this.#container.state !== "ready") return "starting";
    return this.state.silent(seconds()) ? "silent" : "online";
  }

  /** Whether there is a container, which may wait for the robot to come back. */
  get waits() {
    return this.#container !== null;
  }

  /** Whether the robot makes a map. */
  get mapping() {
    return isNew(this.robot.map);
  }

  get connected() {
    return Boolean(this.#socket?.open);
  }

  /** Whether it is drawn on the map. */
  get located() {
    return this.state.pose !== null && (this.connected || (this.listed && this.presence !== "offline"));
  }

  /**
   * Take what the cloud says of its container; open or close the socket by it.
   * @param {object | undefined} container
   * @param {((robot: string) => Promise<string>) | null} urlOf null if it is to have no socket
   * @param {boolean} observes whether it hears of the other robots of its owner, too
   */
  placed(container, urlOf, observes = false) {
    this.#container = container ?? null;
    if (!urlOf && !this.listed) this.close();
    this.listed = !urlOf;
    if (observes && !this.observes) this.#subscribe(OTHERS);
    else if (!observes && this.observes) this.#socket?.unsubscribe(OTHERS);
    this.observes = observes;
    if (container?.state !== "ready") this.close();
    else if (urlOf) this.#open(urlOf);
  }

  /** Take the place of a robot without a socket. @param {import("./geometry.js").Pose} pose @param {number} at [s] */
  locateAt(pose, at) {
    if (!this.listed || at < this.state.heardAt) return;
    this.state.pose = pose;
    this.state.heardAt = at;
    this.seenAt = Math.max(this.seenAt, at);
  }

  #open(urlOf) {
    if (this.#socket || this.#opening || seconds() - this.#lostAt < RETRY) return;
    const opening = {}; // another object, or none, if it was closed meanwhile
    this.#opening = opening;
    urlOf(this.robot.id).then(
      (url) => this.#opening === opening && this.#connect(url),
      () => this.#opening === opening && this.#lost(),
    );
  }

  /** @param {string} url */
  #connect(url) {
    this.#opening = null;
    this.#socket = new Rosbridge(url, {
      opened: () => this.#opened(),
      closed: () => this.#lost(),
      heard: (topic, message) => this.#heard(topic, message),
      told: (text) => this.#events.told(this, text),
    });
  }

  #opened() {
    this.state = new RobotState();
    wanted(this.#shown, this.mapping).forEach((topic) => this.#subscribe(topic));
    if (this.observes) this.#subscribe(OTHERS);
    this.#events.changed();
  }

  #lost() {
    this.#socket = null;
    this.#opening = null;
    this.#lostAt = seconds();
    this.#events.changed();
  }

  #heard(name, message) {
    if (bare(name) === OTHERS) return this.#events.others(this, message);
    const ended = this.state.take(bare(name), message, seconds());
    this.seenAt = Math.max(this.seenAt, this.state.heardAt);
    if (ended) this.#events.ended(this, ended);
    this.#events.changed();
  }

  #subscribe(topic) {
    const { type, throttle, queue } = TOPICS[topic];
    this.#socket?.subscribe(topic, type, throttle, queue);
  }

  /** Show a layer, or no longer: what is not shown is not sent either. @param {string} layer @param {boolean} on */
  layer(layer, on) {
    for (const topic of Object.keys(TOPICS).filter((name) => TOPICS[name].layer === layer)) {
      if (on) this.#subscribe(topic);
      else this.#socket?.unsubscribe(topic);
    }
    if (!on) this.state.forget(layer);
  }

  /** Drive somewhere. @param {import("./geometry.js").Pose} pose in the map @returns {boolean} whether it was told */
  drive(pose) {
    const target = { header: { frame_id: "map" }, pose: poseMessage(pose) };
    const id = unique();
    const told = this.#publish("move_base/goal", { goal_id: { id }, goal: { target_pose: target } });
    if (told) {
      this.state.target = pose;
      this.sent = id;
    }
    return told;
  }

  /** Say where the robot is. @param {import("./geometry.js").Pose} pose in the map */
  locate(pose) {
    const message = { header: { frame_id: "map" }, pose: { pose: poseMessage(pose), covariance: COVARIANCE } };
    return this.#publish("initialpose", message);
  }

  /** Drive to the frontiers of the map until none is left. */
  explore() {
    return this.#publish("explore/goal", { goal_id: { id: unique() }, goal: {} });
  }

  /** Cancel all goals of the robot. */
  cancel() {
    if (this.mapping) this.#publish("explore/cancel", {});
    return this.#publish("move_base/cancel", {});
  }

  #publish(topic, message) {
    return this.#socket?.publish(topic, message) ?? false;
  }

  close() {
    this.#socket?.close();
    this.#socket = null;
    this.#opening = null;
    this.state = new RobotState();
  }
}
