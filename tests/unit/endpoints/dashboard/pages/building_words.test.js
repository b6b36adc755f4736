import assert from "node:assert/strict";
import test from "node:test";

import {
  PARTS, aboutText, foundText, labelsOf, mayEdit, partOf, valuesOf,
} from "../../../../../endpoints/dashboard/static/js/pages/building_words.js";

const PARTS_GIVEN = {
  floors: [{ name: "L1", map: "m1" }, { name: "L2", map: "m2", elevation: 3.5, anchor: [1, -2, 0.123456789] }],
  lifts: [{ lift: "north" }, { lift: "south", robots: 2, speed: 1.5, wait: 0, doors: 4, device: "sim:" }],
  doors: [{ floor: "L1", door: "gate", opens: 0, device: "http://10.0.0.7/door" }],
  ways: [{ way: "ramp" }, { way: "up", kind: "stairs", length: 12, labels: { legs: "4", arm: "1" }, one_way: "L1" }],
};

for (const [part, given] of Object.entries(PARTS_GIVEN)) {
  test(`${part} are the same after they were shown in fields`, () => {
    for (const one of given) assert.deepEqual(partOf(part, valuesOf(part, one), one), one);
  });
}

test("a new part has usual values, which are not written", () => {
  const values = { ...valuesOf("lifts", {}), lift: " west " };
  assert.deepEqual(values, { lift: " west ", robots: "1", speed: "1", wait: "20", doors: "3", device: "" });
  assert.deepEqual(partOf("lifts", values), { lift: "west" });
});

test("an anchor is turned in degrees, and keeps its digits while it is not changed", () => {
  const [, floor] = PARTS_GIVEN.floors;
  const values = valuesOf("floors", floor);
  assert.equal(values.turn, "7.0736");
  assert.deepEqual(partOf("floors", { ...values, x: "5" }, floor).anchor, [5, -2, 0.123456789]);
  assert.deepEqual(partOf("floors", { ...values, turn: "180" }, floor).anchor, [1, -2, Math.PI]);
  assert.equal(partOf("floors", { ...values, x: "0", y: "0", turn: "" }, floor).anchor, undefined);
});

test("labels are pairs", () => {
  assert.deepEqual(labelsOf(" legs = 4, arm=1 ,"), { legs: "4", arm: "1" });
  assert.throws(() => labelsOf("legs"), /legs=4/);
});

test("every field of a part has a title", () => {
  for (const { fields } of Object.values(PARTS)) assert.ok(fields.every(({ key, title }) => key && title));
});

test("who made it and who may change it is told", () => {
  const inn = { version: 3, author: "bob", owner: "bob", readers: ["ann"] };
  assert.equal(aboutText(inn, "bob"), "Version 3 by bob; ann may read it.");
  assert.equal(aboutText({ ...inn, readers: ["*"] }, "ann"), "Version 3 by bob, of bob; everybody may read it.");
  assert.equal(aboutText({ ...inn, readers: [] }, "bob"), "Version 3 by bob; nobody else may read it.");
  assert.deepEqual([mayEdit(inn, { id: "bob", role: "user" }), mayEdit(inn, { id: "ann", role: "user" }), mayEdit(inn, { id: "ann", role: "admin" })], [true, false, true]);
  assert.equal(foundText({ floors: 2, lifts: 1, ways: 0, doors: 2, docks: 0 }), "It may be saved. On its maps: 2 floors, 1 lift, 0 ways, 2 doors, 0 docks");
});
