import assert from "node:assert/strict";
import test from "node:test";

import { Journal } from "../../../../endpoints/dashboard/static/js/journal.js";

test("the newest entries are kept, the newest first", () => {
  const journal = new Journal();
  for (let i = 1; i <= 600; i++) journal.add(i, "tb1", `goal ${i}`, i % 2 === 0);
  assert.equal(journal.entries.length, 500);
  assert.deepEqual(journal.entries[0], { number: 600, time: 600, robot: "tb1", text: "goal 600", bad: true });
  assert.equal(journal.entries.at(-1).number, 101);
});
