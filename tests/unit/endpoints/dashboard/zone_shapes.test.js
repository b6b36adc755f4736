import assert from "node:assert/strict";
import test from "node:test";

import { Drawing, cornersOf, middleOf, within, withCorners } from "../../../../endpoints/dashboard/static/js/zone_shapes.js";

const RING = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]];
const HOLE = [[1, 1], [3, 1], [3, 3], [1, 3], [1, 1]];
const polygon = (...rings) => ({ type: "Polygon", coordinates: rings });
const line = { type: "LineString", coordinates: [[0, 0], [4, 0], [4, 4]] };

test("points lie in a polygon, not in its holes", () => {
  const zone = { geometry: polygon(RING, HOLE), properties: {} };
  assert.equal(within(zone, { x: 0.5, y: 2 }, 0), true);
  assert.equal(within(zone, { x: 2, y: 2 }, 0), false);
  assert.equal(within(zone, { x: 5, y: 2 }, 0), false);
  const both = { geometry: { type: "MultiPolygon", coordinates: [[HOLE], [RING]] }, properties: {} };
  assert.equal(within(both, { x: 2, y: 2 }, 0), true);
});

test("points lie on a line as wide as it is, and a thin one is still hit", () => {
  const zone = (width) => ({ geometry: line, properties: { width } });
  assert.equal(within(zone(2), { x: 2, y: 0.9 }, 0.1), true);
  assert.equal(within(zone(2), { x: 2, y: 1.1 }, 0.1), false);
  assert.equal(within(zone(0.1), { x: 4.4, y: 2 }, 0.5), true);
  assert.equal(within(zone(undefined), { x: 4.4, y: 2 }, 0.5), true, "a lane has no width");
  assert.equal(within(zone(undefined), { x: 4.6, y: 2 }, 0.5), false);
});

test("the name stands in the middle", () => {
  assert.deepEqual(middleOf(polygon(RING)), { x: 2, y: 2 });
  assert.deepEqual(middleOf(line), { x: 4, y: 2 });
  assert.deepEqual(middleOf({ type: "MultiLineString", coordinates: [[[0, 0], [2, 0]], [[9, 9], [8, 8]]] }), { x: 1, y: 0 });
});

test("corners are text that can be changed", () => {
  assert.equal(cornersOf(polygon(RING)), "0 0, 4 0, 4 4, 0 4");
  assert.equal(cornersOf(line), "0 0, 4 0, 4 4");
  assert.equal(cornersOf(polygon(RING, HOLE)), null);
  assert.deepEqual(withCorners(polygon(RING), "0 0,  1.5 -2 , 3 3"), polygon([[0, 0], [1.5, -2], [3, 3], [0, 0]]));
  assert.deepEqual(withCorners(line, "1 2, 3 4"), { type: "LineString", coordinates: [[1, 2], [3, 4]] });
  for (const wrong of ["", "0 0, 1 1", "0 0, 1 1, 2", "0 0, 1 1, x y", "0 0, 1 1, 2 2 2"]) assert.equal(withCorners(polygon(RING), wrong), null, wrong);
});

test("a polygon is drawn by clicks and ends with a double-click or at its first corner", () => {
  const drawing = new Drawing("keep_out", false);
  let now = 0;
  const click = (x, y, wait = 1000) => drawing.click({ x, y }, 0.2, (now += wait));
  assert.equal(click(0, 0), false);
  assert.equal(click(4.001, 0), false);
  assert.deepEqual([drawing.missing, drawing.geometry], [1, null]);
  assert.equal(click(4, 4), false);
  assert.equal(click(4.05, 4.02, 200), true, "a double-click adds no corner");
  assert.deepEqual(drawing.geometry, polygon([[0, 0], [4, 0], [4, 4], [0, 0]]));
  assert.equal(click(0.1, 0.1), true);
  drawing.undo();
  assert.equal(drawing.geometry, null);
  assert.equal(click(0.1, 0.1), false, "too few corners to end at the first one");
});

test("a slow click at the same place is no corner of its own", () => {
  const drawing = new Drawing("one_way", true);
  drawing.click({ x: 1, y: 1 }, 0, 0);
  drawing.click({ x: 1, y: 1 }, 0, 5000);
  assert.equal(drawing.missing, 1);
  drawing.click({ x: 1, y: 3 }, 0, 9000);
  assert.deepEqual(drawing.geometry, { type: "LineString", coordinates: [[1, 1], [1, 3]] });
});

test("a door is drawn by two clicks, and a place by one", () => {
  const door = new Drawing("door", true);
  assert.equal(door.click({ x: 1, y: 1 }, 0.2, 0), false);
  assert.equal(door.click({ x: 2, y: 1 }, 0.2, 5000), true);
  assert.deepEqual(door.geometry, { type: "LineString", coordinates: [[1, 1], [2, 1]] });
  const dock = new Drawing("dock", false, true);
  assert.deepEqual([dock.missing, dock.geometry], [1, null]);
  assert.equal(dock.click({ x: 1.004, y: 2 }, 0.2, 0), true);
  assert.deepEqual(dock.geometry, { type: "Point", coordinates: [1, 2] });
});
