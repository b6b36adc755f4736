import assert from "node:assert/strict";
import test from "node:test";

import { placesOf } from "../../../../endpoints/dashboard/static/js/robot_names.js";

const robot = (id, x, y, selected = false) => ({ id, x, y, radius: 8, width: 60, selected });

test("a name is below its robot", () => {
  assert.deepEqual([...placesOf([robot("a", 100, 100)])], [["a", 113]]);
});

test("a name that would lie on another one is above its robot", () => {
  const places = placesOf([robot("a", 100, 100), robot("b", 130, 102)]);
  assert.deepEqual([places.get("a"), places.get("b")], [113, 74]);
});

test("a third name without room is left out, and the selected robot keeps its name", () => {
  const crowd = [robot("a", 100, 100), robot("b", 110, 101), robot("c", 120, 102, true)];
  assert.deepEqual([...placesOf(crowd).keys()], ["c", "a"]);
  assert.ok(placesOf(crowd.map((each) => ({ ...each, selected: true }))).size === 3);
});

test("names that are apart do not move each other", () => {
  assert.deepEqual([...placesOf([robot("a", 100, 100), robot("b", 161, 100)]).values()], [113, 113]);
});
