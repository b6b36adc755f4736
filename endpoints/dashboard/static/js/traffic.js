/** Traffic on the shown map: polls it while robots take part, and sends what the user wants. */

import { Refused } from "./rest.js";
import { readTheme } from "./theme.js";
import { TrafficLayer } from "./traffic_layer.js";
import { TrafficPanel } from "./traffic_panel.js";
import { TrafficState } from "./traffic_state.js";

const PERIOD = 1000; // ms between two looks
const SLOW = 10_000; // after the cloud had no traffic to show

export class Traffic {
  state = new TrafficState();
  layer;
  #panel;
  #rest;
  #events;
  /** Path of the shown map. @type {string | null} */ #map = null;
  /** What is polled now; another one ends the polls of the one before. @type {{path: string} | null} */ #polled = null;
  #timer = 0;

  /**
   * @param {import("./rest.js").Rest} rest
   * @param {{changed: () => void, failed: (error: Error) => void, ask: (order: Promise<object>, done: string) => Promise<void>}} events
   * @param {{colourOf: (robot: string) => string, mayChange: (robot: string) => boolean}} robots
   */
  constructor(rest, events, robots) {
    this.#rest = rest;
    this.#events = events;
    this.layer = new TrafficLayer(this.state, readTheme(), robots.colourOf);
    this.#panel = new TrafficPanel({
      ...robots,
      pick: (robot) => this.#pick(robot),
      heat: (on) => this.#heat(on),
      change: (robot, change) => this.#change(robot, change),
    });
  }

  /** Show the traffic of a map. @param {string} path of the map @param {boolean} runs whether robots of the user take part */
  follow(path, runs) {
    if (path !== this.#map) this.state.clear();
    this.#map = path;
    const traffic = runs ? `${path}/traffic` : undefined;
    if (traffic === this.#polled?.path) return;
    clearTimeout(this.#timer);
    this.state.pause();
    this.#polled = runs ? { path: traffic } : null;
    this.#show();
    if (runs) this.#look(this.#polled);
  }

  async #look(polled) {
    let period = PERIOD;
    try {
      const answer = document.visibilityState === "visible" ? await this.#rest.get(polled.path) : null;
      if (polled !== this.#polled) return;
      if (answer) this.state.take(answer);
    } catch (error) {
      if (polled !== this.#polled) return;
      if (error instanceof Refused && error.status !== 401) this.state.pause();
      else this.#events.failed(error);
      period = SLOW;
    }
    this.#show();
    this.#timer = setTimeout(() => this.#look(polled), period);
  }

  #pick(robot) {
    this.state.picked = robot === this.state.picked ? null : robot;
    this.#show();
  }

  #heat(on) {
    this.layer.heat = on;
    this.#show();
  }

  #change(robot, change) {
    const order = this.#rest.post(`${this.#map}/traffic/robots/${encodeURIComponent(robot)}/${change}`, {});
    return this.#events.ask(order, change === "take_out" ? `${robot} is taken out of the traffic` : `${robot} is put back into the traffic`);
  }

  #show() {
    this.#panel.update(this.state, this.layer.heat);
    this.#events.changed();
  }
}
