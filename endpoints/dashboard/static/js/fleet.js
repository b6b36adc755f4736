/** Robots of the shown map, each with its own link. */

import { RobotColours } from "./robot_colours.js";
import { RobotLink } from "./robot_link.js";
import { ROBOTS } from "./theme.js";

const RADIUS = 0.18; // of a model that the cloud does not know [m]

const byName = new Intl.Collator(undefined, { numeric: true }).compare;

export class Fleet {
  /** @type {Map<string, RobotLink>} by id */ #links = new Map();
  /** @type {string | null} */ #selected = null;
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
    this.#events = events;
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
    this.#events.changed();
  }

  /**
   * Update the links from the lists of the cloud.
   * @param {object[]} robots of this map @param {object[]} containers of this user's robots
   * @param {Map<string, number>} radii by model [m]
   */
  update(robots, containers, radii) {
    const ids = new Set(robots.map((robot) => robot.id));
    for (const link of this.links.filter((link) => !ids.has(link.robot.id))) this.#remove(link);
    this.#colours.give([...ids].sort(byName));
    robots.forEach((robot) => {
      const link = this.#links.get(robot.id) ?? new RobotLink(robot, this.#shown, this.#events);
      link.robot = { ...robot, radius: radii.get(robot.model) ?? RADIUS, colour: this.#colours.of(robot.id) };
      this.#links.set(robot.id, link);
      link.placed(containers.find((container) => container.robot === robot.id), this.#urlOf);
    });
    this.#links = new Map([...this.#links].sort(([a], [b]) => byName(a, b)));
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
      .filter(({ state }) => state.pose)
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
