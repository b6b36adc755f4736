import assert from "node:assert/strict";
import test from "node:test";

import { cropOf, cut, decisionOf, mayChange, readersOf, shiftOf, shortOf, OF_VERSION } from "../../../../../endpoints/dashboard/static/js/pages/map_words.js";

const info = (width, height, x = 0, y = 0) => ({ width, height, resolution: 0.5, origin: { x, y, theta: 0 } });

test("a picture shows all changes with some cells around, within the map", () => {
  const rectangles = [{ column: 50, row: 30, width: 10, height: 2 }, { column: 70, row: 90, width: 5, height: 5 }];
  assert.deepEqual(cropOf(rectangles, info(200, 100)), { column: 30, row: 10, width: 65, height: 90 });
  assert.deepEqual(cropOf([], info(200, 100)), { column: 0, row: 0, width: 200, height: 100 });
});

test("cells of a grid are found in a grid that begins elsewhere", () => {
  assert.deepEqual(shiftOf(info(9, 9, -1, 2), info(9, 9, -2, 4)), { columns: 2, rows: -4 });
});

test("a part of a grid has its cells, and unknown ones beyond its edges", () => {
  const grid = { info: info(3, 2), cells: Int8Array.of(1, 2, 3, 4, 5, 6) };
  assert.deepEqual([...cut(grid, { column: 1, row: 0, width: 2, height: 2 }).cells], [2, 3, 5, 6]);
  assert.deepEqual([...cut(grid, { column: -1, row: 1, width: 3, height: 2 }).cells], [-1, 4, 5, -1, -1, -1]);
  assert.deepEqual([...cut(grid, { column: 2, row: -1, width: 2, height: 2 }).cells], [-1, -1, 3, -1]);
  assert.deepEqual([...cut(grid, { column: 7, row: 7, width: 1, height: 1 }).cells], [-1]);
});

test("versions and reviews are put in words", () => {
  const version = { version: "0123456789abcdef", author: "ann", message: "a shelf", restored: true };
  assert.deepEqual(OF_VERSION.map(([, text]) => text(version, "today")), ["today", "01234567", "ann", "rolled back: a shelf"]);
  assert.equal(shortOf("abc"), "abc");
  assert.deepEqual([[], ["bob", "eve"], ["*"]].map((readers) => readersOf({ readers })), ["which nobody else reads", "read by bob, eve", "which everybody reads"]);
  assert.equal(decisionOf({ number: 7, state: "refused", closed_by: "ann", reason: "a person" }), "7 was refused by ann: a person");
  assert.deepEqual(["ann", "bob"].map((id) => mayChange({ owner: "ann" }, { id, role: "user" })), [true, false]);
  assert.equal(mayChange({ owner: "ann" }, { id: "eve", role: "admin" }), true);
});
