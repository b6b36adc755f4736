/** The dashboard of one login: what the cloud says goes to the parts of the page, and what they are told to the cloud. */

import { BuildingView } from "./building_view.js";
import { CloudState } from "./cloud_state.js";
import { byId, say } from "./dom.js";
import { Fleet } from "./fleet.js";
import { FleetTable } from "./fleet_table.js";
import { FloorSwitch } from "./floor_switch.js";
import { isNew, mapMadeBy } from "./growing_map.js";
import { Journal } from "./journal.js";
import { LayerPanel } from "./layer_panel.js";
import { markLoads, showContainers, showEndpoints, showMachines } from "./load_panel.js";
import { MapChanges } from "./map_changes.js";
import { MapChoice } from "./map_choice.js";
import { ENDED_BADLY } from "./messages.js";
import { Orders } from "./orders.js";
import { Pages, closePage, openPage } from "./pages.js";
import { showPanel } from "./panels.js";
import { People } from "./people.js";
import { PlacePicker } from "./place_picker.js";
import { Poller } from "./poller.js";
import { createCardParts } from "./registry.js";
import { Refused, Unreachable } from "./rest.js";
import { RobotCard } from "./robot_card.js";
import { RobotList } from "./robot_list.js";
import { mayAdminister, mayDrive } from "./shared_robots.js";
import { Stage } from "./stage.js";
import { startText } from "./start_state.js";
import { toast, toastEnd } from "./toasts.js";
import { Tools } from "./tools.js";
import { Traffic } from "./traffic.js";
import { hasTraffic } from "./traffic_state.js";
import { Zones } from "./zones.js";

const REDRAW = 250; // ms between two looks at what lists and cards say

export class Dashboard {
  #rest;
  #cloud = new CloudState();
  #journal = new Journal();
  #grid = null;
  #layers = new LayerPanel((layer, on) => this.#switch(layer, on));
  #fleet;
  #table;
  #tools = new Tools((tool) => this.#tools.pick(tool));
  #stage;
  #orders;
  #list;
  #card;
  #maps;
  #floors;
  #changes;
  #people;
  #traffic;
  #zones;
  #building;
  #places;
  #pages;
  #poller;
  #starting = "";
  #expired;

