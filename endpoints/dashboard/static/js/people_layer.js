/** Draws people on the map: zones, tails, which robots see them, who follows whom, and who talks with whom. */

import { nameOf, robotOf } from "./people_state.js";
import { circle, label, line } from "./shapes.js";

const SHOULDERS = { across: 0.25, along: 0.15, head: 0.1 }; // half of the width, of the depth, of the head [m]
const LEAST = 5; // pixels: a person seen from afar is still found
const STANDING = 0.15; // m/s: slower people have no heading
const CLOSE = 90; // pixels a metre from which the names of all tf frames are legible

export class PeopleLayer {
  #state;
  #theme;

  /** @param {import("./people_state.js").PeopleState} state @param {import("./theme.js").Theme} theme */
  constructor(state, theme) {
    this.#state = state;
    this.#theme = theme;
  }

  set theme(theme) {
    this.#theme = theme;
  }

  /** @param {number} id */
  colourOf(id) {
    return this.#theme.robots[(id + 2) % this.#theme.robots.length];
  }

  /** Draw all people. @param {CanvasRenderingContext2D} context @param {import("./view.js").View} view */
  draw(context, view) {
    const { people } = this.#state.answer;
    for (const zone of this.#state.settings?.zones ?? []) this.#drawZone(context, view, zone);
    this.#drawGroups(context, view, people);
    for (const person of people) this.#drawLines(context, view, person);
    for (const person of people) this.#drawPerson(context, view, person);
  }

  #drawZone(context, view, { name, corners }) {
    const points = corners.map(([x, y]) => view.toScreen({ x, y }));
    outline(context, points, this.#theme.ink, 1, [6, 4], true);
    const top = points.reduce((best, point) => (point.y < best.y ? point : best));
    label(context, name, top.x, top.y - 18, this.#theme.ink, this.#theme.halo, false);
  }

  /** Join the people who talk with each other. */
  #drawGroups(context, view, people) {
    for (const group of new Set(people.map((person) => person.group).filter(Boolean))) {
      const members = people.filter((person) => person.group === group);
      outline(context, members.map((person) => placeOf(view, person)), this.#theme.ink, 1.5, [2, 5], true);
    }
  }

  #drawLines(context, view, person) {
    const colour = this.colourOf(person.id);
    const at = placeOf(view, person);
    context.globalAlpha = 0.75;
    line(context, view, this.#state.tail(person.id), colour, 2);
    context.globalAlpha = 1;
    for (const frame of person.seen_by) this.#drawSight(context, view, frame, at, colour, person.id === this.#state.picked);
    const order = this.#state.order(person.id);
    const robot = order && this.#state.robot(order.robot);
    if (robot) outline(context, [view.toScreen(robot), at], colour, 3.5, [9, 6], false);
  }

  /** A thin line from the robot that sees a person, with the name of the person's tf frame. */
  #drawSight(context, view, frame, at, colour, picked) {
    const robot = this.#state.robot(robotOf(frame));
    if (!robot) return;
    const from = view.toScreen(robot);
    context.globalAlpha = 0.5;
    outline(context, [from, at], colour, 1, [], false);
    context.globalAlpha = 1;
    if (view.scale < CLOSE && !picked) return;
    label(context, frame, from.x + 0.6 * (at.x - from.x), from.y + 0.6 * (at.y - from.y), this.#theme.ink, this.#theme.halo, false);
  }

  #drawPerson(context, view, person) {
    const at = placeOf(view, person);
    const picked = person.id === this.#state.picked;
    const size = Math.max(1, LEAST / (SHOULDERS.along * view.scale)) * view.scale;
    const style = { colour: this.colourOf(person.id), halo: this.#theme.halo, seen: person.state === "seen", picked };
    context.globalAlpha = person.state === "lost" ? 0.4 : 1;
    figure(context, at, size, headingOf(person), style);
    const name = person.state === "lost" ? `${nameOf(person)}?` : nameOf(person);
    label(context, name, at.x, at.y + SHOULDERS.across * size + 6, this.#theme.ink, this.#theme.halo, picked);
    context.globalAlpha = 1;
  }
}

function placeOf(view, { position: [x, y] }) {
  return view.toScreen({ x, y });
}

function headingOf({ velocity: [x, y] }) {
  return Math.hypot(x, y) < STANDING ? 0 : Math.atan2(y, x);
}

function outline(context, points, colour, width, pattern, closed) {
  context.beginPath();
  points.forEach(({ x, y }, i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (closed) context.closePath();
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(pattern);
  context.stroke();
  context.setLineDash([]);
}

/** A person from above: shoulders and head; only the outline while nobody sees the person. */
function figure(context, at, size, heading, { colour, halo, seen, picked }) {
  context.save();
  context.translate(at.x, at.y);
  context.rotate(-heading);
  if (picked) circle(context, SHOULDERS.across * size + 7, colour);
  context.beginPath();
  context.ellipse(0, 0, SHOULDERS.along * size, SHOULDERS.across * size, 0, 0, 2 * Math.PI);
  context.fillStyle = seen ? colour : halo;
  context.fill();
  context.strokeStyle = seen ? halo : colour;
  context.lineWidth = 2;
  context.setLineDash(seen ? [] : [4, 3]);
  context.stroke();
  context.beginPath();
  context.arc(0, 0, SHOULDERS.head * size, 0, 2 * Math.PI);
  context.fillStyle = seen ? halo : colour;
  context.fill();
  context.restore();
}
