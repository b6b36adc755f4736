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
  /** Whether clicks on the map are corners of a zone, which no tool takes. */ #paused = false;

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

  /** Pause all tools while the user draws on the map, and take the one before up again. @param {boolean} paused */
  pause(paused) {
    this.#paused = paused;
    this.#show();
  }

  #hint() {
    if (this.#paused) return "Click on the map to draw; Escape cancels";
    if (this.#robot !== null && !this.#mayDrive) return `You may look at ${this.#robot}, not drive it`;
    return HINTS[this.current]?.(this.#robot) ?? "";
  }

  #show() {
    for (const tool of TOOLS) {
      const button = byId(`tool-${tool}`);
      button.setAttribute("aria-pressed", String(tool === this.current && !this.#paused));
      button.disabled = this.#paused || (tool !== "look" && !this.#mayDrive);
    }
    byId("map").dataset.tool = this.current;
    say(byId("hint"), this.#hint());
  }
}
