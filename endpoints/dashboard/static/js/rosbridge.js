/** One WebSocket that speaks rosbridge v2. */

/**
 * @typedef {{
 *   opened: () => void,
 *   closed: (reason: string) => void,
 *   heard: (topic: string, message: any) => void,
 *   told: (text: string) => void,
 * }} Listener
 */

const CLEAN = 1000;

export class Rosbridge {
  #socket;
  #closed = false;
  /** Calls without an answer, by id. @type {Map<string, (values: any) => void>} */ #calls = new Map();
  #count = 0;

  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.#socket = new WebSocket(url);
    this.#socket.onopen = () => (this.#closed ? this.#socket.close(CLEAN) : listener.opened());
    this.#socket.onmessage = ({ data }) => this.#take(data, listener);
    this.#socket.onclose = ({ reason }) => {
      if (!this.#closed) listener.closed(reason);
    };
  }

  get open() {
    return this.#socket.readyState === WebSocket.OPEN;
  }

  /**
   * @param {string} topic @param {string} type @param {number} throttle least time between two messages [ms]
   * @param {number} queue number of messages that may wait
   */
  subscribe(topic, type, throttle, queue = 1) {
    this.#send({ op: "subscribe", topic, type, throttle_rate: throttle, queue_length: queue });
  }

  /** @param {string} topic */
  unsubscribe(topic) {
    this.#send({ op: "unsubscribe", topic });
  }

  /** @param {string} topic @param {object} msg @returns {boolean} whether it was sent */
  publish(topic, msg) {
    return this.#send({ op: "publish", topic, msg });
  }

  /**
   * Call a service. The promise is never settled if the socket is closed before the answer.
   * @param {string} service @param {object} args @returns {Promise<any>} what it answers; nothing if it failed
   */
  call(service, args) {
    const id = `call-${(this.#count += 1)}`;
    return new Promise((resolve) => {
      this.#calls.set(id, resolve);
      this.#send({ op: "call_service", service, args, id });
    });
  }

  #answered({ id, result, values }) {
    this.#calls.get(id)?.(result === false ? {} : values);
    this.#calls.delete(id);
  }

  /** Close the socket without further events to the listener; one that is being opened, once it is open. */
  close() {
    this.#closed = true;
    // Browsers log an error for a socket that is closed before.
    if (this.#socket.readyState !== WebSocket.CONNECTING) this.#socket.close(CLEAN);
  }

  #send(frame) {
    if (!this.open) return false;
    this.#socket.send(JSON.stringify(frame));
    return true;
  }

  #take(data, listener) {
    if (this.#closed) return;
    const frame = JSON.parse(data);
    if (frame.op === "publish") listener.heard(frame.topic, frame.msg);
    else if (frame.op === "service_response") this.#answered(frame);
    else if (frame.op === "status") listener.told(String(frame.msg));
  }
}
