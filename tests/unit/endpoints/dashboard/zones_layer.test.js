import assert from "node:assert/strict";
import test from "node:test";

import { ZonesLayer } from "../../../../endpoints/dashboard/static/js/zones_layer.js";
import { ZonesState } from "../../../../endpoints/dashboard/static/js/zones_state.js";

const THEME = { ink: "ink", halo: "halo", zones: { lane: "pink", one_way: "green", keep_out: "red" } };
const LINE = { type: "LineString", coordinates: [[0, 0], [10, 0]] };

/** A context that notes each stroke, with the paths that it is along. */
function notebook() {
  const strokes = [];
  let lines = [];
  let dash = [];
  const methods = {
    beginPath: () => (lines = []),
    moveTo: (x, y) => lines.push([[x, y]]),
    lineTo: (x, y) => lines.at(-1).push([x, y]),
    setLineDash: (given) => (dash = given),
    stroke: () => strokes.push({ colour: context.strokeStyle, width: context.lineWidth, dash, lines: structuredClone(lines) }),
  };
  const context = new Proxy(methods, { get: (target, name) => target[name] ?? (() => {}) });
  return { context, strokes };
}

/** What is stroked for zones, at a scale [pixels/m]. */
function strokesOf(features, { scale = 20, picked = null, drawing = null } = {}) {
  const { context, strokes } = notebook();
  const state = new ZonesState();
  state.take({ type: "FeatureCollection", features }, '"1"');
  state.picked = picked;
  const layer = new ZonesLayer(state, THEME);
  layer.drawing = drawing;
  layer.draw(context, { scale, width: 800, height: 600, toScreen: ({ x, y }) => ({ x: x * scale, y: -y * scale }) });
  return strokes;
}

const zone = (properties, geometry = LINE) => ({ type: "Feature", geometry, properties: { name: "a", ...properties } });
const lengthOf = (line) => line.slice(1).reduce((sum, [x, y], i) => sum + Math.hypot(x - line[i][0], y - line[i][1]), 0);
const shaftsOf = ({ lines }) => lines.filter((line) => line.length === 2); // the heads of arrows have three points

test("a lane is one solid line, as wide at each scale", () => {
  for (const scale of [5, 20, 100]) {
    const strokes = strokesOf([zone({ kind: "lane" })], { scale });
    assert.deepEqual(strokes, [{ colour: "pink", width: 3, dash: [], lines: [[[0, -0], [10 * scale, -0]]] }]);
  }
  assert.equal(strokesOf([zone({ kind: "lane" })], { picked: 0 })[0].width, 5);
});

test("each line of a lane is drawn", () => {
  const both = { type: "MultiLineString", coordinates: [[[0, 0], [1, 0]], [[2, 0], [2, 3], [4, 3]]] };
  assert.deepEqual(strokesOf([zone({ kind: "lane" }, both)]).map(({ lines }) => lines[0].length), [2, 3]);
});

test("a lane that leads one way has arrows in the order of its positions", () => {
  const [line, arrows, ...others] = strokesOf([zone({ kind: "lane", one_way: true }, { type: "LineString", coordinates: [[10, 0], [0, 0]] })]);
  assert.deepEqual([line.width, arrows.colour, others], [3, "pink", []]);
  assert.equal(shaftsOf(arrows).length, 3);
  for (const [[from], [to]] of shaftsOf(arrows)) assert.ok(to < from);
});

test("a curve of short segments has arrows too, as far apart as others", () => {
  const coordinates = Array.from({ length: 61 }, (_, i) => [10 * Math.cos(i / 40), 10 * Math.sin(i / 40)]);
  const [, line, arrows] = strokesOf([zone({ kind: "one_way", width: 1 }, { type: "LineString", coordinates })]);
  assert.ok(Math.abs(shaftsOf(arrows).length - lengthOf(line.lines[0]) / 56) <= 1);
  const [, , none] = strokesOf([zone({ kind: "one_way", width: 1 }, { type: "LineString", coordinates: [[0, 0], [0.5, 0]] })]);
  assert.deepEqual(none.lines, [], "it is too short for one");
});

test("a one-way line lies on a band as wide as it is, and always has arrows", () => {
  const [band, line, arrows] = strokesOf([zone({ kind: "one_way", width: 2 })]);
  assert.deepEqual([band.width, line.width, band.colour], [40, 1.5, "green"]);
  assert.equal(shaftsOf(arrows).length, 3);
});

test("zones of unknown kinds are drawn in ink", () => {
  const square = { type: "Polygon", coordinates: [[[0, 0], [2, 0], [2, 2], [0, 0]]] };
  const strokes = strokesOf([zone({ kind: "new_kind" }), zone({ kind: "new_kind" }, square)]);
  assert.deepEqual(new Set(strokes.map(({ colour }) => colour)), new Set(["ink"]));
});

test("a line is dashed in the colour of its kind while it is drawn", () => {
  const drawing = { kind: "lane", isLine: true, corners: [[0, 0], [3, 0]], hover: { x: 3, y: 3 } };
  const [first] = strokesOf([], { drawing });
  assert.deepEqual([first.colour, first.lines[0].length, first.dash.length], ["pink", 3, 2]);
});
