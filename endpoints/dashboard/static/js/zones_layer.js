/** Draws zones on the map, below everything else: a colour for each kind, hatched where robots may not be or stand. */

import { label } from "./shapes.js";
import { linesOf, middleOf, pointOf, polygonsOf } from "./zone_shapes.js";
import { valueOf } from "./zones_state.js";

const TINT = { in: 0.2, out: 0.07, picked: 0.34 }; // opacity
const STROKE = { in: 0.9, out: 0.5 };
const HATCH = { keep_out: { gap: 10, turn: 1 }, no_stop: { gap: 16, turn: -1 } }; // pixels between lines, and their slope
const ARROWS = 56; // pixels between two arrows
const ARROW = 9; // pixels
const LEGIBLE = 44; // pixels that a zone is wide to have a name
const DASH = [7, 5];
const LANE = { width: 3, picked: 5 }; // pixels
const STATION = { radius: 5, picked: 7, heading: 14 }; // pixels
const CROSS = 9; // pixels from the middle of a cross to its ends

export class ZonesLayer {
  /** What the user draws. @type {import("./zone_shapes.js").Drawing | null} */ drawing = null;
  #state;
  #theme;

  /** @param {import("./zones_state.js").ZonesState} state @param {import("./theme.js").Theme} theme */
  constructor(state, theme) {
    this.#state = state;
    this.#theme = theme;
  }

  set theme(theme) {
    this.#theme = theme;
  }

  /** @param {string} kind */
  colourOf(kind) {
    return this.#theme.zones[kind] ?? this.#theme.ink;
  }

