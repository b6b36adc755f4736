/** Page with the user's tasks on the shown map: a column for each state; add, cancel, and do one again. */

import { make, say, show } from "../dom.js";
import { isNew } from "../growing_map.js";
import { addPage } from "../registry.js";
import { toast } from "../toasts.js";
import { TaskForm } from "./task_form.js";
import { TaskList } from "./task_list.js";
import { COLUMNS, againOf, ageOf, columnOf, isOpen, notesOf, titleOf } from "./task_words.js";

const NO_MAP = "Choose a map above: tasks are done on a map.";

class TasksPage {
  #context;
  #list;
  #form;
  #note = make("p", { className: "muted", role: "status" });
  #columns = COLUMNS.map((column) => ({
    column,
    count: make("span", { className: "count" }),
    list: make("ul", { className: "list" }),
    none: make("p", { className: "empty", textContent: "None" }),
  }));
  #board = make("div", { className: "board" });
  element = make("div", { className: "page-parts" });

  /** @param {import("../registry.js").Context} context */
  constructor(context) {
    this.#context = context;
    this.#list = new TaskList(context.rest);
    this.#form = new TaskForm((task) => this.#add(task), () => context.cloud.now, (most, done) => context.pickPlaces(most, "tasks", done));
    this.#board.append(...this.#columns.map(({ column, count, list, none }) =>
      make("section", { className: "column", "aria-label": column.title, "data-state": column.id },
        make("h3", {}, `${column.title} `, count), list, none)));
    this.element.append(this.#note, this.#form.element, this.#board);
  }

  get #path() {
    const { map } = this.#context.cloud;
    return map === null || isNew(map) ? null : `v1/maps/${encodeURIComponent(map)}/tasks`;
  }

  async poll() {
    await this.#list.read(this.#path, performance.now() / 1000);
    this.#show();
  }

  #show() {
    const { map, now } = this.#context.cloud;
    say(this.#note, this.#path ? `Your tasks on ${map}. The cloud gives each to the best of your robots.` : NO_MAP);
    this.#form.element.hidden = this.#board.hidden = !this.#path;
    for (const { column, count, list, none } of this.#columns) {
      const { count: all, tasks } = columnOf(column, this.#list.tasks);
      say(count, all > tasks.length ? `${tasks.length} of ${all}` : String(all || ""));
      none.hidden = all > 0;
      show(list, tasks, ({ id }) => id, (task) => this.#create(task), (item, task) => this.#fill(item, task, now));
    }
  }

  #create({ id }) {
    const act = make("button", { className: "button", type: "button", onclick: () => this.#act(id) });
    const confirm = make("button", { className: "button", type: "button", textContent: "Confirm", onclick: () => this.#confirm(id) });
    const robot = make("button", { className: "link", type: "button", onclick: () => this.#goToRobot(id) });
    return make("li", { className: "review task" }, make("p", { className: "name" }), make("p", { className: "task-who" }, robot, make("span", { className: "muted" })),
      make("p", { className: "muted" }), make("p", { className: "error" }), make("div", { className: "actions" }, act, confirm));
  }

  #fill(item, task, now) {
    const [title, who, notes, reason, actions] = item.children;
    const [robot, age] = who.children;
    say(title, titleOf(task));
    robot.hidden = !task.robot;
    say(robot, task.robot ?? "");
    say(age, ageOf(task, now));
    say(notes, notesOf(task, now));
    say(reason, task.reason);
    const [act, confirm] = actions.children;
    confirm.hidden = !task.needs_confirmation;
    confirm.setAttribute("aria-label", `Confirm: ${titleOf(task)}`);
    act.classList.toggle("stop", isOpen(task));
    act.hidden = !isOpen(task) && task.trip !== null; // the cloud adds these itself
    say(act, isOpen(task) ? "Cancel" : task.state === "done" ? "Do again" : "Retry");
    act.setAttribute("aria-label", `${act.textContent}: ${titleOf(task)}`);
  }

  #task(id) {
    return this.#list.tasks.find((task) => task.id === id);
  }

  #goToRobot(id) {
    const robot = this.#context.cloud.robots.find((one) => one.id === this.#task(id).robot);
    if (robot) this.#context.goTo(robot);
    else toast("This robot is no longer in the list of yours", "bad");
  }

  #act(id) {
    const task = this.#task(id);
    const { rest, ask, cloud } = this.#context;
    if (isOpen(task)) return ask(rest.delete(`${this.#path}/${encodeURIComponent(id)}`), "The task is cancelled");
    return ask(rest.post(this.#path, againOf(task, cloud.now)), "The task waits again");
  }

  #confirm(id) {
    const { rest, ask } = this.#context;
    return ask(rest.post(`${this.#path}/${encodeURIComponent(id)}/confirm`, {}), "The robot goes on");
  }

  /** Add a task; the form shows why it is refused. */
  async #add(task) {
    await this.#context.rest.post(this.#path, task);
    await this.#context.ask(Promise.resolve(), "The task is added");
  }
}

addPage({ id: "tasks", title: "Tasks", order: 1, create: (context) => new TasksPage(context) });
