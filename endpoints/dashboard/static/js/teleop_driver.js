/** A driver as the clone knows it: its commands, the states that it hears, and why it may not drive. No sockets or clocks. */

/** Longest time between two states of a driver, with what a busy browser adds [s]. */
const STATE_PERIOD = 0.2;
/** Round trips of which the middle one is shown. */
const TRIPS = 9;
/** States whose arrival is known. */
const STATES = 64;

const SAID = {
  ready: "Ready",
  driving: "Driving",
  slowed: "Slowed: something is near, or a limit holds here",
  blocked: "Stopped: something is in the way",
};

export class TeleopDriver {
  /** @type {any} the last state */ state = null;
  #id;
  #name;
  #number = 0;
  #heardAt = -Infinity;
  /** @type {{number: number, at: number}[]} states that came, oldest first */ #came = [];
  /** @type {Map<number, number>} when commands were sent, by number */ #sent = new Map();
  /** @type {number[]} round trips [s] */ #trips = [];
  #request = "drive";
  #wasDriver = false;
  #released = false;

  /** @param {string} id made up for this driver */
  constructor(id) {
    this.#id = id;
  }

  /** Whether it is the driver. */
  get drives() {
    return this.state?.id === this.#id;
  }

  /** Whether there is somebody to take over from, or an own turn that has lapsed. */
  get mayTakeOver() {
    return this.state !== null && !this.drives && this.state.mode !== "refused" && (this.#wasDriver || this.state.id !== "");
  }

  /** Round trip of a command [s]; null before the first. */
  get roundTrip() {
    return this.#trips.length ? [...this.#trips].sort((a, b) => a - b)[this.#trips.length >> 1] : null;
  }

  /** Take a state of the clone. @param {any} state @param {number} now seconds */
  heard(state, now) {
    this.state = state;
    this.#heardAt = now;
    this.#came = [...this.#came.slice(1 - STATES), { number: state.number, at: now }];
    if (!this.drives) return;
    this.#wasDriver = true;
    this.#request = "";
    const at = this.#sent.get(state.command);
    if (at === undefined) return;
    this.#trips = [...this.#trips.slice(1 - TRIPS), now - at];
    for (const number of this.#sent.keys()) if (number <= state.command) this.#sent.delete(number);
  }

  /** Become the driver in place of another. */
  takeOver() {
    this.#request = "take over";
    this.#wasDriver = false;
  }

  /**
   * The next command; a driver that lost its turn sends none.
   * @param {import("./teleop_input.js").Motion | null} motion null if the control is let go
   * @param {number} now seconds @param {number} poseAt when the pose that is shown came
   */
  command(motion, now, poseAt) {
    const lost = this.#wasDriver && !this.drives;
    if (lost || (this.#request === "drive" && this.state?.id) || this.state?.mode === "refused") return null;
    if (!motion) this.#released = true;
    const enable = motion !== null && this.drives && this.#released && !this.#stale(now, poseAt);
    if (motion && !enable) this.#released = false; // it has to let go first
    return this.#message(enable ? motion : null, now, poseAt);
  }

  /** The command by which it drives no longer. @param {number} now seconds @param {string} request "leave" or "give back" */
  leaving(now, request = "leave") {
    this.#request = request;
    return this.drives ? this.#message(null, now, -Infinity) : null;
  }

  #message(motion, now, poseAt) {
    const number = ++this.#number;
    this.#sent.set(number, now);
    if (this.#sent.size > STATES) this.#sent.delete(this.#sent.keys().next().value);
    const { max_linear: linear = 0, max_angular: angular = 0 } = this.state ?? {};
    return {
      id: this.#id,
      number,
      linear: (motion?.linear ?? 0) * linear,
      angular: (motion?.angular ?? 0) * angular,
      enable: motion !== null,
      echo: this.#came.at(-1)?.number ?? 0,
      held: this.#came.length ? now - this.#heardAt : 0,
      view: this.#came.findLast(({ at }) => at <= poseAt)?.number ?? 0,
      request: this.#request,
    };
  }

  #stale(now, poseAt) {
    return this.#stalls(now) || now - poseAt > this.state.view_timeout;
  }

  #stalls(now) {
    return now - this.#heardAt > this.state.command_timeout + STATE_PERIOD;
  }

  /** What to tell the driver. @param {number} now seconds @param {number} poseAt @returns {string} */
  text(now, poseAt) {
    const { state } = this;
    if (!state) return "Asking for the robot…";
    if (state.mode === "refused") return `It cannot be driven by hand: ${state.text}`;
    if (state.id && !this.drives) return `${state.driver || "Somebody else"} ${this.#wasDriver ? "has taken over" : "drives"}`;
    if (!this.drives) return this.#wasDriver ? "You drive no longer: nothing came from here for too long" : "Asking for the robot…";
    if (this.#stalls(now)) return "Locked: the link is stalled";
    if (now - poseAt > state.view_timeout) return "Locked: the position on the map is old";
    if (state.mode === "locked") return `Locked: ${state.text}. Let go, then press again`;
    return SAID[state.mode] ?? "";
  }
}
