/** Polls the cloud while the page is visible. */

const PERIOD = 2000; // ms

export class Poller {
  #timer = 0;
  #busy = false;
  #poll;
  #events;

  /**
   * @param {() => Promise<void>} poll
   * @param {{well: () => void, failed: (error: Error) => void}} events
   */
  constructor(poll, events) {
    this.#poll = poll;
    this.#events = events;
    document.addEventListener("visibilitychange", () => this.now());
  }

  /** Poll now, and periodically from then on. */
  async now() {
    clearTimeout(this.#timer);
    if (this.#busy || document.visibilityState !== "visible") return;
    this.#busy = true;
    try {
      await this.#poll();
      this.#events.well();
    } catch (error) {
      this.#events.failed(error);
    } finally {
      this.#busy = false;
      this.#timer = setTimeout(() => this.now(), PERIOD);
    }
  }
}
