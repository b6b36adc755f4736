/** Draws the lifts and doors of a building on the shown floor, above its zones: where the car is, and what is open. */

import { label } from "./shapes.js";

const TINT = { open: 0.5, moving: 0.4, closed: 0.4, elsewhere: 0, fault: 0.35, unknown: 0 }; // opacity of a car
const DOOR = { open: [2, 8], moving: [6, 5], closed: [], fault: [], unknown: [2, 5] }; // dashes [pixels]
const CAR = { here: 3, elsewhere: 1.5 }; // pixels

export class BuildingLayer {
  /** @type {import("./building_state.js").Part[]} */ parts = [];
  #theme;

  /** @param {import("./theme.js").Theme} theme */
  constructor(theme) {
    this.#theme = theme;
  }

  set theme(theme) {
    this.#theme = theme;
  }

  /** Draw all parts. @param {CanvasRenderingContext2D} context @param {import("./view.js").View} view */
  draw(context, view) {
    for (const part of this.parts) (part.kind === "lift" ? this.#drawCar : this.#drawDoor).call(this, context, view, part);
  }

  /** The car, filled where it is; a cross over one that is out of order. */
  #drawCar(context, view, { look, words, outline }) {
    const points = outline.map(([x, y]) => view.toScreen({ x, y }));
    const colour = look === "fault" ? this.#theme.bad : this.#theme.zones.lift;
    context.save();
    trace(context, points, true);
    context.globalAlpha = TINT[look];
    context.fillStyle = colour;
    context.fill();
    context.globalAlpha = 1;
    const isHere = !["elsewhere", "unknown"].includes(look);
    pen(context, colour, isHere ? CAR.here : CAR.elsewhere, isHere ? [] : [5, 4]);
    context.stroke();
    if (look === "fault") {
      trace(context, [points[0], points[2]], false);
      context.stroke();
    }
    context.restore();
    const middle = (axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length;
    if (words) label(context, words, middle("x"), middle("y") + 14, this.#theme.ink, this.#theme.halo, look === "fault");
  }

  /** The line of a door: dashed while it is open. */
  #drawDoor(context, view, { look, words, outline }) {
    const points = outline.map(([x, y]) => view.toScreen({ x, y }));
    context.save();
    context.lineCap = "butt";
    trace(context, points, false);
    pen(context, this.#theme.halo, 9, []);
    context.stroke();
    pen(context, look === "fault" ? this.#theme.bad : this.#theme.zones.door, 5, DOOR[look] ?? DOOR.unknown);
    context.stroke();
    context.restore();
    const [from, to] = points;
    if (words) label(context, words, (from.x + to.x) / 2, (from.y + to.y) / 2 + 6, this.#theme.ink, this.#theme.halo, true);
  }
}

function trace(context, points, closed) {
  context.beginPath();
  points.forEach(({ x, y }, i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (closed) context.closePath();
}

function pen(context, colour, width, dash) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
}
