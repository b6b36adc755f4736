/** What this page saw of robots since it was opened: the timeline shows it beside the audit log. */

const MOST = 500;

/** @typedef {{number: number, time: number, robot: string, text: string, bad: boolean}} Entry */

export class Journal {
  /** @type {Entry[]} newest first */ entries = [];
  #number = 0;

  /** @param {number} time [s since the epoch] @param {string} robot @param {string} text @param {boolean} bad */
  add(time, robot, text, bad = false) {
    this.#number += 1;
    this.entries = [{ number: this.#number, time, robot, text, bad }, ...this.entries.slice(0, MOST - 1)];
  }
}