  /** Draw all zones. @param {CanvasRenderingContext2D} context @param {import("./view.js").View} view */
  draw(context, view) {
    this.#state.features.forEach((zone, index) => this.#drawZone(context, view, zone, index));
    this.#state.features.forEach((zone, index) => this.#drawName(context, view, zone, index));
    for (const { place } of this.#state.faults) if (place) this.#drawFault(context, view.toScreen({ x: place[0], y: place[1] }));
    if (this.drawing) this.#drawDrawing(context, view, this.drawing);
  }

  /** A cross where a zone is wrong. */
  #drawFault(context, { x, y }) {
    for (const [colour, width] of [[this.#theme.halo, 7], [this.#theme.bad, 3]]) {
      context.beginPath();
      for (const turn of [1, -1]) {
        context.moveTo(x - CROSS, y - turn * CROSS);
        context.lineTo(x + CROSS, y + turn * CROSS);
      }
      pen(context, colour, width, []);
      context.stroke();
    }
  }

  #drawZone(context, view, { geometry, properties }, index) {
    const inForce = this.#state.standing(index) !== "not in force";
    const picked = index === this.#state.picked;
    const look = {
      colour: this.colourOf(properties.kind),
      tint: picked ? TINT.picked : inForce ? TINT.in : TINT.out,
      stroke: inForce ? STROKE.in : STROKE.out,
      dash: inForce ? [] : DASH,
      width: ["lane", "door"].includes(properties.kind) ? (picked ? LANE.picked : LANE.width) : picked ? 3 : 1.5,
    };
    for (const line of linesOf(geometry)) drawLine(context, view, line, properties, look);
    for (const rings of polygonsOf(geometry)) drawPolygon(context, view, rings, properties, look);
    if (pointOf(geometry)) drawStation(context, view, pointOf(geometry), properties.yaw, look.colour, picked);
    context.globalAlpha = 1;
  }

  #drawName(context, view, { geometry, properties }, index) {
    const picked = index === this.#state.picked;
    if (!picked && !pointOf(geometry) && !isLegible(geometry, view)) return;
    const { x, y } = view.toScreen(middleOf(geometry));
    context.globalAlpha = this.#state.standing(index) === "not in force" ? STROKE.out : 1;
    label(context, properties.name, x, y - 14, this.#theme.ink, this.#theme.halo, picked);
    label(context, valueOf(properties), x, y + 1, this.#theme.ink, this.#theme.halo, picked);
    context.globalAlpha = 1;
  }

  /** The corners so far, a line to the pointer, and the middle of the map, where the space bar puts a corner. */
  #drawDrawing(context, view, { corners, hover, isLine, kind }) {
    const points = [...corners, ...(hover ? [[hover.x, hover.y]] : [])].map(([x, y]) => view.toScreen({ x, y }));
    const colour = this.colourOf(kind);
    trace(context, points, !isLine && points.length > 2);
    pen(context, colour, 2, DASH);
    context.stroke();
    context.setLineDash([]);
    for (const { x, y } of points.slice(0, corners.length)) {
      context.beginPath();
      context.arc(x, y, 5, 0, 2 * Math.PI);
      context.fillStyle = this.#theme.halo;
      context.fill();
      context.stroke();
    }
    const [x, y] = [view.width / 2, view.height / 2];
    context.beginPath();
    for (const [dx, dy] of [[8, 0], [0, 8]]) {
      context.moveTo(x - dx, y - dy);
      context.lineTo(x + dx, y + dy);
    }
    pen(context, this.#theme.ink, 1, []);
    context.stroke();
  }
}

function isLegible(geometry, view) {
  const places = [...polygonsOf(geometry).flat(), ...linesOf(geometry)].flat();
  const { left, right } = boxOf(places.map(([x, y]) => ({ x, y })));
  return (right - left) * view.scale >= LEGIBLE;
}

/** A dot, with a line in the heading of a robot that stands there. */
function drawStation(context, view, [placeX, placeY], yaw, colour, picked) {
  const { x, y } = view.toScreen({ x: placeX, y: placeY });
  context.globalAlpha = 1;
  context.beginPath();
  context.arc(x, y, picked ? STATION.picked : STATION.radius, 0, 2 * Math.PI);
  context.fillStyle = colour;
  context.fill();
  if (!Number.isFinite(yaw)) return;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + STATION.heading * Math.cos(yaw), y - STATION.heading * Math.sin(yaw));
  pen(context, colour, 2, []);
  context.stroke();
}

function drawPolygon(context, view, rings, { kind, direction }, { colour, tint, stroke, dash, width }) {
  const points = rings.map((ring) => ring.map(([x, y]) => view.toScreen({ x, y })));
  context.save();
  context.beginPath();
  for (const ring of points) path(context, ring, true);
  context.globalAlpha = tint;
  context.fillStyle = colour;
  context.fill("evenodd");
  context.globalAlpha = stroke;
  pen(context, colour, width, dash);
  context.stroke();
  context.clip("evenodd");
  const box = seen(boxOf(points.flat()), view);
  if (HATCH[kind]) hatch(context, box, view.toScreen({ x: 0, y: 0 }), HATCH[kind]);
  if (kind === "one_way") arrows(context, box, view.toScreen({ x: 0, y: 0 }), direction ?? 0);
  pen(context, colour, kind === "one_way" ? 2 : 1, []);
  context.globalAlpha = stroke * (kind === "one_way" ? 1 : 0.55);
  context.stroke();
  context.restore();
}

/** A line, on a band as wide as its zone; a lane has no width. */
function drawLine(context, view, line, { kind, width: wide = 0, one_way: oneWay }, { colour, tint, stroke, dash, width }) {
  const points = line.map(([x, y]) => view.toScreen({ x, y }));
  trace(context, points, false);
  context.lineJoin = context.lineCap = "round";
  if (kind !== "lane") {
    context.globalAlpha = tint;
    pen(context, colour, Math.max(2, wide * view.scale), []);
    context.stroke();
  }
  context.globalAlpha = stroke;
  pen(context, colour, width, dash);
  context.stroke();
  context.setLineDash([]);
  if (kind === "door" || (kind === "lane" && !oneWay)) return;
  context.beginPath();
  along(context, points);
  pen(context, colour, 2, []);
  context.stroke();
}

/** Arrows along a line: one in the middle of each long segment at least; short ones, as those of curves, share some. */
function along(context, points) {
  let since = ARROWS / 2; // pixels since the last arrow
  points.slice(1).forEach((to, i) => {
    const from = points[i];
    const [dx, dy] = [to.x - from.x, to.y - from.y];
    const length = Math.hypot(dx, dy);
    since += length;
    const count = length < 2 * ARROW ? Number(since >= ARROWS) : Math.min(100, Math.max(1, Math.floor(length / ARROWS)));
    for (let j = 0; j < count; j += 1) {
      const part = (j + 0.5) / count;
      chevron(context, from.x + part * dx, from.y + part * dy, Math.atan2(dy, dx));
    }
    if (count) since = length / count / 2;
  });
}

/** Arrows on a grid that moves with the map. The angle is that of the map, y up. */
function arrows(context, { left, right, top, bottom }, origin, direction) {
  context.beginPath();
  for (let x = first(left, origin.x, ARROWS); x < right + ARROWS; x += ARROWS) {
    for (let y = first(top, origin.y, ARROWS); y < bottom + ARROWS; y += ARROWS) chevron(context, x, y, -direction);
  }
}

function chevron(context, x, y, angle) {
  const at = (along, aside) => [x + along * Math.cos(angle) - aside * Math.sin(angle), y + along * Math.sin(angle) + aside * Math.cos(angle)];
  context.moveTo(...at(-ARROW, 0));
  context.lineTo(...at(ARROW, 0));
  context.moveTo(...at(ARROW / 3, -ARROW / 2));
  context.lineTo(...at(ARROW, 0));
  context.lineTo(...at(ARROW / 3, ARROW / 2));
}

function hatch(context, { left, right, top, bottom }, origin, { gap, turn }) {
  context.beginPath();
  const high = bottom - top;
  const anchor = turn > 0 ? origin.x + origin.y - bottom : origin.x - origin.y + top;
  for (let x = first(left - high, anchor, gap); x < right + high; x += gap) {
    context.moveTo(x, turn > 0 ? bottom : top);
    context.lineTo(x + high, turn > 0 ? top : bottom);
  }
}

/** The first place from `from` on that is a whole number of steps away from an origin. */
function first(from, origin, step) {
  return from - ((((from - origin) % step) + step) % step);
}

/** The part of a box on the screen. */
function seen({ left, right, top, bottom }, { width, height }) {
  return { left: Math.max(left, 0), right: Math.min(right, width), top: Math.max(top, 0), bottom: Math.min(bottom, height) };
}

function boxOf(points) {
  const [xs, ys] = [points.map(({ x }) => x), points.map(({ y }) => y)];
  const most = (values, pick) => values.reduce((a, b) => pick(a, b));
  return { left: most(xs, Math.min), right: most(xs, Math.max), top: most(ys, Math.min), bottom: most(ys, Math.max) };
}

function trace(context, points, closed) {
  context.beginPath();
  path(context, points, closed);
}

function path(context, points, closed) {
  points.forEach(({ x, y }, i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  if (closed) context.closePath();
}

function pen(context, colour, width, dash) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
}
