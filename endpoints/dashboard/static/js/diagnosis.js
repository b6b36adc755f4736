/** Diagnosis of the selected robot: what it sends, what is missing, and what to do, in the words of `ppaas doctor`. */

import { make, say, show } from "./dom.js";
import { plural } from "./format.js";
import { Poller } from "./poller.js";

const WORDS = { error: "Error", warn: "Warning", ok: "Note" };
const SECONDS = 2; // for which the robot is watched before the first answer
const TITLE = "What is wrong?";

/** Rate and age of a topic, in words. @param {object} topic */
export function arrivalOf({ rate, silence, refused }) {
  if (silence === null) return "never came";
  if (silence > 2) return `stopped ${Math.round(silence)} s ago`;
  return `${rate.toFixed(rate < 9.5 ? 1 : 0)} Hz${refused ? `, ${refused} refused` : ""}`;
}

/** Number of errors and warnings, in words. @param {object[]} findings */
export function summaryOf(findings) {
  const count = (level) => findings.filter((each) => each.level === level).length;
  const parts = [["error", count("error")], ["warning", count("warn")]].filter(([, number]) => number);
  return parts.map(([word, number]) => plural(number, word)).join(", ") || "All is well";
}

export class DiagnosisPanel {
  #robot = null;
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

  /** @param {string | null} robot the selected robot */
  select(robot) {
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
    if (robot === this.#robot) this.#show(diagnosis, summaryOf(diagnosis.findings)); // else another one was selected
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
