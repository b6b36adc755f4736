/** Card of the selected robot: its state and its commands. */

import { DiagnosisPanel } from "./diagnosis.js";
import { byId, make, say } from "./dom.js";
import { degrees, number } from "./format.js";
import { nameOf, sharing } from "./growing_map.js";
import { NAME_OF_MAP, orderForm } from "./order_form.js";
import { doing, showPresence } from "./robot_list.js";
import { mayDrive } from "./shared_robots.js";

const INPUTS = [["x", "x [m]"], ["y", "y [m]"], ["yaw", "Heading [°]"]];

export class RobotCard {
  #card = byId("robot-card");
  #parts;
  #inputs;
  #diagnosis;
  #recordings;
  #camera;

  /**
   * @param {{drive: (pose: import("./geometry.js").Pose) => void, cancel: () => void, release: () => void,
   *          explore: () => void, publish: (name: string) => Promise<void>}} orders
   * @param {(robot: string, seconds: number) => Promise<object>} diagnose
   * @param {import("./recordings.js").RecordingsDialog} recordings
   * @param {import("./camera.js").CameraView} camera
   */
  constructor(orders, diagnose, recordings, camera) {
    this.#recordings = recordings;
    this.#camera = camera;
    this.#diagnosis = new DiagnosisPanel(diagnose);
    this.#parts = {
      swatch: make("span", { className: "swatch" }),
      name: make("span", { className: "name" }),
      presence: make("span", { className: "presence" }),
      doing: make("p", { className: "doing", role: "status" }),
      where: make("p", { className: "where" }),
      shared: make("p", { className: "where" }),
      drive: make("details", { className: "go" }),
      cancel: make("button", { className: "button stop", type: "button", textContent: "Cancel goal", onclick: orders.cancel }),
      release: make("button", { className: "button", type: "button", textContent: "Done", onclick: orders.release }),
      explore: make("button", { className: "button", type: "button", textContent: "Explore", onclick: orders.explore }),
      publish: make("details", { className: "go" }),
    };
    this.#inputs = INPUTS.map(([name, text]) => {
      const input = make("input", { name, type: "number", step: "any", required: name !== "yaw", inputMode: "decimal" });
      return { input, label: make("label", {}, text, input) };
    });
    this.#build(orders);
  }

  #build(orders) {
    const { swatch, name, presence, doing: what, where, shared, drive, cancel, release, explore } = this.#parts;
    const form = make("form", { className: "go-form", "aria-label": "Drive to coordinates" });
    form.append(...this.#inputs.map(({ label }) => label), make("button", { className: "button", textContent: "Go" }));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const [x, y, yaw] = this.#inputs.map(({ input }) => input.valueAsNumber || 0);
      orders.drive({ x, y, theta: (yaw * Math.PI) / 180 });
    });
    drive.append(make("summary", { textContent: "Drive to coordinates" }), form);
    this.#card.replaceChildren(
      make("div", { className: "head" }, swatch, name, presence), what, where, shared,
      drive, this.#publishForm(orders), this.#diagnosis.element, this.#camera.element, this.#recordings.opener,
      make("div", { className: "actions" }, explore, cancel, release),
    );
  }

  #publishForm({ publish }) {
    const input = make("input", { name: "map", ...NAME_OF_MAP });
    const form = orderForm("Publish its map", "Publish", () => publish(input.value), make("label", {}, "Name", input));
    this.#parts.publish.replaceChildren(make("summary", { textContent: "Publish its map" }), form);
    return this.#parts.publish;
  }

  /** Show what only robots have that make a map. @param {import("./robot_link.js").RobotLink} link */
  #showMapping({ robot, mapping, connected, state }) {
    const { explore, publish } = this.#parts;
    explore.hidden = !mapping || !mayDrive(robot);
    publish.hidden = !mapping || robot.role !== "administer";
    explore.disabled = !connected || state.exploration !== null;
    const input = publish.querySelector("input");
    if (mapping && !input.value) input.value = nameOf(robot.map);
  }

  /** Show with which robots the selected one makes its map. @param {Parameters<typeof sharing>[0]} map */
  showSharing(map) {
    say(this.#parts.shared, sharing(map));
  }

  /** @param {import("./robot_link.js").RobotLink | null} link @param {string} colour */
  update(link, colour) {
    this.#card.hidden = !link;
    this.#diagnosis.select(link?.robot.id ?? null, link?.presence === "silent");
    this.#recordings.select(link?.robot ?? null);
    this.#camera.select(link?.robot.id ?? null, Boolean(link?.waits));
    if (!link) return;
    const { swatch, name, presence, doing: what, where, cancel } = this.#parts;
    swatch.style.background = colour;
    say(name, link.robot.id);
    showPresence(presence, link);
    say(what, doing(link));
    const { pose } = link.state;
    say(where, pose ? `x ${number(pose.x, 2)} m · y ${number(pose.y, 2)} m · heading ${degrees(pose.theta)}` : "");
    this.#showMapping(link);
    this.#parts.drive.hidden = cancel.hidden = !mayDrive(link.robot);
    cancel.disabled = !link.connected || !(link.state.goal?.active || link.state.exploration);
    for (const { input } of this.#inputs) input.disabled = !link.connected;
    this.#card.querySelector(".go-form .button").disabled = !link.connected;
  }
}
