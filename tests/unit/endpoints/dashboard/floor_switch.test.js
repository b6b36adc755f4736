import assert from "node:assert/strict";
import test from "node:test";

globalThis.document = { getElementById: () => null };
const { floorsOf } = await import("../../../../endpoints/dashboard/static/js/floor_switch.js");

const INN = { id: "inn", floors: ["ground", "cellar", "upper"], maps: ["inn-0", "inn-c", "inn-1"], elevations: [0, -3, 3.5] };
const HUT = { id: "hut", floors: ["only"], maps: ["hut"], elevations: [0] };

test("the floors of the building of a map are told, the highest first", () => {
  const floors = floorsOf([HUT, INN], "inn-0", new Set(["inn-0", "inn-1", "hut"]));
  assert.deepEqual(floors, [
    { name: "upper", map: "inn-1", isShown: false, isKnown: true },
    { name: "ground", map: "inn-0", isShown: true, isKnown: true },
    { name: "cellar", map: "inn-c", isShown: false, isKnown: false },
  ]);
});

test("a map of no building has no floors", () => {
  assert.deepEqual(floorsOf([HUT, INN], "office", new Set(["office"])), []);
  assert.deepEqual(floorsOf([], null, new Set()), []);
});