  /** @param {import("./rest.js").Rest} rest @param {() => void} expired */
  constructor(rest, expired) {
    this.#rest = rest;
    this.#expired = expired;
    const events = { changed: () => this.#stage?.renderer.ask(), ended: this.#ended, told: this.#told };
    this.#fleet = new Fleet((robot) => rest.socketUrl(robot), this.#layers.shown, events);
    const pick = (point, reach) => [this.#people, this.#zones].forEach((part) => part.pickAt(point, reach));
    const drawing = () => [this.#places, this.#zones].find(({ isDrawing }) => isDrawing) ?? null;
    this.#stage = new Stage(this.#fleet, this.#tools, { select: (id) => this.#select(id), order: (pose) => this.#orders.pick(pose), pick, drawing });
    const told = { changed: () => this.#stage.renderer.ask(), failed: (error) => this.#failed(error), ask: (order, done) => this.#tell(order, done) };
    this.#orders = new Orders(this.#fleet, this.#tools, rest, { changed: () => this.#refresh(), ask: told.ask, release: () => this.#select(null) });
    this.#people = new People(rest, told);
    this.#traffic = new Traffic(rest, told, { colourOf: (id) => this.#stage.renderer.colourOfId(id), mayChange: (id) => mayAdminister(this.#fleet.link(id)?.robot) });
    const draws = (hint) => this.#tools.pause(hint);
    this.#zones = new Zones(rest, { ...told, draws });
    this.#building = new BuildingView(rest, this.#cloud, told);
    this.#places = new PlacePicker({ ...told, draws });
    this.#stage.renderer.put("places", this.#places);
    this.#changes = new MapChanges(rest, told, (rectangles) => (this.#stage.renderer.changes = rectangles));
    for (const layer of ["people", "traffic", "zones", "building"]) this.#switch(layer, true);
    this.#table = new FleetTable((robot) => this.#goTo(robot));
    this.#list = new RobotList(this.#fleet, (link) => this.#stage.renderer.colourOf(link), (id) => this.#select(id));
    const context = {
      rest, cloud: this.#cloud, fleet: this.#fleet, journal: this.#journal, failed: told.failed, ask: told.ask,
      goTo: (robot) => this.#goTo(robot), chooseMap: (id) => this.#maps.choose(id),
      pickPlaces: (...wanted) => this.#pickPlaces(...wanted),
    };
    this.#card = new RobotCard(this.#orders, createCardParts(context));
    this.#maps = new MapChoice(() => this.#otherMap());
    this.#floors = new FloorSwitch((id) => this.#maps.choose(id));
    this.#pages = new Pages(context);
    this.#poller = new Poller(() => this.#poll(), { well: () => this.#well(), failed: (error) => this.#failed(error) });
    setInterval(() => this.#refresh(), REDRAW);
  }

  begin() {
    return this.#poller.now();
  }

  // -- from the cloud

  async #poll() {
    await this.#cloud.look(this.#rest);
    this.#starting = startText(this.#cloud.health);
    this.#banner(this.#starting);
    await this.#cloud.read(this.#rest);
    const { me, isAdmin, maps, robots, own, containers, machines, endpoints } = this.#cloud;
    say(byId("user"), me.id);
    this.#table.take(robots);
    this.#maps.update(maps, robots, own);
    this.#floors.update(this.#cloud.buildings, this.#maps.current, maps);
    this.#cloud.map = this.#maps.current;
    await this.#showMap();
    await this.#changes.poll(this.#mapPath, maps, this.#maps.current);
    const map = maps.find(({ id }) => id === this.#maps.current);
    await this.#zones.poll(map ? this.#mapPath : null, this.#maps.version, map?.owner === me.id);
    await this.#showSharing();
    this.#fleet.update(robots.filter(({ map }) => map === this.#maps.current), own, this.#cloud.radii);
    showMachines(machines?.filter(({ state }) => state !== "starting") ?? null);
    showEndpoints(endpoints, machines);
    showContainers(containers, isAdmin);
    this.#refresh();
    this.#pages.update();
    this.#building.follow(this.#maps.current);
    this.#traffic.follow(this.#mapPath, hasTraffic(containers, me.id, this.#maps.current));
    // Last: a coordinator that is frozen answers late.
    await this.#people.poll(map ? this.#mapPath : null);
  }

  async #showMap() {
    const { current, version } = this.#maps;
    if (isNew(current)) return;
    if (this.#grid?.id === current && this.#grid?.version === version) return;
    const grid = current === null ? null : await this.#rest.grid(current);
    this.#grid = { id: current, version: grid?.version };
    this.#stage.show(current, grid);
  }

  /** Show whether the map that the selected robot makes is one with those of others. */
  async #showSharing() {
    const link = this.#fleet.selected;
    const map = await mapMadeBy(this.#rest, link);
    if (this.#fleet.selected === link) this.#card.showSharing(map); // else another one was selected
  }

  get #mapPath() {
    return `v1/maps/${encodeURIComponent(this.#maps.current)}`;
  }

  /** Show the map that the selected robot makes, or the first one. */
  #showNewMap() {
    const { current } = this.#maps;
    if (!isNew(current)) return;
    const link = this.#fleet.selected ?? this.#fleet.links.find(({ state }) => state.map.grid);
    const grid = link?.state.map.grid ?? null;
    if (this.#grid?.id === current && this.#grid.version === grid) return;
    this.#grid = { id: current, version: grid };
    this.#stage.show(current, grid);
  }

  #well() {
    this.#banner(this.#starting);
    markLoads(null);
  }

  #failed(error) {
    if (error instanceof Unreachable) markLoads(this.#cloud.at);
    if (error instanceof Refused && error.status === 401) this.#expired();
    else if (error instanceof Unreachable) this.#banner("The cloud does not answer. Trying again…");
    else if (error instanceof Refused) this.#banner(error.message);
    else throw error;
  }

  #ended = (link, goal) => {
    const bad = ENDED_BADLY.has(goal.code);
    this.#journal.add(this.#cloud.now, link.robot.id, goal.text ? `${goal.word}: ${goal.text}` : goal.word, bad);
    if (goal.id !== link.sent && link !== this.#fleet.selected) return; // somebody else sent it, and looks after it
    const said = goal.text ? `: ${goal.text}` : "";
    toast(`${link.robot.id} ${goal.word}${said}`, bad ? "bad" : { 3: "good" }[goal.code]);
  };

  #told = (link, text) => toast(`${link.robot.id}: ${text}`, "bad");

  // -- to the page

  #refresh() {
    const link = this.#fleet.selected;
    this.#showNewMap();
    for (const each of this.#fleet.links) each.held = this.#traffic.state.heldBy(each.robot.id);
    this.#list.update(this.#maps.current);
    this.#card.update(link, link ? this.#stage.renderer.colourOf(link) : "");
    this.#tools.apply(link?.robot.id ?? null, mayDrive(link?.robot)); // it may have been taken from the map or the user
    this.#stage.renderer.ask();
  }

  #banner(text) {
    byId("banner").hidden = !text;
    say(byId("banner"), text);
  }

  // -- from the user

  #otherMap() {
    this.#places.drop();
    this.#select(null);
    this.#fleet.close();
    this.#cloud.map = this.#maps.current;
    this.#poller.now();
    this.#pages.now();
  }

  /** Select a robot of the table, on its map. */
  #goTo({ id, map }) {
    closePage();
    this.#maps.choose(map);
    this.#select(id);
  }

  /** Pick places on the map for a page, which is shown again afterwards. */
  #pickPlaces(most, page, done) {
    closePage();
    showPanel(""); // on a phone, it would hide half of the map
    this.#places.begin(most, (places) => {
      openPage(page);
      done(places);
    });
  }

  #switch(layer, on) {
    const drawn = { people: this.#people, traffic: this.#traffic, zones: this.#zones, building: this.#building }[layer]?.layer;
    if (!drawn) this.#fleet.layer(layer, on);
    else if (on) this.#stage.renderer.put(layer, drawn);
    else this.#stage.renderer.remove(layer);
  }

  #select(id) {
    this.#fleet.select(id);
    if (id !== null) showPanel(""); // on a phone, it would hide the card
    this.#refresh();
    this.#orders.begin();
  }

  async #tell(order, done) {
    await toastEnd(order, done);
    this.#poller.now();
    this.#pages.now();
  }
}
