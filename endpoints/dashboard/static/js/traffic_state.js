/** Traffic of the shown map: the last answer of the cloud, goals reached, and where robots have waited. */

import { duration } from "./format.js";

const MINUTE = 60; // s
const HOUR = 3600;

/**
 * @typedef {{robot: string, state: string, pose: [number, number, number], way: [number, number][], waits_for: string,
 *            goal: [number, number] | null, waited: number}} TrafficRobot
 * @typedef {{at: number, spacing: number, robots: TrafficRobot[], goals: number}} Answer
 * @typedef {{x: number, y: number, size: number, seconds: number}} Wait time for which robots waited in a cell [s]
 */

/** Whether a traffic node of a user runs for a map. @param {object[]} containers @param {string} user @param {string | null} map */
export function hasTraffic(containers, user, map) {
  return containers.some((one) => one.kind === "traffic" && one.user === user && one.map.id === map && one.state === "ready");
}

/** The cell that a robot stands in: the nearest one that it holds. @param {TrafficRobot} robot @returns {[number, number]} */
export function cellOf({ way, pose: [x, y] }) {
  const away = ([a, b]) => Math.hypot(a - x, b - y);
  return way.reduce((best, cell) => (best && away(best) <= away(cell) ? best : cell), null) ?? [x, y];
}

export class TrafficState {
  /** What the cloud answered; null while no robot takes part. @type {Answer | null} */ answer = null;
  /** Id of the robot that the user has picked. @type {string | null} */ picked = null;
  /** @type {Answer | null} */ #last = null;
  /** Time of the first answer [s]. @type {number | null} */ #began = null;
  /** Goals reached between two answers. @type {{from: number, to: number, count: number}[]} */ #reached = [];
  /** @type {Map<string, Wait>} */ #waits = new Map();

  /** Take an answer of the cloud. @param {Answer} answer */
  take(answer) {
    const last = this.#last;
    this.#began ??= answer.at;
    this.answer = this.#last = answer;
    if (last && answer.at > last.at) {
      this.#countGoals(last, answer);
      this.#addWaits(last, answer);
    }
    if (!answer.robots.some(({ robot }) => robot === this.picked)) this.picked = null;
  }

  /** Show nothing while no robot takes part; what was counted is kept. */
  pause() {
    this.answer = null;
  }

  /** Forget everything, because another map is shown. */
  clear() {
    this.answer = this.#last = this.#began = this.picked = null;
    this.#reached = [];
    this.#waits.clear();
  }

  /** Why a robot stands in the traffic now, in words; empty if it does not. @param {string} id */
  heldBy(id) {
    const robot = this.answer?.robots.find((one) => one.robot === id && one.state === "waiting");
    return robot ? `Waits${robot.waits_for && ` for ${robot.waits_for}`}, ${duration(robot.waited)}` : "";
  }

  /** Goals reached in the last minute, and in the last hour or since the page has looked: that time is `seconds`. */
  get throughput() {
    const seconds = this.#last ? Math.min(this.#last.at - this.#began, HOUR) : 0;
    return { minute: this.#goalsIn(MINUTE), hour: this.#goalsIn(HOUR), seconds };
  }

  /** Where robots have waited since the page has looked. @returns {Wait[]} */
  get waits() {
    return [...this.#waits.values()];
  }

  /** The longest time of `waits` [s]; 0 if nobody has waited. */
  get longest() {
    return Math.max(0, ...this.waits.map(({ seconds }) => seconds));
  }

  /** A node that has begun anew counts from 0. */
  #countGoals(last, { at, goals }) {
    const count = goals < last.goals ? goals : goals - last.goals;
    if (count) this.#reached.push({ from: last.at, to: at, count });
    this.#reached = this.#reached.filter(({ to }) => to > at - HOUR);
  }

  /** Of a longer time between two answers, as while the page was hidden, the part within counts. */
  #goalsIn(seconds) {
    const begin = (this.#last?.at ?? 0) - seconds;
    const share = ({ from, to }) => Math.max(0, to - Math.max(from, begin)) / (to - from);
    return Math.round(this.#reached.reduce((sum, each) => sum + each.count * share(each), 0));
  }

  #addWaits(last, { at, spacing, robots }) {
    for (const robot of robots.filter(({ state }) => state === "waiting")) {
      const [x, y] = cellOf(robot);
      const key = `${x.toFixed(2)} ${y.toFixed(2)}`;
      const before = this.#waits.get(key)?.seconds ?? 0;
      this.#waits.set(key, { x, y, size: spacing, seconds: before + Math.min(at - last.at, robot.waited) });
    }
  }
}
