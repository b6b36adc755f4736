import assert from "node:assert/strict";
import test from "node:test";

import { RecordingList, matches, sumOf } from "../../../../../endpoints/dashboard/static/js/pages/recording_list.js";

const one = (id, size = 1024) => ({ id, size, finished: true });

test("the recordings of all robots are listed, the newest first", async () => {
  const list = new RecordingList(async (robot) => (robot === "tb2" ? [one("20260102T000000Z")] : [one("20260103T000000Z"), one("20260101T000000Z")]));
  await list.read(["tb1", "tb2"], 0, () => {});
  assert.deepEqual(list.recordings.map(({ robot, id }) => `${robot} ${id.slice(0, 8)}`), ["tb1 20260103", "tb2 20260102", "tb1 20260101"]);
});

test("hundreds of robots are read a few at once, and again only after a while, or if others are listed", async () => {
  let [open, most, asked] = [0, 0, 0];
  const list = new RecordingList(async () => {
    asked += 1;
    most = Math.max(most, (open += 1));
    await new Promise((done) => setImmediate(done));
    open -= 1;
    return [];
  });
  const robots = Array.from({ length: 10 }, (_, i) => `tb${i}`);
  const progress = [];
  await list.read(robots, 0, () => progress.push(list.done));
  assert.deepEqual([most, asked, ...progress], [4, 10, 4, 8, 10]);
  await list.read(robots, 29, () => {});
  assert.equal(asked, 10);
  await list.read(robots.slice(1), 29, () => {});
  assert.equal(asked, 19);
  list.forget();
  await list.read(robots.slice(1), 29, () => {});
  assert.equal(asked, 28);
});

test("a look that failed is repeated by the next one, and what was read stays", async () => {
  let away = true;
  const list = new RecordingList(async (robot) => {
    if (away && robot === "tb5") throw new Error("away");
    return [one(`2026-${robot}`)];
  });
  const robots = ["tb1", "tb2", "tb3", "tb4", "tb5"];
  await assert.rejects(list.read(robots, 0, () => {}), /away/);
  assert.equal(list.recordings.length, 4);
  away = false;
  await list.read(robots, 1, () => {});
  assert.equal(list.recordings.length, 5);
  await list.read(["tb1"], 2, () => {});
  assert.deepEqual(list.recordings.map(({ robot }) => robot), ["tb1"]); // the others were removed
});

test("recordings are found by a part of the robot's name, and summed", () => {
  assert.equal(matches({ robot: "bob:Lift-1" }, " lift"), true);
  assert.equal(matches({ robot: "tb1" }, "lift"), false);
  assert.equal(sumOf([one("a"), one("b")]), "2 recordings, 2.0 KiB");
});
