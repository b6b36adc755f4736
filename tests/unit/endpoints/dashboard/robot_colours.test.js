import assert from "node:assert/strict";
import { test } from "node:test";

import { RobotColours } from "../../../../endpoints/dashboard/static/js/robot_colours.js";

test("robots get different colours while there are some", () => {
  const colours = new RobotColours(3);
  colours.give(["a", "b", "c", "d"]);
  assert.deepEqual(["a", "b", "c", "d"].map((id) => colours.of(id)), [0, 1, 2, 0]);
});

test("a robot keeps its colour when another one comes before it, or leaves", () => {
  const colours = new RobotColours(3);
  colours.give(["b", "c"]);
  colours.give(["a", "b", "c"]);
  assert.deepEqual(["a", "b", "c"].map((id) => colours.of(id)), [2, 0, 1]);
  colours.give(["c"]);
  colours.give(["b", "c"]);
  assert.deepEqual(["b", "c"].map((id) => colours.of(id)), [0, 1]);
});

test("a colour of a robot that has left is given again", () => {
  const colours = new RobotColours(2);
  colours.give(["a", "b"]);
  colours.give(["b", "c"]);
  assert.equal(colours.of("c"), 0);
});
