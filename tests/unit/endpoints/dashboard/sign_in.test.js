import assert from "node:assert/strict";
import test from "node:test";

const kept = new Map();
const sent = [];
globalThis.sessionStorage = {
  getItem: (key) => kept.get(key) ?? null,
  setItem: (key, value) => kept.set(key, value),
  removeItem: (key) => kept.delete(key),
};
globalThis.location = { search: "", pathname: "/dashboard/" };
globalThis.history = { replaceState: (_state, _title, path) => sent.push(path) };
globalThis.fetch = async (url, options) => {
  sent.push(JSON.parse(options.body));
  return new Response(JSON.stringify({ token: "t", logout_url: null }), { status: 201 });
};
const { endSignIn, takeReturn } = await import("../../../../endpoints/dashboard/static/js/sign_in.js");

function begin() {
  kept.set("ppaas-sign-in", JSON.stringify({ state: "s", nonce: "n", verifier: "v" }));
  sent.length = 0;
}

test("only what a provider puts into the address is taken, and removed from it", () => {
  for (const search of ["", "?code=c", "?state=s", "?robot=tb1"]) {
    location.search = search;
    assert.equal(takeReturn(), null);
  }
  assert.deepEqual(sent, []);
  location.search = "?code=c&state=s";
  assert.equal(takeReturn().get("code"), "c");
  assert.deepEqual(sent, ["/dashboard/"]);
});

test("a login that this tab began ends with what it kept, once", async () => {
  begin();
  const found = new URLSearchParams("code=c&state=s&iss=https://login.example");
  assert.equal((await endSignIn(found)).token, "t");
  assert.deepEqual(sent, [{ code: "c", nonce: "n", verifier: "v", iss: "https://login.example" }]);
  await assert.rejects(endSignIn(found), /not begun in this tab/);
});

test("a login that another page began sends nothing", async () => {
  begin();
  await assert.rejects(endSignIn(new URLSearchParams("code=c&state=other")), /not begun in this tab/);
  await assert.rejects(endSignIn(new URLSearchParams("code=c&state=s")), /not begun in this tab/);
  assert.deepEqual(sent, []);
});

test("the refusal of a provider is shown", async () => {
  begin();
  await assert.rejects(endSignIn(new URLSearchParams("error=access_denied&state=s")), /refused: access_denied/);
  begin();
  const worded = new URLSearchParams("error=access_denied&error_description=no+more&state=s");
  await assert.rejects(endSignIn(worded), /refused: no more/);
});
