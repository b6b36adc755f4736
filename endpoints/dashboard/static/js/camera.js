/** Pictures of a robot's cameras, in its card: asked for while they are shown only, at most two a second. */

import { make, say, show } from "./dom.js";
import { bytes } from "./format.js";
import { bare } from "./messages.js";
import { addCardPart } from "./registry.js";
import { Rosbridge } from "./rosbridge.js";

const TYPE = "sensor_msgs/CompressedImage";
const PERIOD = 500; // ms between two pictures
const ASK = 3000; // ms between two looks for cameras while there is none
const LARGEST = 2 << 20; // bytes of a picture that is shown
const WIDEST = 640; // pixels of a picture on the page
/** Pictures of depth have this type, too, and no browser shows them. */
const DEPTH = /compressedDepth$/;

/** The cameras among topics: names of pictures that a browser may show. @param {string[]} topics */
export function camerasOf(topics) {
  return topics.map(bare).filter((name) => !DEPTH.test(name)).sort();
}

/** Media type of a picture, or null if browsers do not show it. @param {string} format as `jpeg` or `rgb8; jpeg compressed bgr8` */
export function mediaOf(format) {
  const [, kind] = /\b(jpe?g|png|webp)\b/i.exec(String(format ?? "")) ?? [];
  return kind ? `image/${kind.toLowerCase().replace("jpg", "jpeg")}` : null;
}

/** Size of data in base64 [bytes]. @param {string} data */
export function sizeOf(data) {
  return Math.floor((data.length * 3) / 4);
}

/** Width and height of a picture on the page [pixels]. @param {{width: number, height: number}} picture */
export function fitted({ width, height }) {
  const scale = Math.min(1, WIDEST / width);
  return { width: Math.max(1, Math.round(width * scale)), height: Math.max(1, Math.round(height * scale)) };
}

function decoded(data, type) {
  const bytes = Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  return createImageBitmap(new Blob([bytes], { type }));
}

export class CameraView {
  #rest;
  /** @type {string | null} */ #robot = null;
  /** @type {Rosbridge | null} */ #socket = null;
  /** Counts connections, so that what an earlier one answers late is dropped. */ #turn = 0;
  #topic = "";
  #timer = 0;
  #note = make("p", { className: "where", role: "status" });
  #choice = make("select", { "aria-label": "Camera", onchange: () => this.#subscribe(this.#choice.value) });
  #canvas = make("canvas", { role: "img", className: "picture", hidden: true });
  element = make("details", { className: "go camera" }, make("summary", { textContent: "Camera" }), this.#choice, this.#note, this.#canvas);

  /** @param {import("./rest.js").Rest} rest */
  constructor(rest) {
    this.#rest = rest;
    this.element.addEventListener("toggle", () => (this.element.open ? this.#open() : this.#close()));
  }

  /** @param {string | null} robot id of the selected robot @param {boolean} connected whether it has a container */
  select(robot, connected) {
    if (robot !== this.#robot) this.element.open = false;
    if (robot !== this.#robot || !connected) this.#close();
    this.#robot = robot;
    this.element.hidden = !connected;
    if (connected && this.element.open && !this.#socket && !this.#timer) this.#open();
  }

  async #open() {
    this.#close();
    const turn = this.#turn;
    this.#say("Asking for its cameras…");
    const url = await this.#rest.socketUrl(this.#robot).catch((error) => this.#failed(turn, error.message));
    if (!url || turn !== this.#turn) return;
    this.#socket = new Rosbridge(url, {
      opened: () => this.#look(turn),
      closed: (reason) => this.#failed(turn, reason || "The connection was lost"),
      heard: (_topic, message) => this.#heard(turn, message),
      told: (text) => this.#say(text),
    });
  }

  #failed(turn, text) {
    if (turn !== this.#turn) return;
    this.#close();
    this.#say(text);
    if (this.element.open) this.#timer = setTimeout(() => this.#open(), ASK);
  }

  /** Look for cameras, again and again until there is one. */
  async #look(turn) {
    const { topics = [] } = await this.#socket.call("rosapi/topics_for_type", { type: TYPE });
    if (turn !== this.#turn) return;
    const cameras = camerasOf(topics);
    show(this.#choice, cameras, (name) => name, (name) => make("option", { value: name, textContent: name }), () => {});
    this.#choice.hidden = cameras.length < 2;
    if (cameras.length) return this.#subscribe(cameras[0]);
    this.#say(`It publishes no pictures (${TYPE})`);
    this.#timer = setTimeout(() => this.#look(turn), ASK);
  }

  #subscribe(topic) {
    if (this.#topic) this.#socket?.unsubscribe(this.#topic);
    this.#topic = topic;
    this.#say("Waiting for a picture…");
    this.#socket?.subscribe(topic, TYPE, PERIOD);
  }

  async #heard(turn, { format, data }) {
    const type = mediaOf(format);
    if (!type) return this.#refuse(`Pictures in the format ${format} are not shown`);
    const size = sizeOf(String(data ?? ""));
    if (size > LARGEST) return this.#refuse(`Its pictures have ${bytes(size)}: more than ${bytes(LARGEST)} are not shown`);
    const picture = await decoded(data, type).catch(() => null);
    if (turn !== this.#turn) return picture?.close();
    if (!picture) return this.#say("A picture cannot be read");
    this.#draw(picture);
  }

  #draw(picture) {
    Object.assign(this.#canvas, fitted(picture));
    this.#canvas.getContext("2d").drawImage(picture, 0, 0, this.#canvas.width, this.#canvas.height);
    picture.close();
    this.#canvas.setAttribute("aria-label", `Picture of ${this.#topic} of ${this.#robot}`);
    this.#canvas.hidden = false;
    say(this.#note, this.#topic);
  }

  /** End the subscription: pictures like this would come again and again. */
  #refuse(text) {
    this.#socket?.unsubscribe(this.#topic);
    this.#say(text);
  }

  #say(text) {
    say(this.#note, text);
    this.#canvas.hidden = true;
  }

  #close() {
    this.#turn += 1;
    clearTimeout(this.#timer);
    this.#timer = 0;
    this.#socket?.close();
    this.#socket = null;
    this.#topic = "";
    this.#canvas.hidden = true;
    this.#choice.hidden = true;
  }
}

addCardPart(2, ({ rest }) => {
  const camera = new CameraView(rest);
  return { element: camera.element, update: (link) => camera.select(link?.robot.id ?? null, Boolean(link?.waits)) };
});
