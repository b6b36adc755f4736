/** The map on the page: view and interaction by touch, mouse and keyboard. */

import { byId, say } from "./dom.js";
import { Gestures } from "./gestures.js";
import { number } from "./format.js";
import { boundsOf } from "./grid.js";
import { Renderer } from "./renderer.js";
import { onTheme, readTheme } from "./theme.js";
import { View, rulerOf } from "./view.js";

const REACH = 22; // pixels around a robot that a finger hits it with
const STEP = 60; // pixels that an arrow key moves the map
const ZOOM = 1.4;
const MARGIN = { top: 76, bottom: 24, side: 24 };
const RULER = 120;

export class Stage {
  view = new View();
  /** @type {Renderer} */ renderer;
  #canvas = byId("map");
  #bounds = null;
  /** Whether the user has moved the view since it last showed everything. */
  #moved = false;
  #id = null;
  #fleet;
  #tools;
  #orders;

  /**
   * @param {import("./fleet.js").Fleet} fleet
   * @param {import("./tools.js").Tools} tools
   * @param {{select: (id: string | null) => void, order: (pose: import("./geometry.js").Pose) => void,
   *          pick: (point: import("./geometry.js").Point, reach: number) => void,
   *          drawing: () => import("./zones.js").Zones | import("./place_picker.js").PlacePicker | null}} orders who takes clicks while the user draws, if anybody
   */
  constructor(fleet, tools, orders) {
    this.#fleet = fleet;
    this.#tools = tools;
    this.#orders = orders;
    this.renderer = new Renderer(this.#canvas, this.view, fleet, readTheme());
    onTheme(() => (this.renderer.theme = readTheme()));
    new ResizeObserver(() => this.#resized()).observe(this.#canvas);
    new Gestures(this.#canvas, this.#meaning());
    this.#canvas.addEventListener("keydown", (event) => this.#key(event));
    this.#canvas.addEventListener("pointermove", (event) => this.#hover(event));
    this.#canvas.addEventListener("pointerleave", () => orders.drawing()?.hover(null));
    byId("zoom-in").addEventListener("click", () => this.#zoom(ZOOM));
    byId("zoom-out").addEventListener("click", () => this.#zoom(1 / ZOOM));
    byId("zoom-fit").addEventListener("click", () => this.fit());
  }

  /**
   * Show a grid, or none. Of another map all is shown; of a map that grows, as long as the user has not moved the view.
   * @param {string | null} id of the map @param {import("./grid.js").Grid | null} grid
   */
  show(id, grid) {
    const bounds = grid && boundsOf(grid.info);
    const other = JSON.stringify(bounds) !== JSON.stringify(this.#bounds);
    const fits = id !== this.#id || !this.#moved;
    this.#id = id;
    this.#bounds = bounds;
    this.renderer.grid = grid;
    if (other && fits) this.fit();
  }

  fit() {
    this.#moved = false;
    if (this.#bounds) this.view.fit(this.#bounds, MARGIN);
    this.#seen();
  }

  #resized() {
    const first = this.view.width <= 1;
    this.renderer.resize();
    if (first) this.fit();
    this.#seen();
  }

  #seen() {
    const { metres, pixels } = rulerOf(this.view.scale, RULER);
    byId("ruler").style.width = `${pixels}px`;
    say(byId("ruler-text"), metres < 1 ? `${number(metres * 100, 0)} cm` : `${number(metres, 0)} m`);
    this.renderer.ask();
  }

  #zoom(factor, at = { x: this.view.width / 2, y: this.view.height / 2 }) {
    this.#moved = true;
    this.view.zoom(at, factor);
    this.#seen();
  }

  #pan(dx, dy) {
    this.#moved = true;
    this.view.pan(dx, dy);
    this.#seen();
  }

  #meaning() {
    return {
      aims: () => !this.#orders.drawing() && this.#tools.current !== "look" && this.#fleet.selected !== null,
      aim: (from, to) => this.#aim(from, to),
      drop: () => (this.renderer.aim = null),
      pan: (dx, dy) => this.#pan(dx, dy),
      zoom: (at, factor) => this.#zoom(factor, at),
      tap: (at) => this.#tap(at),
      release: (from, to) => this.#release(from, to),
    };
  }

  #aim(from, to) {
    const link = this.#fleet.selected;
    if (!link) return; // it was taken from the map meanwhile
    const theta = to ? Math.atan2(from.y - to.y, to.x - from.x) : null;
    this.renderer.aim = { from, theta, colour: this.renderer.colourOf(link) };
  }

  #tap(at) {
    this.renderer.aim = null;
    const point = this.view.toWorld(at);
    const drawing = this.#orders.drawing();
    if (drawing) return drawing.click(point, REACH / this.view.scale);
    const hit = this.#fleet.at(point, REACH / this.view.scale);
    const { selected } = this.#fleet;
    const aims = this.#tools.current !== "look" && selected;
    if (hit && hit !== selected) this.#orders.select(hit.robot.id);
    else if (!aims) this.#orders.pick(point, REACH / this.view.scale);
    else this.#orders.order({ ...point, theta: this.#heading(selected, point) });
  }

  /** Without a heading, the robot drives to the place and keeps the heading of its arrival. */
  #heading({ state: { pose } }, point) {
    if (!pose) return 0;
    return this.#tools.current === "locate" ? pose.theta : Math.atan2(point.y - pose.y, point.x - pose.x);
  }

  #release(from, to) {
    this.renderer.aim = null;
    if (!this.#fleet.selected) return;
    this.#orders.order({ ...this.view.toWorld(from), theta: Math.atan2(from.y - to.y, to.x - from.x) });
  }

  /** A finger has no place while it is up, so it leaves no line behind. */
  #hover(event) {
    const at = { x: event.offsetX, y: event.offsetY };
    if (event.pointerType === "mouse") this.#orders.drawing()?.hover(this.view.toWorld(at));
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey) return;
    if (this.#orders.drawing()?.key(event.key, this.view.centre)) return event.preventDefault();
    const keys = {
      ArrowLeft: () => this.#pan(STEP, 0),
      ArrowRight: () => this.#pan(-STEP, 0),
      ArrowUp: () => this.#pan(0, STEP),
      ArrowDown: () => this.#pan(0, -STEP),
      "+": () => this.#zoom(ZOOM),
      "=": () => this.#zoom(ZOOM),
      "-": () => this.#zoom(1 / ZOOM),
      0: () => this.fit(),
      Escape: () => this.#orders.select(null),
    };
    if (!(event.key in keys)) return;
    event.preventDefault();
    keys[event.key]();
  }
}
