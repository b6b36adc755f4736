import assert from "node:assert/strict";
import { test } from "node:test";

const { MOST_FOLLOWED, followed, posesOfOthers } = await import("../../../../endpoints/dashboard/static/js/crowd.js");

const link = (id, observes = false) => ({ robot: { id }, observes });
const links = (count, prefix = "tb") => Array.from({ length: count }, (_, i) => link(`${prefix}${i}`));
const chosen = (all, selected = null) => [...followed(all, selected)].map(([{ robot }, observes]) => `${robot.id} ${observes}`);

test("each robot has a socket where there are few, and hears of no other", () => {
  const few = links(MOST_FOLLOWED);
  assert.equal(followed(few, null).size, MOST_FOLLOWED);
  assert.ok([...followed(few, null).values()].every((observes) => !observes));
});

test("of many robots, the selected one and one of each owner have a socket", () => {
  const many = [...links(MOST_FOLLOWED), link("bob:tb1"), link("bob:tb2")];
  assert.deepEqual(chosen(many), ["tb0 true", "bob:tb1 true"]);
  assert.deepEqual(chosen(many, many[7]), ["tb7 false", "tb0 true", "bob:tb1 true"]);
  assert.deepEqual(chosen(many, many[0]), ["tb0 true", "bob:tb1 true"]);
  assert.deepEqual(chosen(many, link("off")), ["tb0 true", "bob:tb1 true"]);
});

test("the robot that hears of the others stays the same while others come and go", () => {
  const many = [link("a"), ...links(MOST_FOLLOWED)];
  many[5].observes = true;
  assert.deepEqual(chosen(many), ["tb4 true"]);
  assert.deepEqual(chosen([link("A"), ...many]), ["tb4 true"]);
  assert.deepEqual(chosen(links(MOST_FOLLOWED + 1)), ["tb0 true"]);
});

test("places of others are those of robots of the same owner, by their addresses", () => {
  const pose = (x) => ({ position: { x, y: 2, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } });
  const message = { names: ["tb2", "", "tb3"], poses: [pose(1), pose(2), { position: { x: NaN, y: 0 }, orientation: { z: 0, w: 1 } }] };
  assert.deepEqual(posesOfOthers("tb1", message), [["tb2", { x: 1, y: 2, theta: 0 }]]);
  assert.deepEqual(posesOfOthers("bob:tb1", message), [["bob:tb2", { x: 1, y: 2, theta: 0 }]]);
  assert.deepEqual(posesOfOthers("tb1", { poses: [pose(1)] }), []);
});
