/** The list of the robots of a map. */

import { byId, make, say, show } from "./dom.js";
import { number, plural } from "./format.js";

/** How a robot is, in words. */
export const PRESENCE = { offline: "offline", starting: "starting", silent: "no signal", online: "online" };

/** What a robot does with a goal that it does not drive to, by its state in actionlib. */
const BESIDE_DRIVING = { 0: "Its goal waits to begin", 6: "Stopping", 7: "Stopping" };

/** @param {string} text */
function sentence(text) {
  return text[0].toUpperCase() + text.slice(1);
}

/** Return the state of a robot in words. @param {import("./robot_link.js").RobotLink} link */
export function doing({ presence, waits, connected, held, state, listed, robot }) {
  if (listed && presence !== "offline") return robot.error || robot.task || PRESENCE[presence];
  if (presence === "offline") return waits ? "Not connected; its container waits for it" : "Not connected";
  if (presence === "starting") return "Its container starts";
  if (presence === "silent") return connected ? "No pose of it comes" : "This page has no connection to it";
  if (robot?.stopped) return sentence(robot.stopped);
  if (state.exploration) return exploring(state.exploration);
  if (!state.goal) return "Ready";
  if (!state.goal.active) return state.goal.text || `Goal: ${state.goal.word}`;
  if (state.goal.code in BESIDE_DRIVING) return BESIDE_DRIVING[state.goal.code];
  if (held) return held;
  const left = state.remaining;
  return left === null ? "Driving" : `Driving, ${number(left)} m to go`;
}

/** @param {import("./messages.js").Exploration} exploration */
function exploring({ frontiers, area, text }) {
  const left = `${plural(frontiers, "frontier")} left, ${number(area, 0)} m² known`;
  return text ? `Exploring, ${left}: ${text}` : `Exploring, ${left}`;
}

/** @param {HTMLElement} element @param {import("./robot_link.js").RobotLink} link */
export function showPresence(element, link) {
  element.dataset.presence = link.presence;
  say(element, PRESENCE[link.presence]);
}

export class RobotList {
  #fleet;
  #colourOf;
  #picked;

  /**
   * @param {import("./fleet.js").Fleet} fleet
   * @param {(link: import("./robot_link.js").RobotLink) => string} colourOf
   * @param {(id: string) => void} picked
   */
  constructor(fleet, colourOf, picked) {
    this.#fleet = fleet;
    this.#colourOf = colourOf;
    this.#picked = picked;
  }

  /** @param {string | null} map the map that is shown */
  update(map) {
    const links = this.#fleet.links;
    const fill = (item, link) => this.#fill(item, link);
    show(byId("robots"), links, ({ robot }) => robot.id, (link) => this.#create(link), fill);
    say(byId("robot-count"), links.length ? String(links.length) : "");
    const empty = byId("no-robots");
    empty.hidden = links.length > 0 || map === null;
    if (!empty.hidden && empty.dataset.map !== map) {
      empty.dataset.map = map;
      empty.replaceChildren(
        `No robot stands in ${map} yet. Put one there, and a simulated one drives it:`,
        make("code", { textContent: "ppaas robot put tb1 docs/examples/tb1.json" }),
        make("code", { textContent: "ppaas simulate docs/examples/tb1.json" }),
      );
    }
  }

  #create(link) {
    const { id } = link.robot;
    return make("li", {}, make(
      "button",
      { className: "robot", type: "button", onclick: () => this.#picked(id) },
      make("span", { className: "swatch" }),
      make("span", { className: "name", textContent: id, title: id }),
      make("span", { className: "presence" }),
      make("span", { className: "doing" }),
    ));
  }

  #fill(item, link) {
    const button = item.firstChild;
    const [swatch, , presence, what] = button.children;
    swatch.style.background = this.#colourOf(link);
    button.setAttribute("aria-pressed", String(this.#fleet.selected === link));
    showPresence(presence, link);
    say(what, doing(link));
  }
}
