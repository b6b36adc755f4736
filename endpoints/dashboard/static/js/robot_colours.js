/** Colours of robots: a robot keeps its colour while the page is open, whichever robots come and go. */

export class RobotColours {
  /** @type {Map<string, number>} by id */ #given = new Map();
  #count;

  /** @param {number} count of colours */
  constructor(count) {
    this.#count = count;
  }

  /** Give each robot without a colour one that the fewest of these robots have. @param {string[]} ids */
  give(ids) {
    const uses = Array(this.#count).fill(0);
    for (const id of ids) if (this.#given.has(id)) uses[this.#given.get(id)] += 1;
    for (const id of ids.filter((one) => !this.#given.has(one))) {
      const colour = uses.indexOf(Math.min(...uses));
      this.#given.set(id, colour);
      uses[colour] += 1;
    }
  }

  /** @param {string} id of a robot that has a colour @returns {number} */
  of(id) {
    return this.#given.get(id);
  }
}
