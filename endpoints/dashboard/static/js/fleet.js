/** Robots of the shown map, each with its own link. */

import { followed, posesOfOthers } from "./crowd.js";
import { RobotColours } from "./robot_colours.js";
import { RobotLink, seconds } from "./robot_link.js";
import { ROBOTS } from "./theme.js";

const RADIUS = 0.18; // of a model that the cloud does not know [m]

const byName = new Intl.Collator(undefined, { numeric: true }).compare;

export class Fleet {
  /** @type {Map<string, RobotLink>} by id */ #links = new Map();
  /** @type {string | null} */ #selected = null;
  /** @type {Map<string, object>} by robot */ #containers = new Map();
  #colours = new RobotColours(ROBOTS);
  #urlOf;
  #shown;
  #events;

  /**
   * @param {(robot: string) => Promise<string>} urlOf where a robot's socket is
   * @param {Set<string>} shown layers
   * @param {object} events of RobotLink
   */
  constructor(urlOf, shown, events) {
    this.#urlOf = urlOf;
    this.#shown = shown;
    this.#events = { ...events, others: (link, message) => this.#others(link, message) };
  }

  /** @returns {RobotLink[]} by id */
  get links() {
    return [...this.#links.values()];
  }

  /** @returns {RobotLink | null} */
  get selected() {
    return this.#links.get(this.#selected ?? "") ?? null;
  }

  /** @param {string} id @returns {RobotLink | null} */
  link(id) {
    return this.#links.get(id) ?? null;
  }

  /** @param {string | null} id */
  select(id) {
    this.#selected = id;
    this.#follow();
    this.#events.changed();
  }

  /**
   * Update the links from the lists of the cloud.
   * @param {object[]} robots of this map @param {object[]} containers of this user's robots
   * @param {Map<string, number>} radii by model [m]
   */
  update(robots, containers, radii) {
    const ids = new Set(robots.map((robot) => robot.id));
    this.#containers = new Map(containers.map((container) => [container.robot, container]));
    for (const link of this.links.filter((link) => !ids.has(link.robot.id))) this.#remove(link);
    this.#colours.give([...ids].sort(byName));
    robots.forEach((robot) => {
      const link = this.#links.get(robot.id) ?? new RobotLink(robot, this.#shown, this.#events);
      link.robot = { ...robot, radius: radii.get(robot.model) ?? RADIUS, colour: this.#colours.of(robot.id) };
      this.#links.set(robot.id, link);
    });
    this.#links = new Map([...this.#links].sort(([a], [b]) => byName(a, b)));
    this.#follow();
    this.#locate();
    this.#events.changed();
  }

  /** Tell the links their containers, and which of them are to have a socket. */
  #follow() {
    const containerOf = ({ robot }) => this.#containers.get(robot.id);
    const isReady = (link) => containerOf(link)?.state === "ready";
    const chosen = followed(this.links.filter(isReady), this.selected);
    for (const link of this.links) {
      const urlOf = chosen.has(link) || !isReady(link) ? this.#urlOf : null;
      link.placed(containerOf(link), urlOf, chosen.get(link));
    }
  }

  /** Take from the lists of the cloud where robots without a socket are, unless another robot tells it more often. */
  #locate() {
    const now = seconds();
    for (const link of this.links) {
      const { pose, seen_ago: ago } = link.robot;
      if (pose && link.state.silent(now)) link.locateAt({ x: pose[0], y: pose[1], theta: pose[2] }, now - (ago ?? Infinity));
    }
  }

  #others(observer, message) {
    const now = seconds();
    for (const [id, pose] of posesOfOthers(observer.robot.id, message)) this.#links.get(id)?.locateAt(pose, now);
    this.#events.changed();
  }

  /** @param {string} layer @param {boolean} on */
  layer(layer, on) {
    for (const link of this.links) link.layer(layer, on);
    this.#events.changed();
  }

  /** The robot at a point, or the nearest within reach. @param {{x: number, y: number}} point @param {number} reach [m] */
  at(point, reach) {
    const near = this.links
      .filter(({ located }) => located)
      .map((link) => ({ link, away: Math.hypot(link.state.pose.x - point.x, link.state.pose.y - point.y) }))
      .filter(({ link, away }) => away <= Math.max(link.robot.radius, reach))
      .sort((a, b) => a.away - b.away);
    return near[0]?.link ?? null;
  }

  #remove(link) {
    link.close();
    this.#links.delete(link.robot.id);
  }

  close() {
    for (const link of this.links) this.#remove(link);
  }
}
