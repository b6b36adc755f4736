/** Driving by hand: a socket that carries nothing else, so that no map or scan is before a command, and the clock of commands. */

import { bare } from "./messages.js";
import { addCardPart } from "./registry.js";
import { seconds, unique } from "./robot_link.js";
import { Rosbridge } from "./rosbridge.js";
import { mayDrive } from "./shared_robots.js";
import { TeleopDriver } from "./teleop_driver.js";
import { motionOfGamepads } from "./teleop_input.js";
import { TeleopPanel } from "./teleop_panel.js";
import { toast } from "./toasts.js";

const PERIOD = 50; // ms between two commands
const STATE = "ppaas_msgs/TeleopState";

export class Teleop {
  #urlOf;
  #panel;
  /** @type {import("./robot_link.js").RobotLink | null} */ #link = null;
  /** @type {TeleopDriver | null} */ #driver = null;
  /** @type {Rosbridge | null} */ #socket = null;
  #timer = 0;

  /** @param {(robot: string) => Promise<string>} urlOf where a robot's socket is */
  constructor(urlOf) {
    this.#urlOf = urlOf;
    this.#panel = new TeleopPanel({
      begin: () => this.#begin(),
      end: () => this.#end(),
      giveBack: () => this.#end("give back"),
      takeOver: () => this.#driver?.takeOver(),
      moved: () => this.#send(),
    });
    window.addEventListener("pagehide", () => this.#end());
    document.addEventListener("visibilitychange", () => document.hidden && this.#end());
    window.addEventListener("gamepaddisconnected", () => this.#send());
  }

  get element() {
    return this.#panel.element;
  }

  /** Show a robot; another one than before is not driven any more. @param {import("./robot_link.js").RobotLink | null} link @param {boolean} may */
  select(link, may) {
    if (this.#driver && (link?.robot.id !== this.#link?.robot.id || !may)) this.#end();
    this.#link = link;
    this.#panel.offer(may && Boolean(link?.connected));
    this.#show();
  }

  async #begin() {
    const link = this.#link;
    if (!link || this.#driver) return;
    const driver = (this.#driver = new TeleopDriver(unique()));
    this.#show();
    try {
      const url = await this.#urlOf(link.robot.id);
      if (this.#driver === driver) this.#connect(url, driver);
    } catch (error) {
      this.#lost(driver, error.message);
    }
  }

  /** @param {string} url @param {TeleopDriver} driver */
  #connect(url, driver) {
    const socket = new Rosbridge(url, {
      opened: () => {
        socket.subscribe("teleop_state", STATE, 0);
        this.#timer = setInterval(() => this.#send(), PERIOD);
        this.#send();
      },
      closed: (reason) => this.#lost(driver, reason || "the connection ended"),
      heard: (topic, message) => {
        if (bare(topic) === "teleop_state") driver.heard(message, seconds());
        this.#show();
      },
      told: (text) => toast(text, "bad"),
    });
    this.#socket = socket;
  }

  #send() {
    const driver = this.#driver;
    if (!driver || !this.#socket) return;
    const motion = this.#panel.motion() ?? motionOfGamepads(navigator.getGamepads?.() ?? []);
    const command = driver.command(motion, seconds(), this.#link?.state.heardAt ?? -Infinity);
    if (command) this.#socket.publish("teleop_cmd", command);
    this.#show();
  }

  /** @param {TeleopDriver} driver @param {string} reason */
  #lost(driver, reason) {
    if (this.#driver !== driver) return;
    toast(`Driving by hand has ended: ${reason}`, "bad");
    this.#end();
  }

  /** Drive no longer; the robot goes on to its goal only if it is given back. */
  #end(request = "leave") {
    const leaving = this.#driver?.leaving(seconds(), request);
    if (leaving) this.#socket?.publish("teleop_cmd", leaving);
    clearInterval(this.#timer);
    this.#socket?.close();
    this.#socket = this.#driver = null;
    this.#panel.release();
    this.#show();
  }

  #show() {
    const driver = this.#driver;
    const text = driver?.text(seconds(), this.#link?.state.heardAt ?? -Infinity) ?? "";
    this.#panel.show(driver, text);
  }
}

addCardPart(0, ({ rest }) => {
  const teleop = new Teleop((robot) => rest.socketUrl(robot));
  return { element: teleop.element, update: (link) => teleop.select(link, mayDrive(link?.robot)) };
});
