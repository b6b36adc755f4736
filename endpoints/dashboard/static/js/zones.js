/** Zones of the shown map: reads them, lets the map's owner draw and change them, and saves them. */

import { byId } from "./dom.js";
import { refused, Refused } from "./rest.js";
import { readTheme } from "./theme.js";
import { toast } from "./toasts.js";
import { Drawing } from "./zone_shapes.js";
import { ZonesLayer } from "./zones_layer.js";
import { ZonesPanel } from "./zones_panel.js";
import { ZonesState } from "./zones_state.js";

const PERIOD = 10_000; // ms between two looks at which are in force
const PAUSE = 400; // ms without a change after which a draft is checked
const HINT = "Click on the map to draw; Escape cancels";
const CONFLICTS = new Set([409, 412]);
const NONE = { body: null, tag: null };

export class Zones {
  state = new ZonesState();
  layer = new ZonesLayer(this.state, readTheme());
  #panel;
  #rest;
  #events;
  /** Path of the zones of the shown map. @type {string | null} */ #path = null;
  #version = "";
  #looked = -Infinity;
  /** Whether zones are being saved: those that are read meanwhile may be the user's own. */
  #isSaving = false;
  /** Timer of the next check of the draft. */ #check = 0;

  /** @param {import("./rest.js").Rest} rest @param {{changed: () => void, draws: (hint: string) => void}} events */
  constructor(rest, events) {
    this.#rest = rest;
    this.#events = events;
    this.#panel = new ZonesPanel({
      pick: (index) => this.#pick(index === this.state.picked ? null : index),
      colourOf: (kind) => this.layer.colourOf(kind),
      draw: (kind, isLine, isPoint) => this.#draw(new Drawing(kind, isLine, isPoint)),
      end: () => this.#end(),
      undo: () => this.#undo(),
      cancel: () => this.#draw(null),
      replace: (index, zone) => this.#change(() => this.state.replace(index, zone)),
      remove: (index) => this.#change(() => this.state.remove(index)),
      zone: (name) => this.#change(() => this.state.setTimeZone(name)),
      save: () => this.#save().finally(() => (this.#isSaving = false)),
      discard: () => this.#change(() => this.state.discard()),
    });
  }

  /** Whether the user draws a zone now, so that clicks on the map are corners. */
  get isDrawing() {
    return this.layer.drawing !== null;
  }

  /**
   * Read the zones of a map, if it was changed or some time has passed.
   * @param {string | null} path of the map, or null for one that is being made @param {string} version @param {boolean} mayEdit
   */
  async poll(path, version, mayEdit) {
    const zones = path && `${path}/zones`;
    if (zones !== this.#path) this.#leave(zones);
    this.state.mayEdit = mayEdit;
    const now = performance.now();
    if (!zones || this.#isSaving || (version === this.#version && now - this.#looked < PERIOD)) return this.#show();
    const answer = await this.#rest.tagged(zones).catch(refused(404, () => NONE));
    if (zones !== this.#path || this.#isSaving) return; // another map was chosen meanwhile, or zones are being saved
    this.#version = version;
    this.#looked = now;
    this.state.take(answer.body, answer.tag);
    this.#show();
  }

  /** Pick the zone at a point of the map, or none. @param {{x: number, y: number}} point @param {number} reach [m] */
  pickAt(point, reach) {
    this.#pick(this.state.at(point, reach));
    if (this.state.picked !== null) this.#panel.reveal(this.state.picked);
  }

  /** Take a click on the map while the user draws. @param {{x: number, y: number}} point @param {number} reach [m] */
  click(point, reach) {
    if (this.layer.drawing.click(point, reach, performance.now())) this.#end();
    else this.#show();
  }

  /** Take the place of the pointer while the user draws. @param {{x: number, y: number} | null} point */
  hover(point) {
    this.layer.drawing.hover = point;
    this.#events.changed();
  }

  /** Take a key while the user draws; return whether it has a meaning. @param {string} key @param {{x: number, y: number}} middle of the map */
  key(key, middle) {
    const meanings = { Enter: () => this.#end(), Escape: () => this.#draw(null), Backspace: () => this.#undo(), " ": () => this.click(middle, 0) };
    if (!this.isDrawing || !(key in meanings)) return false;
    meanings[key]();
    return true;
  }

  /** Leave the zones of a map: what was not saved is lost, and the user is told. */
  #leave(path) {
    if (this.state.isChanged) toast("The changes of zones were not saved: another map is shown", "bad");
    this.#path = path;
    this.#version = "";
    this.#looked = -Infinity;
    this.state.clear();
    this.#draw(null);
  }

  #pick(index) {
    this.state.picked = index;
    this.#show();
  }

  #draw(drawing) {
    this.layer.drawing = drawing;
    byId("map").toggleAttribute("data-drawing", drawing !== null);
    this.#events.draws(drawing ? HINT : "");
    if (drawing) byId("map").focus({ preventScroll: true });
    this.#show();
  }

  #undo() {
    this.layer.drawing.undo();
    this.#show();
  }

  /** End the drawing: what was drawn becomes a zone, unless corners are missing. */
  #end() {
    const { kind, geometry } = this.layer.drawing;
    if (!geometry) return this.#show();
    this.#change(() => this.state.add(this.state.proposal(kind, geometry)));
    this.#draw(null);
    this.#panel.reveal(this.state.picked);
  }

  #change(change) {
    change();
    this.#show();
    clearTimeout(this.#check);
    if (this.state.isChanged) this.#check = setTimeout(() => this.#checkDraft(), PAUSE);
  }

  /** Ask the cloud what is wrong with the draft, and mark it on the map. That it cannot be asked is told by the next poll. */
  async #checkDraft() {
    const [path, { draft }] = [this.#path, this.state];
    if (!draft || this.#isSaving) return;
    const found = await this.#rest.post(`${path}/check`, this.state.body).catch((error) => error);
    if (draft !== this.state.draft || this.#isSaving) return; // it was changed, saved or discarded meanwhile
    if (found instanceof Refused) this.state.judge({ problem: found.message, faults: found.faults });
    else if (!(found instanceof Error)) this.state.judge(found);
    this.#show();
  }

  async #save() {
    this.#isSaving = true;
    clearTimeout(this.#check);
    const { body, base } = this.state;
    const path = this.#path;
    let warnings;
    try {
      ({ warnings = [] } = await this.#rest.put(path, body, base, "application/geo+json"));
    } catch (error) {
      if (path !== this.#path) return;
      this.state.judge({ problem: error.message, faults: error.faults });
      if (error instanceof Refused && CONFLICTS.has(error.status)) await this.#lookAgain(path);
      else this.#show();
      return;
    }
    for (const warning of warnings) toast(warning, "bad");
    toast("The zones are saved: robots heed them from now on", "good");
    await this.#lookAgain(path, () => this.state.discard());
  }

  /** Read the zones now. If that fails they are read by the next poll, which tells why. */
  async #lookAgain(path, before = () => {}) {
    this.#looked = -Infinity;
    const answer = await this.#rest.tagged(path).catch(() => null);
    if (path !== this.#path) return;
    before();
    if (answer) this.state.take(answer.body, answer.tag);
    this.#show();
  }

  #show() {
    this.#panel.update(this.state, this.layer.drawing);
    this.#events.changed();
  }
}
