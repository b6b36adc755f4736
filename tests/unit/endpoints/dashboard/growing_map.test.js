import assert from "node:assert/strict";
import test from "node:test";

import { poseMessage } from "../../../../endpoints/dashboard/static/js/geometry.js";
import { GrowingMap, isNew, nameOf, sharing } from "../../../../endpoints/dashboard/static/js/growing_map.js";

const whole = () => ({
  info: { resolution: 0.5, width: 3, height: 2, origin: poseMessage({ x: -1, y: 2, theta: 0 }) }, data: [0, 1, 2, 3, 4, -1],
});

function begun() {
  const map = new GrowingMap();
  map.replace(whole());
  return map;
}

test("maps that robots make are told from published ones", () => {
  assert.deepEqual([isNew("new:office-2"), isNew("office-2"), isNew(null)], [true, false, false]);
  assert.equal(nameOf("new:office-2"), "office-2");
});

test("a whole map is a grid with its pose", () => {
  const { grid } = begun();
  assert.deepEqual([grid.info.width, grid.info.height, grid.info.origin.x, grid.info.origin.y], [3, 2, -1, 2]);
  assert.deepEqual([...grid.cells], [0, 1, 2, 3, 4, -1]);
});

test("a change replaces its rectangle, in a new grid", () => {
  const map = begun();
  const before = map.grid;
  map.change({ x: 1, y: 0, width: 2, height: 2, data: [10, 20, 30, 40] });
  assert.deepEqual([...map.grid.cells], [0, 10, 20, 3, 30, 40]);
  assert.notEqual(map.grid, before);
});

test("changes of another grid and incomplete messages are ignored", () => {
  const map = new GrowingMap();
  map.change({ x: 0, y: 0, width: 1, height: 1, data: [5] });
  assert.equal(map.grid, null);
  map.replace(whole());
  const { grid } = map;
  const wrong = [
    { x: 2, y: 0, width: 2, height: 1, data: [5, 5] }, { x: -1, y: 0, width: 1, height: 1, data: [5] },
    { x: 0, y: 0, width: 2, height: 1, data: [5] }, {}, { x: 0, y: 2, width: 1, height: 1, data: [5] },
  ];
  for (const message of wrong) map.change(message);
  for (const message of [{}, { ...whole(), data: [1] }, { ...whole(), info: { ...whole().info, resolution: 0 } }]) map.replace(message);
  assert.equal(map.grid, grid);
});

test("the card says how far a publication is", () => {
  const map = { joined_with: ["tb2"], refused: null };
  assert.equal(sharing({ ...map, publishing: null }), "Map made together with tb2");
  assert.equal(sharing({ ...map, publishing: { stage: "loops", part: 0.256 } }), "Publishing: missing loops are searched, 25 %");
  assert.equal(sharing({ ...map, publishing: { stage: "storing", part: 0 } }), "Publishing: the map is stored");
  assert.equal(sharing({ ...map, publishing: { stage: "new", part: 0 } }), "Publishing: new");
});

test("the card says with which robots a map is made, or why it is not", () => {
  assert.equal(sharing(null), "");
  assert.equal(sharing({ joined_with: [], refused: null }), "");
  assert.equal(sharing({ joined_with: ["tb2", "bob/tb3"], refused: null }), "Map made together with tb2, bob/tb3");
  assert.equal(sharing({ joined_with: [], refused: "too few places" }), "Map not joined with another map: too few places");
  const both = sharing({ joined_with: ["tb2"], refused: "too few places" });
  assert.equal(both, "Map made together with tb2; not joined with another map: too few places");
});
