/** Tools for clicks on the map: look around, send the selected robot to a goal, or set its pose. */

import { byId, say } from "./dom.js";

/** @typedef {"look" | "drive" | "locate"} Tool */

/** @type {Tool[]} */
const TOOLS = ["look", "drive", "locate"];

const HINTS = {
  drive: (id) => `Pick where ${id} goes, drag to turn it`,
  locate: (id) => `Pick where ${id} is, drag to turn it`,
};

export class Tools {
  /** @type {Tool} */ current = "look";
  #robot = null;
  #mayDrive = false;
  /** What clicks on the map mean while no tool takes them; empty otherwise. */ #paused = "";

  /** @param {(tool: Tool) => void} picked */
  constructor(picked) {
    for (const tool of TOOLS) byId(`tool-${tool}`).addEventListener("click", () => picked(tool));
  }

  /** @param {Tool} tool */
  pick(tool) {
    this.current = tool;
    this.#show();
  }

  /** Set the robot that the tools apply to, if any. @param {string | null} robot @param {boolean} mayDrive */
  apply(robot, mayDrive) {
    if (robot === this.#robot && mayDrive === this.#mayDrive) return;
    this.#robot = robot;
    this.#mayDrive = mayDrive;
    if (!mayDrive) this.current = "look";
    this.#show();
  }

  /** Pause all tools while clicks on the map mean something else, and take the one before up again. @param {string} hint what they mean; empty to go on */
  pause(hint) {
    this.#paused = hint;
    this.#show();
  }

  #hint() {
    if (this.#paused) return this.#paused;
    if (this.#robot !== null && !this.#mayDrive) return `You may look at ${this.#robot}, not drive it`;
    return HINTS[this.current]?.(this.#robot) ?? "";
  }

  #show() {
    for (const tool of TOOLS) {
      const button = byId(`tool-${tool}`);
      button.setAttribute("aria-pressed", String(tool === this.current && !this.#paused));
      button.disabled = Boolean(this.#paused) || (tool !== "look" && !this.#mayDrive);
    }
    byId("map").dataset.tool = this.current;
    say(byId("hint"), this.#hint());
  }
}
