/** Pages beside the map, and parts of the card of a robot. Modules add theirs when they are loaded, so that no list of them grows. */

/**
 * What pages and parts are made with.
 * @typedef {{
 *   rest: import("./rest.js").Rest, cloud: import("./cloud_state.js").CloudState, fleet: import("./fleet.js").Fleet,
 *   journal: import("./journal.js").Journal, failed: (error: Error) => void,
 *   ask: (order: Promise<unknown>, done: string) => Promise<void>, goTo: (robot: {id: string, map: string}) => void,
 *   chooseMap: (id: string) => void,
 *   pickPlaces: (most: number, page: string, done: (places: import("./geometry.js").Point[]) => void) => void,
 * }} Context
 */

/**
 * A page. `poll` is called every two seconds while it is open; `update` after each look at the cloud, also while it is
 * closed; `count` is shown beside its title in the bar.
 * @typedef {{element: HTMLElement, poll?: () => Promise<void>, update?: () => void, count?: number}} Page
 */

/** @typedef {{id: string, title: string, order: number, create: (context: Context) => Page}} PageEntry */

/** Part of the card; `update` gets the selected robot, or null. @typedef {{element: HTMLElement, update: (link: import("./robot_link.js").RobotLink | null) => void}} CardPart */

/** @type {PageEntry[]} */
const pages = [];
/** @type {{order: number, create: (context: Context) => CardPart}[]} */
const parts = [];

const byOrder = (a, b) => a.order - b.order;

/** Add a page; those of a smaller `order` come first. @param {PageEntry} page */
export function addPage(page) {
  pages.push(page);
}

/** Add a part of the card of the selected robot. @param {number} order @param {(context: Context) => CardPart} create */
export function addCardPart(order, create) {
  parts.push({ order, create });
}

/** @returns {PageEntry[]} */
export function pagesInOrder() {
  return [...pages].sort(byOrder);
}

/** @param {Context} context @returns {CardPart[]} */
export function createCardParts(context) {
  return [...parts].sort(byOrder).map(({ create }) => create(context));
}
