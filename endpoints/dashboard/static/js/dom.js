/** Elements of the page. Text is never parsed as HTML, whatever names users choose. */

/** The element of an id. @param {string} id @returns {HTMLElement} */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element ${id}`);
  return found;
}

/**
 * A new element. Properties with a hyphen, and role, become attributes.
 * @param {string} tag @param {Record<string, unknown>} properties @param {...(Node | string)} children
 */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.includes("-") || name === "role") element.setAttribute(name, String(value));
    else element[name] = value;
  }
  element.append(...children);
  return element;
}

/**
 * Update a list to show these things; things that stay keep their elements and thus the focus.
 * @template T
 * @param {HTMLElement} parent
 * @param {T[]} things
 * @param {(thing: T) => string} keyOf
 * @param {(thing: T) => HTMLElement} create
 * @param {(element: HTMLElement, thing: T) => void} update
 */
export function show(parent, things, keyOf, create, update) {
  const before = new Map([...parent.children].map((child) => [child.dataset.key, child]));
  things.forEach((thing, i) => {
    const key = keyOf(thing);
    const element = before.get(key) ?? create(thing);
    before.delete(key);
    element.dataset.key = key;
    update(element, thing);
    if (parent.children[i] !== element) parent.insertBefore(element, parent.children[i] ?? null);
  });
  for (const gone of before.values()) gone.remove();
}

/** Set text only if it changed, so that screen readers do not repeat it. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
