/** Stops: the button that stops all robots, what is stopped and by whom, and the stop of the selected robot. */

import { byId, make, say, show } from "./dom.js";
import { Poller } from "./poller.js";
import { addCardPart } from "./registry.js";
import { mayDrive } from "./shared_robots.js";
import { appliesTo, inWords, releasePath } from "./stops_state.js";
import { toast } from "./toasts.js";

export class Stops {
  /** Button of the card. */ button = make("button", { className: "button stop", type: "button", onclick: () => this.#press() });
  #rest;
  #cloud;
  /** @type {import("./stops_state.js").Stop[]} */ #stops = [];
  #robot = null;
  #releasing = null;
  #poller = new Poller(() => this.#poll(), { well: () => undefined, failed: () => undefined });

  /** @param {import("./rest.js").Rest} rest @param {import("./cloud_state.js").CloudState} cloud */
  constructor(rest, cloud) {
    this.#rest = rest;
    this.#cloud = cloud;
    byId("stop-all").addEventListener("click", () => this.#stop("v1/stop", "All robots are stopped"));
    byId("release-yes").addEventListener("click", () => this.#release());
    byId("release-no").addEventListener("click", () => byId("release").close());
    this.#poller.now();
  }

  /** Show the stop of a robot in the card. @param {{id: string, user: string, map: string, role: string} | null} robot */
  select(robot) {
    this.#robot = robot;
    this.button.hidden = !mayDrive(robot);
    say(this.button, this.#stopOfRobot ? "Release…" : "Stop");
  }

  /** The stop of the selected robot; its own before those of many. */
  get #stopOfRobot() {
    const stops = this.#robot ? this.#stops.filter((stop) => appliesTo(stop, this.#robot)) : [];
    return stops.find(({ scope }) => scope === "robot") ?? stops[0] ?? null;
  }

  async #poll() {
    this.#stops = await this.#rest.list("v1/stops");
    this.#draw();
  }

  #draw() {
    byId("stopped").hidden = !this.#stops.length;
    show(byId("stopped"), this.#stops, ({ user, scope, name }) => `${user}/${scope}/${name}`, (stop) => this.#create(stop), (item, stop) => say(item.firstChild, this.#words(stop)));
    this.select(this.#robot);
  }

  #words(stop) {
    return inWords(stop, this.#cloud.me?.id ?? stop.user); // the first look at stops may come before the user's name
  }

  #create(stop) {
    const button = make("button", { className: "button", type: "button", textContent: "Release…", onclick: () => this.#ask(stop) });
    return make("div", {}, make("span"), button);
  }

  #press() {
    const stop = this.#stopOfRobot;
    if (stop) this.#ask(stop);
    else this.#stop(`v1/robots/${encodeURIComponent(this.#robot.id)}/stop`, `${this.#robot.id} is stopped`);
  }

  /** Stop without a question: a second press does no harm. */
  async #stop(path, done) {
    try {
      const { unconfirmed } = await this.#rest.post(path, {});
      if (unconfirmed.length) toast(`Not confirmed yet: ${unconfirmed.join(", ")}`, "bad");
      else toast(done, "good");
    } catch (error) {
      toast(`NOT STOPPED: ${error.message}`, "bad");
    }
    this.#poller.now();
  }

  #ask(stop) {
    this.#releasing = stop;
    say(byId("release-text"), `${this.#words(stop)}. Robots drive on to their goals at once.`);
    byId("release").showModal();
  }

  async #release() {
    byId("release").close();
    try {
      const { left } = await this.#rest.post(releasePath(this.#releasing, this.#cloud.me?.id), {});
      toast(left.length ? `Released; ${left.length === 1 ? "another stop is" : "other stops are"} in force` : "Released", "good");
    } catch (error) {
      toast(error.message, "bad");
    }
    this.#poller.now();
  }
}

addCardPart(4, ({ rest, cloud }) => {
  const stops = new Stops(rest, cloud);
  return { element: stops.button, update: (link) => stops.select(link?.robot ?? null) };
});
