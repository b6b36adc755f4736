/** Panel of the shown map: changes that wait for a review, and merging with another map. */

import { byId, make, say, show } from "./dom.js";
import { plural } from "./format.js";
import { NAME_OF_MAP, orderForm } from "./order_form.js";

const POSE_GRAPH = "posegraph";

/** What a version changes, in words. @param {object} review */
export function changeOf({ occupied, free, known, unknown }) {
  const parts = [[occupied, "occupied"], [free, "free"], [known, "known"], [unknown, "unknown"]];
  const some = parts.filter(([count]) => count).map(([count, word]) => `${plural(count, "cell")} ${word}`);
  return some.length ? `Now ${some.join(", ")}` : "No cell changes";
}

/** Maps with which one can be merged: both must have a pose graph. @param {object[]} maps @param {string | null} id */
export function partnersOf(maps, id) {
  const mapped = maps.filter(({ parts }) => parts.includes(POSE_GRAPH));
  return mapped.some((map) => map.id === id) ? mapped.filter((map) => map.id !== id) : [];
}

/**
 * An item for a version that waits, with what the user may decide.
 * @param {object} review @param {{approve: (review: object, why: string) => void, refuse: (review: object, why: string) => void}} orders
 */
export function createReview(review, orders) {
  const why = make("input", { name: "why", maxLength: 200, placeholder: "Reason", "aria-label": "Reason" });
  const order = (name, className, textContent) =>
    make("button", { className, type: "button", textContent, onclick: () => orders[name](review, why.value) });
  return make("li", { className: "review" }, make("p", { className: "name" }), make("p", { className: "muted" }), why,
    make("div", { className: "actions" }, order("approve", "button", "Approve"), order("refuse", "button stop", "Refuse")));
}

/** Say what a version changes. @param {HTMLElement} item @param {object} review */
export function fillReview(item, review) {
  const [title, change] = item.children;
  say(title, `${review.number} by ${review.author}${review.message && `: ${review.message}`}`);
  say(change, changeOf(review) + (review.outdated ? ". Made from a version that is not the current one" : ""));
}

export class MapPanel {
  #panel = byId("panel-map");
  #reviews = byId("reviews");
  #orders;
  #merge;

  /**
   * @param {{approve: (review: object, why: string) => void, refuse: (review: object, why: string) => void,
   *          merge: (other: string, into: string) => Promise<void>}} orders
   */
  constructor(orders) {
    this.#orders = orders;
    this.#merge = this.#mergeForm();
    byId("merge").append(make("summary", { textContent: "Merge with another map" }), this.#merge);
  }

  /** @param {object[]} reviews that wait @param {object[]} partners maps to merge with */
  update(reviews, partners) {
    this.#panel.hidden = !reviews.length && !partners.length;
    say(byId("review-count"), reviews.length ? String(reviews.length) : "");
    show(this.#reviews, reviews, ({ number }) => String(number), (review) => createReview(review, this.#orders), fillReview);
    byId("merge").hidden = !partners.length;
    const select = this.#merge.querySelector("select");
    show(select, partners, ({ id }) => id, ({ id }) => make("option", { value: id, textContent: id }), () => {});
  }

  #mergeForm() {
    const select = make("select", { name: "with" });
    const into = make("input", { name: "into", ...NAME_OF_MAP });
    const fields = [make("label", {}, "With", select), make("label", {}, "New name", into)];
    return orderForm("Merge with another map", "Merge", () => this.#orders.merge(select.value, into.value), ...fields);
  }
}
