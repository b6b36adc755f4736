/** Dialog with the recordings of the selected robot, and with the last minutes that its robot file keeps. */

import { make, say, show } from "./dom.js";
import { bytes, plural } from "./format.js";
import { Poller } from "./poller.js";
import { addCardPart } from "./registry.js";
import { refused } from "./rest.js";
import { mayDrive } from "./shared_robots.js";

const RING = "ring"; // in place of the id of a recording
const SECONDS = 3600; // after which a recording ends by itself, the most that the cloud allows
const ID = /^(\d{4})(\d\d)(\d\d)T(\d\d)(\d\d)(\d\d)Z(?:-(\d+))?$/;

/** Begin of a recording, from its id. @param {string} id */
export function titleOf(id) {
  const [, year, month, day, hour, minute, second, part] = ID.exec(id) ?? [];
  if (!year) return id;
  return `${year}-${month}-${day} ${hour}:${minute}:${second} UTC${part ? `, part ${part}` : ""}`;
}

/** Size of a recording, and whether it is complete. @param {{id: string, size: number, finished: boolean}} one @param {string} current */
export function noteOf({ id, size, finished }, current) {
  if (finished) return bytes(size);
  return `${bytes(size)}, ${id === current ? "in progress" : "not complete"}`;
}

/** State of the recorder of a robot, in words. @param {object} recorder answer of the cloud */
export function stateOf({ recording, left, ring_minutes: ring, lost, problem }) {
  const parts = [recording ? `Recording, ends by itself in ${plural(Math.ceil(left / 60), "minute")}` : "Not recording"];
  if (ring) parts.push(`the ring keeps ${plural(ring, "minute")}`);
  if (recording && lost) parts.push(`${plural(lost, "message")} lost`);
  return parts.join(", ") + (problem && `: ${problem}`);
}

/** Limits of the user with the recordings of a robot, in words; empty without any. @param {{id: string, role: string}} robot */
export function limitsOf({ id, role }) {
  if (role === "administer") return "";
  return mayDrive({ role }) ? `You may not delete recordings of ${id}` : `You may fetch recordings of ${id}, not start, stop or delete them`;
}

/** Name of the file of a recording. @param {string} robot @param {string} id */
export function fileOf(robot, id) {
  return `${robot.replaceAll(":", "-")}-${id}.mcap`;
}

