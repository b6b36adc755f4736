/** Recordings of all robots of the user, read robot by robot: the cloud lists them by robot. */

import { bytes, plural } from "../format.js";

const PERIOD = 30; // between two looks at all robots [s]
const AT_ONCE = 4; // robots that are read at once

/** Whether a recording is of a robot whose name has this text. @param {{robot: string}} recording @param {string} text */
export function matches({ robot }, text) {
  return robot.toLowerCase().includes(text.trim().toLowerCase());
}

/** How many recordings there are, and their size. @param {{size: number}[]} recordings */
export function sumOf(recordings) {
  return `${plural(recordings.length, "recording")}, ${bytes(recordings.reduce((sum, { size }) => sum + size, 0))}`;
}

export class RecordingList {
  /** Number of robots that the last look has read. */ done = 0;
  /** @type {Map<string, object[]>} by robot */ #found = new Map();
  #of;
  #readAt = -Infinity;
  #robots = "";

  /** @param {(robot: string) => Promise<object[]>} of lists the recordings of a robot */
  constructor(of) {
    this.#of = of;
  }

  /** All recordings, the newest first. @returns {{robot: string, id: string, size: number, finished: boolean}[]} */
  get recordings() {
    const all = [...this.#found].flatMap(([robot, found]) => found.map((one) => ({ ...one, robot })));
    return all.sort((a, b) => b.id.localeCompare(a.id) || a.robot.localeCompare(b.robot));
  }

  /** Read all at the next look. */
  forget() {
    this.#readAt = -Infinity;
  }

  /** Read the recordings, unless they were read a moment ago. @param {string[]} robots @param {number} now [s] @param {() => void} seen is called after each step */
  async read(robots, now, seen) {
    const named = robots.join("\n");
    if (now - this.#readAt < PERIOD && named === this.#robots) return;
    this.#readAt = now;
    this.#robots = named;
    this.#found = new Map([...this.#found].filter(([robot]) => robots.includes(robot)));
    this.done = 0;
    try {
      while (this.done < robots.length) {
        const some = robots.slice(this.done, this.done + AT_ONCE);
        const found = await Promise.all(some.map((robot) => this.#of(robot)));
        some.forEach((robot, i) => this.#found.set(robot, found[i]));
        this.done += some.length;
        seen();
      }
    } catch (error) {
      this.forget();
      throw error;
    }
  }
}
