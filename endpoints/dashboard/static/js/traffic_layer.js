/** Draws the traffic on the map, below robots: the cells that each robot holds, and where robots have waited. */

import { band } from "./shapes.js";

const BAND = { picked: 0.55, other: 0.3 }; // opacity
const HEAT = { least: 0.12, most: 0.7 };

export class TrafficLayer {
  /** Whether it is shown where robots have waited. */
  heat = true;
  #state;
  #colourOf;
  #theme;

  /**
   * @param {import("./traffic_state.js").TrafficState} state @param {import("./theme.js").Theme} theme
   * @param {(robot: string) => string} colourOf
   */
  constructor(state, theme, colourOf) {
    this.#state = state;
    this.#theme = theme;
    this.#colourOf = colourOf;
  }

  set theme(theme) {
    this.#theme = theme;
  }

  /** Draw the traffic. @param {CanvasRenderingContext2D} context @param {import("./view.js").View} view */
  draw(context, view) {
    if (!this.#state.answer) return;
    if (this.heat) this.#drawWaits(context, view);
    const { robots, spacing } = this.#state.answer;
    for (const { robot, way } of robots) {
      context.globalAlpha = robot === this.#state.picked ? BAND.picked : BAND.other;
      band(context, view, way, spacing, this.#colourOf(robot));
    }
    context.globalAlpha = 1;
  }

  #drawWaits(context, view) {
    const { longest } = this.#state;
    context.fillStyle = this.#theme.heat;
    for (const { x, y, size, seconds } of this.#state.waits) {
      const { x: left, y: top } = view.toScreen({ x: x - size / 2, y: y + size / 2 });
      context.globalAlpha = HEAT.least + ((HEAT.most - HEAT.least) * seconds) / longest;
      context.fillRect(left, top, size * view.scale, size * view.scale);
    }
    context.globalAlpha = 1;
  }
}
