import assert from "node:assert/strict";
import test from "node:test";

import { Refused } from "../../../../endpoints/dashboard/static/js/rest.js";
import { containersOf, mapsOf, mayAdminister, mayDrive, withShared } from "../../../../endpoints/dashboard/static/js/shared_robots.js";

const OWN = [{ id: "tb1", user: "bob", map: "office" }];
const SHARED = [{ id: "tb1", user: "ann", map: "house" }, { id: "tb2", user: "ann", map: "new:attic" }];

test("robots of others have their address as their id", () => {
  assert.deepEqual(withShared(OWN, SHARED, "bob").map(({ id }) => id), ["tb1", "ann:tb1", "ann:tb2"]);
});

test("a robot is driven by those whose role is more than to look", () => {
  assert.deepEqual(["look", "drive", "administer"].map((role) => mayDrive({ role })), [false, true, true]);
  assert.deepEqual([null, undefined].map(mayDrive), [false, false]);
});

test("a robot is changed by its owner and those who administer it", () => {
  assert.deepEqual(["look", "drive", "administer"].map((role) => mayAdminister({ role })), [false, false, true]);
  assert.equal(mayAdminister(null), true);
});

test("containers are those of the user, and of robots that are shared", () => {
  const containers = [["bob", "tb1"], ["ann", "tb1"], ["ann", "tb9"], ["carl", null], ["bob", null]].map(
    ([user, robot]) => ({ user, robot }),
  );
  const found = containersOf(containers, withShared(OWN, SHARED, "bob"), "bob");
  assert.deepEqual(found.map(({ robot }) => robot), ["tb1", "ann:tb1", null]);
});

test("maps of shared robots are asked for once, and left out where they are not shown", async () => {
  const asked = [];
  const rest = {
    get: async (path) => {
      asked.push(path);
      if (path.endsWith("secret")) throw new Refused(404, "unknown map");
      return { id: "house", version: "v" };
    },
  };
  const robots = withShared(OWN, [...SHARED, { id: "tb3", user: "ann", map: "secret" }], "bob");
  const maps = await mapsOf(rest, [{ id: "office" }], robots);
  assert.deepEqual(maps.map(({ id }) => id), ["office", "house"]);
  assert.deepEqual(asked, ["v1/maps/house", "v1/maps/secret"]);
});
