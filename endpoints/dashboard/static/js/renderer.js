/** Draws the map and the robots: at most once per frame, and only after changes. */

import { MapPicture } from "./map_picture.js";
import { placesOf } from "./robot_names.js";
import { body, dashes, dots, label, line, target, widthOf } from "./shapes.js";

/** @typedef {"zones" | "building" | "traffic" | "people" | "places"} Extra a layer that is not one of robots */

const LEAST = 8; // pixels: a robot seen from afar is still found

export class Renderer {
  /** @type {MapPicture | null} */ #picture = null;
  /** @type {{from: import("./geometry.js").Point, theta: number | null, colour: string} | null} */ #aim = null;
  /**
   * What else is drawn: zones, lifts and doors, and the traffic, below robots; people, above their paths and goals; picked places above all.
   * @type {Map<Extra, import("./zones_layer.js").ZonesLayer | import("./building_layer.js").BuildingLayer | import("./traffic_layer.js").TrafficLayer | import("./people_layer.js").PeopleLayer | import("./place_picker.js").PlacePicker>}
   */
  #layers = new Map();
  /** @type {{column: number, row: number, width: number, height: number}[]} */ #changes = [];
  #asked = false;
  #canvas;
  #view;
  #fleet;
  #theme;

  /** @param {HTMLCanvasElement} canvas @param {import("./view.js").View} view @param {import("./fleet.js").Fleet} fleet */
  constructor(canvas, view, fleet, theme) {
    this.#canvas = canvas;
    this.#view = view;
    this.#fleet = fleet;
    this.#theme = theme;
  }

  /** @param {import("./grid.js").Grid | null} grid */
  set grid(grid) {
    this.#picture = grid && new MapPicture(grid, this.#theme.palette);
    this.ask();
  }

  /** Set the rectangles of cells to mark, which a version that waits for a review changes. */
  set changes(rectangles) {
    this.#changes = rectangles;
    this.ask();
  }

  /** Draw zones, people or the traffic. @param {Extra} name */
  put(name, layer) {
    layer.theme = this.#theme;
    this.#layers.set(name, layer);
    this.ask();
  }

  /** Draw zones, people or the traffic no longer. @param {Extra} name */
  remove(name) {
    this.#layers.delete(name);
    this.ask();
  }

  set theme(theme) {
    this.#theme = theme;
    for (const layer of this.#layers.values()) layer.theme = theme;
    this.#picture?.paint(theme.palette);
    this.ask();
  }

  /** Set the pose being aimed at while a finger is down. */
  set aim(aim) {
    this.#aim = aim;
    this.ask();
  }

  /** Request drawing in the next frame. */
  ask() {
    if (this.#asked) return;
    this.#asked = true;
    requestAnimationFrame(() => {
      this.#asked = false;
      this.#draw();
    });
  }

  /** Adopt the size of the canvas on the page. */
  resize() {
    const { clientWidth, clientHeight } = this.#canvas;
    Object.assign(this.#view, { width: clientWidth, height: clientHeight });
    this.#canvas.width = Math.round(clientWidth * devicePixelRatio);
    this.#canvas.height = Math.round(clientHeight * devicePixelRatio);
    this.#draw(); // at once: setting its size has emptied the canvas
  }

  #draw() {
    const context = this.#canvas.getContext("2d");
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    context.fillStyle = this.#theme.ground;
    context.fillRect(0, 0, this.#view.width, this.#view.height);
    this.#drawMap(context);
    for (const name of ["zones", "building", "traffic"]) this.#layers.get(name)?.draw(context, this.#view);
    const links = this.#fleet.links.filter(({ located }) => located);
    for (const link of links) this.#drawSurroundings(context, link);
    for (const link of links) this.#drawTarget(context, link);
    this.#layers.get("people")?.draw(context, this.#view);
    for (const link of links) this.#drawRobot(context, link);
    this.#drawNames(context, links);
    this.#layers.get("places")?.draw(context, this.#view);
    if (this.#aim) target(context, this.#aim.from, this.#aim.theta, this.#aim.colour, this.#theme.halo);
  }

  #drawMap(context) {
    const { centre, scale, width, height } = this.#view;
    context.save();
    context.translate(width / 2, height / 2);
    context.scale(scale, -scale);
    context.translate(-centre.x, -centre.y);
    this.#picture?.draw(context, scale * devicePixelRatio);
    this.#picture?.mark(context, this.#changes, this.#theme.robots[0], 2 / scale);
    context.restore();
  }

  /** @param {import("./robot_link.js").RobotLink} link */
  colourOf(link) {
    return this.#theme.robots[link.robot.colour];
  }

  /** Colour of the robot with an id, also of one that is not on the map. @param {string} id */
  colourOfId(id) {
    const link = this.#fleet.link(id);
    return link ? this.colourOf(link) : this.#theme.ink;
  }

  #drawSurroundings(context, link) {
    const { particles, path, scan } = link.state;
    const colour = this.colourOf(link);
    context.globalAlpha = 0.4;
    dashes(context, this.#view, particles, colour);
    context.globalAlpha = 1;
    line(context, this.#view, path, this.#theme.halo, 6);
    line(context, this.#view, path, colour, 3);
    dots(context, this.#view, scan, colour, Math.min(4, Math.max(2, this.#view.scale * 0.03)));
  }

  #drawTarget(context, link) {
    const { destination } = link.state;
    if (!destination) return;
    target(context, this.#view.toScreen(destination), destination.theta, this.colourOf(link), this.#theme.halo);
  }

  #drawRobot(context, link) {
    const at = this.#view.toScreen(link.state.pose);
    const radius = this.#radiusOf(link);
    const selected = link === this.#fleet.selected;
    const style = { colour: this.colourOf(link), halo: this.#theme.halo, faded: link.presence !== "online", selected };
    body(context, at, radius, link.state.pose.theta, style);
  }

  #drawNames(context, links) {
    const named = links.map((link) => ({
      ...this.#view.toScreen(link.state.pose),
      id: link.robot.id,
      radius: this.#radiusOf(link),
      width: widthOf(context, link.robot.id, link === this.#fleet.selected),
      selected: link === this.#fleet.selected,
    }));
    const places = placesOf(named);
    for (const { id, x, selected } of named) {
      if (places.has(id)) label(context, id, x, places.get(id), this.#theme.ink, this.#theme.halo, selected);
    }
  }

  #radiusOf(link) {
    return Math.max(LEAST, link.robot.radius * this.#view.scale);
  }
}
