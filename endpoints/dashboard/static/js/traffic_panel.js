/** Panel of the traffic on the shown map: what each robot does and waits for, goals reached, and who is taken out. */

import { byId, make, say, show } from "./dom.js";
import { duration, number, plural } from "./format.js";

const PRESENCES = { driving: "online", free: "online", waiting: "silent", stopped: "silent", stray: "silent", by_hand: "online", held: "silent", docking: "online", docked: "online", silent: "silent", no_cells: "silent" };
const NOTES = {
  free: "Drives freely: it is alone",
  stopped: "Does not get on: others are planned around it",
  stray: "Has left its way: it stands until it is led back",
  by_hand: "Is driven by hand: others are planned around it",
  held: "Is stopped: others are planned around it",
  docking: "Docks or undocks: others keep out of its way",
  docked: "Stands at a dock: others are planned around it",
  silent: "Says nothing: what it holds is kept for it",
  out: "Taken out: others drive where it stood",
};
const HOUR = 3600; // s

/** What a robot does, in words. @param {import("./traffic_state.js").TrafficRobot} robot */
export function doing({ state, waits_for: why, waited, goal, way }) {
  const parts = [];
  if (NOTES[state]) parts.push(NOTES[state]);
  if (state === "no_cells") parts.push(`there are no cells for it: ${why}`);
  else if (why) parts.push(`waits for ${why}, ${duration(waited)}`);
  if (goal) parts.push(`goal ${goal.map((part) => number(part)).join(", ")}`);
  if (way.length) parts.push(`holds ${plural(way.length, "cell")}`);
  const text = parts.join("; ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** Goals reached, in words. @param {{minute: number, hour: number, seconds: number}} throughput */
export function reached({ minute, hour, seconds }) {
  const inMinute = `${plural(minute, "goal")} reached in the last minute`;
  return seconds <= 60 ? inMinute : `${inMinute}, ${hour} in the last ${seconds >= HOUR ? "hour" : duration(seconds)}`;
}

export class TrafficPanel {
  #panel = byId("panel-traffic");
  #heat = byId("traffic-heat");
  #orders;

  /**
   * @param {{pick: (robot: string) => void, heat: (on: boolean) => void, change: (robot: string, change: string) => Promise<void>,
   *          colourOf: (robot: string) => string, mayChange: (robot: string) => boolean}} orders
   */
  constructor(orders) {
    this.#orders = orders;
    this.#heat.onclick = () => orders.heat(this.#heat.getAttribute("aria-pressed") !== "true");
  }

  /** @param {import("./traffic_state.js").TrafficState} state @param {boolean} heat whether it is shown where robots have waited */
  update(state, heat) {
    this.#panel.hidden = !state.answer;
    if (this.#panel.hidden) return;
    const { robots } = state.answer;
    say(byId("traffic-count"), String(robots.length));
    say(byId("traffic-note"), reached(state.throughput));
    this.#heat.setAttribute("aria-pressed", String(heat));
    byId("traffic-legend").hidden = !heat || !state.longest;
    say(byId("traffic-longest"), duration(state.longest));
    show(byId("traffic"), robots, ({ robot }) => robot, (robot) => this.#create(robot), (item, robot) => this.#fill(item, robot, state));
  }

  #create({ robot }) {
    const head = make("button", { className: "robot", type: "button", onclick: () => this.#orders.pick(robot) },
      make("span", { className: "swatch" }), make("span", { className: "name", textContent: robot, title: robot }),
      make("span", { className: "presence" }), make("span", { className: "doing" }));
    const change = make("button", { className: "button", type: "button" });
    return make("li", {}, head, make("div", { className: "person-actions" }, change));
  }

  #fill(item, robot, state) {
    const [head, more] = item.children;
    const [swatch, , presence, what] = head.children;
    swatch.style.background = this.#orders.colourOf(robot.robot);
    presence.dataset.presence = PRESENCES[robot.state] ?? "offline";
    say(presence, robot.state.replace("_", " "));
    say(what, doing(robot));
    what.title = what.textContent;
    head.setAttribute("aria-pressed", String(state.picked === robot.robot));
    more.hidden = state.picked !== robot.robot || !this.#orders.mayChange(robot.robot);
    const isOut = robot.state === "out";
    say(more.firstChild, isOut ? "Put back" : "Take out");
    more.firstChild.onclick = () => this.#change(robot.robot, isOut);
  }

  #change(robot, isOut) {
    if (isOut) this.#orders.change(robot, "put_back");
    else if (confirm(`Take ${robot} out of the traffic? See to it that it is out of the way: others will drive where it stands.`)) {
      this.#orders.change(robot, "take_out");
    }
  }
}
