/** People on the shown map: the last answer of the cloud, and where each person was before. */

/** Time for which a tail shows where a person was [s]. */
export const TAIL = 20;
/** Least distance between two points of a tail [m]. */
const APART = 0.05;
const NOBODY = { coordinator: "none", reason: "", count: 0, rule: "", rules: [], people: [], following: [], robots: [] };

/** What a person is called. @param {{id: number, name: string}} person */
export function nameOf({ id, name }) {
  return name || `Person ${id}`;
}

/** The id of the robot that sends a tf frame ROBOT/TORSO. @param {string} frame */
export function robotOf(frame) {
  return frame.replace(/\/[^/]*$/, "");
}

export class PeopleState {
  answer = NOBODY;
  /** @type {{rule: string, targets: number[], followed_at_once: number, history: boolean, zones: object[]} | null} */
  settings = null;
  /** Id of the person that the user has picked. @type {number | null} */ picked = null;
  /** Tails by id: time and place, oldest first. @type {Map<number, {at: number, x: number, y: number}[]>} */
  #tails = new Map();

  /** Take an answer of the cloud. @param {typeof NOBODY & {at: number | null}} answer */
  take(answer) {
    this.answer = answer;
    const ids = new Set(answer.people.map(({ id }) => id));
    for (const id of this.#tails.keys()) if (!ids.has(id)) this.#tails.delete(id);
    for (const { id, position: [x, y] } of answer.people) this.#extend(id, { at: answer.at ?? 0, x, y });
    if (!ids.has(this.picked)) this.picked = null;
  }

  /** Forget everything, because another map is shown. */
  clear() {
    this.take(NOBODY);
    this.settings = null;
  }

  /** Whether robots of the user track people on the map. */
  get active() {
    return this.answer.coordinator !== "none";
  }

  /** Where a person was: x, y one after the other, oldest first. @param {number} id @returns {number[]} */
  tail(id) {
    return (this.#tails.get(id) ?? []).flatMap(({ x, y }) => [x, y]);
  }

  /** The robot that follows a person, and why. @param {number} id */
  order(id) {
    return this.answer.following.find(({ person }) => person === id) ?? null;
  }

  /** Place of a robot, or null if it has not reported one. @param {string} id @returns {{x: number, y: number} | null} */
  robot(id) {
    const place = this.answer.robots.find(({ robot }) => robot === id)?.position;
    return place ? { x: place[0], y: place[1] } : null;
  }

  /** The person at a point, or the nearest within reach. @param {{x: number, y: number}} point @param {number} reach [m] */
  at(point, reach) {
    const near = this.answer.people
      .map((person) => ({ person, away: Math.hypot(person.position[0] - point.x, person.position[1] - point.y) }))
      .filter(({ away }) => away <= reach)
      .sort((a, b) => a.away - b.away);
    return near[0]?.person ?? null;
  }

  /** People to follow by name if one more or one less is to be followed. @param {number} id @returns {number[]} */
  targetsWith(id) {
    const known = new Set(this.answer.people.map((person) => person.id));
    const targets = this.isTarget(id) ? this.settings.targets.filter((target) => target !== id) : [...this.#targets, id];
    return targets.filter((target) => known.has(target));
  }

  /** Whether the user wants a person followed. @param {number} id */
  isTarget(id) {
    return this.#targets.includes(id);
  }

  get #targets() {
    return this.settings?.rule === "named" ? this.settings.targets : [];
  }

  #extend(id, point) {
    const tail = this.#tails.get(id) ?? [];
    const last = tail.at(-1);
    if (!last || Math.hypot(point.x - last.x, point.y - last.y) >= APART) tail.push(point);
    this.#tails.set(id, tail.filter(({ at }) => at >= point.at - TAIL));
  }
}
