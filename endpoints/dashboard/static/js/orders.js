/** Orders of the user to the selected robot. */

import { mayDrive } from "./shared_robots.js";
import { toast } from "./toasts.js";

export class Orders {
  #fleet;
  #tools;
  #rest;
  #events;

  /**
   * @param {import("./fleet.js").Fleet} fleet @param {import("./tools.js").Tools} tools @param {import("./rest.js").Rest} rest
   * @param {{changed: () => void, ask: (order: Promise<unknown>, done: string) => Promise<void>, release: () => void}} events
   */
  constructor(fleet, tools, rest, events) {
    this.#fleet = fleet;
    this.#tools = tools;
    this.#rest = rest;
    this.#events = events;
  }

  /** Take the tool for a robot that was selected. */
  begin() {
    const link = this.#fleet.selected;
    if (link) this.#tools.pick(link.connected && mayDrive(link.robot) ? "drive" : "look");
  }

  /** Do what the tool does with a place that was picked on the map. @param {import("./geometry.js").Pose} pose */
  pick(pose) {
    return this.#tools.current === "drive" ? this.drive(pose) : this.#locate(pose);
  }

  /** @param {import("./geometry.js").Pose} pose */
  drive(pose) {
    const link = this.#fleet.selected;
    if (link && !link.drive(pose)) toast(`${link.robot.id} is not connected: nobody was told`, "bad");
    this.#events.changed();
  }

  #locate(pose) {
    const link = this.#fleet.selected;
    if (!link?.locate(pose)) toast(`${link?.robot.id} is not connected: nobody was told`, "bad");
    else toast(`${link.robot.id} was told where it is`);
    this.#tools.pick("drive");
  }

  cancel() {
    this.#fleet.selected?.cancel();
  }

  explore() {
    this.#fleet.selected?.explore();
  }

  /** Let go of the robot. */
  release() {
    this.#events.release();
  }

  /** Publish the map that the robot makes. @param {string} name */
  publish(name) {
    const { id } = this.#fleet.selected.robot;
    return this.#events.ask(this.#rest.post(`v1/robots/${encodeURIComponent(id)}/map`, { publish: name }), `${name} is published: robots can drive on it`);
  }
}
