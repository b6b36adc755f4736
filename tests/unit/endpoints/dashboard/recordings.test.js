import assert from "node:assert/strict";
import test from "node:test";

import { fileOf, limitsOf, noteOf, stateOf, titleOf } from "../../../../endpoints/dashboard/static/js/recordings.js";

const IDLE = { recording: "", left: 0, ring_minutes: 0, messages: 9, lost: 0, problem: "" };

test("a recording is titled by the time of its begin", () => {
  assert.equal(titleOf("20261126T224142Z"), "2026-11-26 22:41:42 UTC");
  assert.equal(titleOf("20261126T224142Z-2"), "2026-11-26 22:41:42 UTC, part 2");
  assert.equal(titleOf("<b>"), "<b>");
});

test("a recording that is not complete is told from the one in progress", () => {
  const one = { id: "a", size: 3 * 1024 ** 2, finished: false };
  assert.equal(noteOf({ ...one, finished: true }, "a"), "3.0 MiB");
  assert.equal(noteOf(one, "a"), "3.0 MiB, in progress");
  assert.equal(noteOf(one, ""), "3.0 MiB, not complete");
  assert.equal(noteOf(one, null), "3.0 MiB, not complete");
});

test("the recorder is described in words, with its problem", () => {
  assert.equal(stateOf(IDLE), "Not recording");
  assert.equal(stateOf({ ...IDLE, ring_minutes: 5 }), "Not recording, the ring keeps 5 minutes");
  assert.equal(stateOf({ ...IDLE, recording: "a", left: 61, lost: 1 }), "Recording, ends by itself in 2 minutes, 1 message lost");
  assert.equal(stateOf({ ...IDLE, lost: 1 }), "Not recording");
  assert.equal(stateOf({ ...IDLE, problem: "the disk is full" }), "Not recording: the disk is full");
});

test("a user is told what the role does not permit", () => {
  const said = ["look", "drive", "administer"].map((role) => limitsOf({ id: "ann:tb1", role }));
  assert.match(said[0], /not start, stop or delete/);
  assert.match(said[1], /^You may not delete recordings of ann:tb1$/);
  assert.equal(said[2], "");
});

test("the file of a recording of another user's robot has a name that every system takes", () => {
  assert.equal(fileOf("ann:tb1", "ring"), "ann-tb1-ring.mcap");
});
