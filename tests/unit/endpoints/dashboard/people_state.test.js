import assert from "node:assert/strict";
import test from "node:test";

const { PeopleState, TAIL, nameOf, robotOf } = await import("../../../../endpoints/dashboard/static/js/people_state.js");

const person = (id, x, fields = {}) => ({ id, name: "", position: [x, 1], velocity: [0, 0], state: "seen", seen_by: [], group: 0, ...fields });

const answer = (at, people, fields = {}) => ({ coordinator: "ready", reason: "", at, count: people.length, rule: "nearest", people, following: [], robots: [], ...fields });

test("a person has a name, or the id for one", () => {
  assert.equal(nameOf(person(3, 0)), "Person 3");
  assert.equal(nameOf(person(3, 0, { name: "Zoë" })), "Zoë");
});

test("the robot is the part of a frame before the torso", () => {
  assert.equal(robotOf("tb1/4"), "tb1");
  assert.equal(robotOf("lab/tb1/4"), "lab/tb1");
});

test("a tail follows an identity, and ends after some time", () => {
  const state = new PeopleState();
  for (let at = 0; at <= 3; at++) state.take(answer(at, [person(1, at), person(2, 9)]));
  assert.deepEqual(state.tail(1), [0, 1, 1, 1, 2, 1, 3, 1]);
  assert.deepEqual(state.tail(2), [9, 1]);
  state.take(answer(2 + TAIL, [person(1, 4), person(2, 9)]));
  assert.deepEqual(state.tail(1), [2, 1, 3, 1, 4, 1]);
});

test("a person who is gone has no tail, and is not picked any more", () => {
  const state = new PeopleState();
  state.take(answer(0, [person(1, 0)]));
  state.picked = 1;
  state.take(answer(1, [person(2, 0)]));
  assert.deepEqual([state.tail(1), state.picked], [[], null]);
});

test("the nearest person within reach is picked", () => {
  const state = new PeopleState();
  state.take(answer(0, [person(1, 0), person(2, 1)]));
  assert.equal(state.at({ x: 0.7, y: 1 }, 0.5).id, 2);
  assert.equal(state.at({ x: 5, y: 1 }, 0.5), null);
});

test("a person is added to those to follow, or taken from them", () => {
  const state = new PeopleState();
  state.settings = { rule: "named", targets: [1, 7], followed_at_once: 2, history: false, zones: [] };
  state.take(answer(0, [person(1, 0), person(2, 1)]));
  assert.deepEqual(state.targetsWith(2), [1, 2]); // 7 has left
  assert.deepEqual(state.targetsWith(1), []);
  state.settings.rule = "nearest";
  assert.deepEqual([state.isTarget(1), state.targetsWith(1)], [false, [1]]);
});

test("orders and places of robots are found", () => {
  const state = new PeopleState();
  assert.equal(state.active, false);
  const order = { robot: "tb1", person: 1, cost: 3, since: 0, reason: "nearest" };
  const robots = [{ robot: "tb1", position: [1, 2] }, { robot: "tb2", position: null }];
  state.take(answer(0, [person(1, 0)], { following: [order], robots }));
  assert.deepEqual([state.order(1), state.order(2)], [order, null]);
  assert.deepEqual([state.robot("tb1"), state.robot("tb2")], [{ x: 1, y: 2 }, null]);
  state.clear();
  assert.equal(state.active, false);
});
