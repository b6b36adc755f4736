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

  /** @param {(tool: Tool) => void} picked */
  constructor(picked) {
    for (const tool of TOOLS) byId(`tool-${tool}`).addEventListener("click", () => picked(tool));
  }

  /** @param {Tool} tool */
  pick(tool) {
    this.current = tool;
    this.#show();
  }

  /** Set the robot that the tools apply to, if any. @param {string | null} robot */
  set robot(robot) {
    this.#robot = robot;
    if (robot === null) this.current = "look";
    this.#show();
  }

  #show() {
    for (const tool of TOOLS) {
      const button = byId(`tool-${tool}`);
      button.setAttribute("aria-pressed", String(tool === this.current));
      button.disabled = tool !== "look" && this.#robot === null;
    }
    byId("map").dataset.tool = this.current;
    say(byId("hint"), HINTS[this.current]?.(this.#robot) ?? "");
  }
}
