/** Client of the REST service with the token of the logged-in user. */

const ROOT = new URL("../../", import.meta.url); // of the cloud, which a proxy may serve below a path
const PAGE = 500;
const PATIENCE = 10_000; // ms
const PATIENCE_FOR_MAPS = 120_000;
const PATIENCE_FOR_FILES = 300_000; // of one GiB, perhaps

/** The cloud refused a request, with the reason, and the places of faults of zones. */
export class Refused extends Error {
  /** @param {number} status @param {string} detail @param {import("./zones_state.js").Fault[]} faults */
  constructor(status, detail, faults = []) {
    super(detail);
    this.status = status;
    this.faults = faults;
  }
}

/**
 * A handler of errors that replaces a refusal with this status by a value.
 * @template T
 * @param {number} status @param {(error: Refused) => T} value @returns {(error: unknown) => T}
 */
export function refused(status, value) {
  return (error) => {
    if (error instanceof Refused && error.status === status) return value(error);
    throw error;
  };
}

/** The cloud did not answer. */
export class Unreachable extends Error {}

/**
 * Send a request and read its response.
 * @template T
 * @param {string} path below the root of the cloud @param {RequestInit} options
 * @param {(response: Response) => Promise<T>} read
 * @param {number} patience ms
 * @returns {Promise<T>}
 */
async function ask(path, options, read, patience = PATIENCE) {
  const signal = AbortSignal.timeout(patience);
  try {
    const response = await fetch(new URL(path, ROOT), { cache: "no-store", credentials: "omit", signal, ...options });
    if (response.ok) return await read(response);
    const problem = await response.json().catch(() => ({})); // a proxy's error page, perhaps
    throw new Refused(response.status, problem.detail ?? `the cloud answered ${response.status}`, problem.faults);
  } catch (error) {
    throw error instanceof Refused ? error : new Unreachable("the cloud does not answer");
  }
}

const json = (response) => (response.status === 204 ? undefined : response.json());
const bytes = (response) => response.arrayBuffer();
const nothing = async () => undefined;
const tagged = async (response) => ({ tag: response.headers.get("ETag"), body: await response.json() });

/** Log in. @param {string} user @param {string} password @returns {Promise<string>} the token */
export async function logIn(user, password) {
  const body = JSON.stringify({ user, password });
  const headers = { "Content-Type": "application/json" };
  return (await ask("v1/tokens", { method: "POST", headers, body }, json)).token;
}

/** Name of the identity provider, if the cloud has one. @returns {Promise<string | null>} */
export async function providerName() {
  return (await ask("v1/oidc", {}, json)).name;
}

/**
 * Begin a login with it.
 * @param {boolean} again whether it asks who it is, also somebody who has logged in there
 * @returns {Promise<{url: string, state: string, nonce: string, verifier: string}>}
 */
export function beginLogin(again) {
  return ask(`v1/oidc/logins?again=${again}`, { method: "POST" }, json);
}

/** End it. @param {object} login @returns {Promise<{token: string, logout_url: string | null}>} */
export function endLogin(login) {
  const headers = { "Content-Type": "application/json" };
  return ask("v1/oidc/codes", { method: "POST", headers, body: JSON.stringify(login) }, json, 2 * PATIENCE);
}

export class Rest {
  #token;

  /** @param {string} token */
  constructor(token) {
    this.#token = token;
  }

  get #headers() {
    return { Authorization: `Bearer ${this.#token}` };
  }

  /** Revoke the token, also if the page is being closed. */
  logOut() {
    return ask("v1/tokens/current", { method: "DELETE", headers: this.#headers, keepalive: true }, nothing);
  }

  /** @param {string} path */
  get(path) {
    return ask(path, { headers: this.#headers }, json);
  }

  /** A resource and its tag. @param {string} path @returns {Promise<{tag: string | null, body: any}>} */
  tagged(path) {
    return ask(path, { headers: this.#headers }, tagged);
  }

  /**
   * Replace a resource, unless it is not the one with this tag any more.
   * @param {string} path @param {object} body @param {string | null} tag @param {string} type media type of the body
   */
  put(path, body, tag, type) {
    const headers = { ...this.#headers, "Content-Type": type, ...(tag && { "If-Match": tag }) };
    return ask(path, { method: "PUT", headers, body: JSON.stringify(body) }, json, PATIENCE_FOR_MAPS);
  }

  /**
   * Send a body; what it starts may take minutes.
   * @param {string} path @param {object} body
   */
  post(path, body) {
    const headers = { ...this.#headers, "Content-Type": "application/json" };
    return ask(path, { method: "POST", headers, body: JSON.stringify(body) }, json, PATIENCE_FOR_MAPS);
  }

  /** Change a resource by a JSON merge patch. @param {string} path @param {object} change */
  patch(path, change) {
    const headers = { ...this.#headers, "Content-Type": "application/merge-patch+json" };
    return ask(path, { method: "PATCH", headers, body: JSON.stringify(change) }, json);
  }

  /** @param {string} path */
  delete(path) {
    return ask(path, { method: "DELETE", headers: this.#headers }, nothing);
  }

  /** Fetch a file. @param {string} path @returns {Promise<Blob>} */
  blob(path) {
    return ask(path, { headers: this.#headers }, (response) => response.blob(), PATIENCE_FOR_FILES);
  }

  /** Fetch all items of a list, page by page. @param {string} path @returns {Promise<any[]>} */
  async list(path) {
    const found = [];
    let cursor = "";
    const query = path.includes("?") ? "&" : "?";
    do {
      const page = await this.get(`${path}${query}limit=${PAGE}${cursor && `&cursor=${encodeURIComponent(cursor)}`}`);
      found.push(...page.items);
      cursor = page.next;
    } while (cursor);
    return found;
  }

  /** Send a form with files. @param {string} path @param {FormData} body */
  upload(path, body) {
    return ask(path, { method: "POST", headers: this.#headers, body }, json, PATIENCE_FOR_FILES);
  }

  /**
   * A map and its cells.
   * @param {string} id @param {string} [wanted] one of its versions, also one that waits for a review; else the current one
   * @returns {Promise<import("./grid.js").Grid & {version: string}>}
   */
  async grid(id, wanted = "") {
    const path = `v1/maps/${encodeURIComponent(id)}`;
    const [{ resolution, width, height, origin, version }, data] = await Promise.all([
      this.get(wanted ? `${path}/versions/${wanted}` : path),
      ask(`${path}/cells${wanted && `?version=${wanted}`}`, { headers: this.#headers }, bytes, PATIENCE_FOR_MAPS),
    ]);
    const cells = new Int8Array(data);
    if (cells.length !== width * height) throw new Unreachable("the map was changed while it was read");
    const [x, y, theta] = origin;
    return { version, cells, info: { resolution, width, height, origin: { x, y, theta } } };
  }

  /**
   * Return the URL of an operator's WebSocket of a robot, which keeps no container alive. It is good once and soon: it
   * has a ticket instead of the token, because addresses are logged.
   * @param {string} robot
   */
  async socketUrl(robot) {
    const { ticket } = await ask("v1/tickets", { method: "POST", headers: this.#headers }, json);
    const query = new URLSearchParams({ robot, ticket, role: "operator", hold: "0", status: "1" });
    const url = new URL(`?${query}`, ROOT);
    url.protocol = url.protocol.replace("http", "ws");
    return url.href;
  }
}
