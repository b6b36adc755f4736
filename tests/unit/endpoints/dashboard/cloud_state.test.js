import assert from "node:assert/strict";
import test from "node:test";

import { CloudState } from "../../../../endpoints/dashboard/static/js/cloud_state.js";

const LISTS = {
  "v1/models": [{ name: "turtlebot2", robot_radius: 0.2 }],
  "v1/maps": [{ id: "office" }],
  "v1/buildings": [{ id: "hq", floors: ["L1"], maps: ["office"] }],
  "v1/robots": [{ id: "tb1", user: "ann", map: "office" }],
  "v1/robots?shared=true": [{ id: "tb9", user: "bob", map: "office" }],
  "v1/containers": [{ id: "c1", user: "ann", robot: "tb1" }, { id: "c2", user: "eve", robot: "tb2" }],
  "v1/machines": [{ id: "m1" }],
  "v1/endpoints": [],
};

function cloud(role, asked = []) {
  const things = { "v1/health": { time: Date.now() / 1000 + 100 }, "v1/users/me": { id: "ann", role } };
  return { list: async (path) => (asked.push(path), LISTS[path]), get: async (path) => (asked.push(path), things[path]) };
}

test("lists are read, with shared robots by their owners and the user's own containers", async () => {
  const state = new CloudState();
  await state.read(cloud("admin"));
  assert.deepEqual(state.robots.map(({ id }) => id), ["tb1", "bob:tb9"]);
  assert.deepEqual(state.own.map(({ id }) => id), ["c1"]);
  assert.equal(state.containers.length, 2);
  assert.deepEqual(state.buildings.map(({ id }) => id), ["hq"]);
  assert.equal(state.radii.get("turtlebot2"), 0.2);
  assert.deepEqual([state.isAdmin, state.machines], [true, [{ id: "m1" }]]);
});

test("who is no administrator does not ask for machines, and the user is asked for once", async () => {
  const [state, asked] = [new CloudState(), []];
  const rest = cloud("user", asked);
  await state.read(rest);
  await state.read(rest);
  assert.equal(state.machines, null);
  assert.equal(asked.filter((path) => path === "v1/users/me").length, 1);
  assert.ok(!asked.includes("v1/machines"));
  assert.equal(asked.filter((path) => path === "v1/buildings").length, 1, "buildings change rarely");
});

test("times are by the clock of the cloud", async () => {
  const state = new CloudState();
  await state.look(cloud("user"));
  assert.ok(Math.abs(state.now - Date.now() / 1000 - 100) < 5);
});
