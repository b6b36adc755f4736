import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { changeOf, partnersOf } = await import("../../../../endpoints/dashboard/static/js/map_panel.js");

test("a change is told by its cells", () => {
  assert.equal(changeOf({ occupied: 1, free: 20, known: 0, unknown: 0 }), "Now 1 cell occupied, 20 cells free");
  assert.equal(changeOf({ occupied: 0, free: 0, known: 0, unknown: 0 }), "No cell changes");
});

test("only maps with pose graphs are merged", () => {
  const map = (id, ...parts) => ({ id, parts });
  const maps = [map("a", "yaml", "posegraph"), map("b", "yaml"), map("c", "posegraph")];
  assert.deepEqual(partnersOf(maps, "a").map(({ id }) => id), ["c"]);
  assert.deepEqual(partnersOf(maps, "b"), []);
  assert.deepEqual(partnersOf(maps, "new:d"), []);
});
