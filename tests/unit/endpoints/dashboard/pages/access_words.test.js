import assert from "node:assert/strict";
import test from "node:test";

import { DAY, expiryText, namesOf, scopeText, unknownPassword, variablesOf } from "../../../../../endpoints/dashboard/static/js/pages/access_words.js";

test("what a token may do, and how long", () => {
  assert.equal(scopeText({ scope: null }), "All that its user may do");
  assert.equal(scopeText({ scope: { role: "look", robots: ["tb1", "hall-*"] } }), "Looks at tb1, hall-*");
  assert.equal(expiryText({ expires: 100 }, 100), "expired");
  assert.equal(expiryText({ expires: 100 + 30.5 * DAY }, 100), "good for 30 days");
  assert.equal(expiryText({ expires: 100 + 1.5 * DAY }, 100), "good for 36 h");
});

test("names are read from what people write", () => {
  assert.deepEqual(namesOf(" a, b  c,,\n"), ["a", "b", "c"]);
  assert.deepEqual(namesOf(""), []);
});

test("a robot gets its cloud and its token as variables", () => {
  assert.equal(variablesOf("https://cloud/ppaas", "secret"), "PPAAS_URL=https://cloud/ppaas\nPPAAS_TOKEN=secret\n");
});

test("a password that locks is long and another one each time", () => {
  const [one, other] = [unknownPassword(), unknownPassword()];
  assert.match(one, /^[0-9a-f]{48}$/);
  assert.notEqual(one, other);
});
