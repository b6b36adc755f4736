/** Panel of a robot's card by which it is driven by hand: a pad for fingers and keys. */

import { make, say } from "./dom.js";
import { drives, motionOfKeys, motionOfTouch } from "./teleop_input.js";

const HELP = "Hold W, A, S, D or the arrow keys, drag in the pad, or hold a shoulder button of a gamepad.";

export class TeleopPanel {
  element = make("div", { className: "teleop" });
  /** Codes of the keys that are held. */ #keys = new Set();
  /** @type {{x: number, y: number} | null} where the pad is touched */ #touch = null;
  #orders;
  #begin;
  #end;
  #giveBack;
  #takeOver;
  #pad;
  #knob = make("span", { className: "teleop-knob", "aria-hidden": "true" });
  #text = make("p", { className: "teleop-text", role: "status" });
  #trip = make("p", { className: "teleop-trip" });

  /** @param {{begin: () => void, end: () => void, giveBack: () => void, takeOver: () => void, moved: () => void}} orders */
  constructor(orders) {
    this.#orders = orders;
    const begin = () => {
      orders.begin();
      this.#pad.focus();
    };
    this.#begin = make("button", { className: "button", type: "button", textContent: "Drive by hand", onclick: begin });
    this.#end = make("button", { className: "button stop", type: "button", textContent: "Stop driving", onclick: orders.end });
    const title = "Stop driving; the robot goes on to the goal that it had";
    this.#giveBack = make("button", { className: "button", type: "button", textContent: "Give back", title, onclick: orders.giveBack });
    const take = () => {
      orders.takeOver();
      this.#pad.focus();
    };
    this.#takeOver = make("button", { className: "button", type: "button", textContent: "Take over", onclick: take });
    this.#pad = make("div", { className: "teleop-pad", tabIndex: 0, role: "application", "aria-label": `Pad to drive the robot. ${HELP}` }, this.#knob);
    this.#listen();
    this.element.append(this.#begin, this.#pad, this.#text, this.#trip, make("div", { className: "actions" }, this.#takeOver, this.#giveBack, this.#end));
  }

  #listen() {
    const pad = this.#pad;
    pad.addEventListener("keydown", (event) => this.#press(event));
    pad.addEventListener("keyup", ({ code }) => this.#keys.delete(code) && this.#orders.moved());
    // Of a window that is left, no key or finger is heard any more.
    for (const name of ["blur", "contextmenu"]) pad.addEventListener(name, () => this.#letGo());
    window.addEventListener("blur", () => this.#letGo());
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      pad.focus();
      this.#move(event);
      this.#orders.moved();
    });
    pad.addEventListener("pointermove", (event) => this.#touch && this.#move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) pad.addEventListener(name, () => this.#letGo());
  }

  #press(event) {
    if (!drives(event.code) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault(); // else the page scrolls
    if (event.repeat || this.#keys.has(event.code)) return;
    this.#keys.add(event.code);
    this.#orders.moved();
  }

  #move({ clientX, clientY }) {
    this.#touch = { x: clientX, y: clientY };
  }

  #letGo() {
    const held = this.motion() !== null;
    this.release();
    if (held) this.#orders.moved();
  }

  /** Let go of all keys and the pad. */
  release() {
    this.#keys.clear();
    this.#touch = null;
  }

  /** @returns {import("./teleop_input.js").Motion | null} */
  motion() {
    return motionOfKeys(this.#keys) ?? motionOfTouch(this.#touch, this.#pad.getBoundingClientRect());
  }

  /** Offer to drive the robot, or not. @param {boolean} may */
  offer(may) {
    this.#begin.disabled = !may;
  }

  /** @param {import("./teleop_driver.js").TeleopDriver | null} driver @param {string} text */
  show(driver, text) {
    this.#begin.hidden = driver !== null;
    for (const part of [this.#pad, this.#text, this.#trip, this.#end]) part.hidden = !driver;
    this.#takeOver.hidden = !driver?.mayTakeOver;
    this.#giveBack.hidden = !driver?.drives;
    if (!driver) return;
    say(this.#text, text);
    this.#pad.dataset.mode = driver.drives ? driver.state.mode : "free";
    const trip = driver.roundTrip;
    say(this.#trip, trip === null ? "" : `Round trip ${Math.round(trip * 1000)} ms`);
    const { linear = 0, angular = 0 } = this.motion() ?? {};
    this.#knob.style.transform = `translate(${-40 * angular}px, ${-40 * linear}px)`;
  }
}