/** Save a file that was fetched. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const url = URL.createObjectURL(blob);
  make("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000); // the browser may ask where to first
}

const button = (textContent, onclick) => make("button", { className: "button", type: "button", textContent, onclick });

export class RecordingsDialog {
  #rest;
  #robot = null;
  #current = null; // id of the recording in progress; null if the recorder does not answer
  #busy = false;
  #title = make("h2", { id: "recordings-title" });
  #state = make("p", { className: "muted", role: "status" });
  #limits = make("p", { className: "muted" });
  #error = make("p", { className: "error", role: "alert" });
  #toggle = button("Start recording", () => this.#startOrStop());
  #minutes = make("input", { type: "number", min: 1, max: 60, step: 1, inputMode: "numeric", placeholder: "all" });
  #ring = make("form", { className: "ring-form", "aria-label": "Download the last minutes" });
  #list = make("ul", { className: "list" });
  #poller = new Poller(() => this.#poll(), { well: () => {}, failed: (error) => say(this.#error, error.message) });

  /** The button that opens the dialog, which asks the cloud only while it is open. */
  opener = make("button", { className: "link", type: "button", textContent: "Recordings", "aria-haspopup": "dialog", onclick: () => this.#open() });
  element = make("dialog", { className: "recordings", "aria-labelledby": "recordings-title" });

  /** @param {import("./rest.js").Rest} rest */
  constructor(rest) {
    this.#rest = rest;
    this.#ring.append(make("label", {}, "Last minutes", this.#minutes), make("button", { className: "button", textContent: "Download" }));
    this.#ring.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#download(RING, this.#minutes.value && `?minutes=${this.#minutes.value}`);
    });
    const head = make("div", { className: "head" }, this.#title, button("Close", () => this.element.close()));
    this.element.append(head, this.#state, this.#limits, this.#error, this.#toggle, this.#ring, this.#list);
    document.body.append(this.element);
  }

  /** @param {{id: string, role: string} | null} robot the selected robot, as the cloud listed it last */
  select(robot) {
    if (robot?.id !== this.#robot?.id) this.element.close();
    this.#robot = robot;
    if (this.element.open) this.#permit();
  }

  #open() {
    say(this.#title, `Recordings of ${this.#robot.id}`);
    say(this.#error, "");
    this.#show({ recorder: null, unknown: "Asking the robot…", ring: false, recordings: [] });
    this.element.showModal();
    this.#poller.now();
  }

  #path(...parts) {
    return [this.#robot.id, ...parts].reduce((path, part) => `${path}/${encodeURIComponent(part)}`, "v1/robots");
  }

  async #poll() {
    const robot = this.#robot;
    if (!this.element.open) return;
    const absent = ({ message }) => ({ recorder: null, unknown: message });
    const [recordings, asked] = await Promise.all([
      this.#rest.list(this.#path("recordings")),
      this.#rest.get(this.#path("recorder")).then((recorder) => ({ recorder }), refused(503, absent)),
    ]);
    const ring = asked.recorder ? asked.recorder.ring_minutes > 0 : await this.#hasRing();
    if (this.element.open && robot?.id === this.#robot?.id) this.#show({ recordings, ring, ...asked }); // else another one was selected
  }

  /** Ask if a robot that is not connected has left a ring. */
  #hasRing() {
    return this.#rest.get(this.#path("recordings", RING)).then(() => true, refused(404, () => false));
  }

  #show({ recordings, ring, recorder, unknown }) {
    this.#current = recorder && recorder.recording;
    say(this.#state, recorder ? stateOf(recorder) : unknown);
    say(this.#toggle, this.#current ? "Stop recording" : "Start recording");
    this.#ring.hidden = !ring;
    show(this.#list, recordings, ({ id }) => id, ({ id }) => this.#create(id), (item, one) => say(item.children[1], noteOf(one, this.#current)));
    this.#permit();
  }

  /** Disable what the role of the user, or an order under way, does not permit. */
  #permit() {
    say(this.#limits, limitsOf(this.#robot));
    this.#toggle.disabled = this.#busy || this.#current === null || !mayDrive(this.#robot);
    for (const one of this.element.querySelectorAll(".download, .ring-form .button")) one.disabled = this.#busy;
    for (const one of this.element.querySelectorAll(".delete")) one.disabled = this.#busy || this.#robot.role !== "administer";
  }

  #create(id) {
    const actions = [["Download", () => this.#download(id)], ["Delete", () => this.#delete(id)]].map(([text, order]) => {
      const one = button(text, order);
      one.classList.add(text.toLowerCase());
      one.setAttribute("aria-label", `${text} ${titleOf(id)}`);
      return one;
    });
    return make("li", { className: "review" }, make("span", { className: "name", textContent: titleOf(id) }), make("span", { className: "muted" }), make("div", { className: "actions" }, ...actions));
  }

  #startOrStop() {
    const order = this.#current ? [this.#path("recordings", this.#current, "stop"), {}] : [this.#path("recordings"), { seconds: SECONDS }];
    return this.#tell(() => this.#rest.post(...order));
  }

  #download(id, query = "") {
    const name = fileOf(this.#robot.id, id);
    return this.#tell(async () => save(await this.#rest.blob(`${this.#path("recordings", id, "file")}${query}`), name));
  }

  async #delete(id) {
    if (confirm(`Delete the recording of ${titleOf(id)}?`)) await this.#tell(() => this.#rest.delete(this.#path("recordings", id)));
  }

  /** Carry out an order of the user; say why if it fails. @param {() => Promise<unknown>} order */
  async #tell(order) {
    this.#busy = true;
    say(this.#error, "");
    this.#permit();
    try {
      await order();
    } catch (error) {
      say(this.#error, error.message);
    }
    this.#busy = false;
    this.#poller.now();
  }
}

addCardPart(3, ({ rest }) => {
  const dialog = new RecordingsDialog(rest);
  return { element: dialog.opener, update: (link) => dialog.select(link?.robot ?? null) };
});
