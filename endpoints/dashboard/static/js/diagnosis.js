/** Diagnosis of the selected robot: what it sends, what is missing, and what to do, in the words of `ppaas doctor`. */

import { make, say, show } from "./dom.js";
import { plural } from "./format.js";
import { Poller } from "./poller.js";
import { addCardPart } from "./registry.js";

const WORDS = { error: "Error", warn: "Warning", ok: "Note" };
const SECONDS = 2; // for which the robot is watched before the first answer
const TITLE = "What is wrong?";
const UNSEEN = "The cloud finds nothing wrong, but no pose of the robot comes to this page";

/** Rate and age of a topic, in words. @param {object} topic */
export function arrivalOf({ rate, silence, refused }) {
  if (silence === null) return "never came";
  if (silence > 2) return `stopped ${Math.round(silence)} s ago`;
  return `${rate.toFixed(rate < 9.5 ? 1 : 0)} Hz${refused ? `, ${refused} refused` : ""}`;
}

/** Number of errors and warnings, in words. @param {object[]} findings @param {boolean} silent whether no pose of the robot comes to this page */
export function summaryOf(findings, silent) {
  const count = (level) => findings.filter((each) => each.level === level).length;
  const parts = [["error", count("error")], ["warning", count("warn")]].filter(([, number]) => number);
  return parts.map(([word, number]) => plural(number, word)).join(", ") || (silent ? UNSEEN : "All is well");
}

export class DiagnosisPanel {
  #robot = null;
  #silent = false;
  #read;
  #note = make("p", { className: "muted", role: "status" });
  #findings = make("ul", { className: "findings" });
  #topics = make("ul", { className: "topics" });
  #poller = new Poller(() => this.#poll(), { well: () => {}, failed: (error) => say(this.#note, error.message) });

  /** The panel; it asks the cloud only while it is open. */
  element = make("details", { className: "go diagnosis" });

  /** @param {(robot: string, seconds: number) => Promise<object>} read the diagnosis of a robot */
  constructor(read) {
    this.#read = read;
    this.element.append(make("summary", { textContent: TITLE }), this.#note, this.#findings, this.#topics);
    this.element.addEventListener("toggle", () => this.#poller.now());
  }

  /** @param {string | null} robot the selected robot @param {boolean} silent whether no pose of it comes to this page */
  select(robot, silent) {
    this.#silent = silent;
    if (robot === this.#robot) return;
    this.#robot = robot;
    this.#show({ findings: [], topics: [] }, "");
    this.#poller.now();
  }

  async #poll() {
    const robot = this.#robot;
    if (robot === null || !this.element.open) return;
    if (!this.#findings.children.length) say(this.#note, "Watching the robot…");
    const diagnosis = await this.#read(robot, SECONDS);
    if (robot === this.#robot) this.#show(diagnosis, summaryOf(diagnosis.findings, this.#silent)); // else another one was selected
  }

  #show({ findings, topics, connected }, summary) {
    say(this.#note, summary);
    show(this.#findings, findings, ({ kind, topic, text }) => `${kind} ${topic} ${text}`, create, fill);
    show(this.#topics, connected ? topics : [], ({ name }) => name, () => make("li", {}, make("code"), make("span")), fillTopic);
  }
}

function create() {
  return make("li", { className: "finding" }, make("p", { className: "text" }), make("p", { className: "muted" }));
}

function fill(item, { level, text, advice }) {
  item.dataset.level = level;
  say(item.children[0], `${WORDS[level]}: ${text}`);
  say(item.children[1], advice);
}

function fillTopic(item, topic) {
  say(item.children[0], topic.name);
  say(item.children[1], arrivalOf(topic));
}

addCardPart(1, ({ rest }) => {
  const panel = new DiagnosisPanel((robot, seconds) => rest.get(`v1/robots/${encodeURIComponent(robot)}/diagnosis?seconds=${seconds}`));
  return { element: panel.element, update: (link) => panel.select(link?.robot.id ?? null, link?.presence === "silent") };
});
