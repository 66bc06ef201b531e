// The parts of the scene and the values of one of them. What is entered goes to the server, one
// edit at a time and of those that wait only the newest; the server answers each.

import { makeField } from "./fields.js";

const $ = (id) => document.getElementById(id);
const STEPS = ["translate", "rotate", "scale"];

export class SceneTree {
  constructor(send) {
    this.send = send;
    this.version = null;
    this.items = [];
    this.chosen = "";
    this.fields = new Map();
    this.shape = "";
    this.waiting = null;
    this.isBusy = false;
    $("find").addEventListener("input", () => this.list());
    $("undo").addEventListener("click", () => send("undo"));
    $("redo").addEventListener("click", () => send("redo"));
    $("fields").addEventListener("submit", (event) => event.preventDefault());
    $("tree").addEventListener("keydown", (event) => this.step(event));
    $("steps").replaceChildren(...STEPS.map((step) => {
      const made = document.createElement("button");
      made.type = "button";
      made.textContent = `+ ${step}`;
      made.addEventListener("click", () => send("add step", { item: this.chosen, step }));
      return made;
    }));
  }

  // The state of the page: ask for what has changed.
  show(state) {
    $("undo").disabled = !state.undo;
    $("redo").disabled = !state.redo;
    $("prepares").hidden = !state.prepares;
    if (state.version === this.version) return;
    this.version = state.version;
    this.send("tree");
    if (this.chosen) this.send("fields", { item: this.chosen });
  }

  // After a new connection nothing is known and nothing on its way.
  forget() {
    this.version = null;
    this.isBusy = false;
    this.waiting = null;
  }

  tree({ items }) {
    this.items = items;
    if (!items.some(([path]) => path === this.chosen)) this.choose("");
    this.list();
  }

  list() {
    const words = $("find").value.trim().toLowerCase();
    const rows = [];
    let group = "";
    for (const [path, name, of, type] of this.items) {
      if (words && !`${name} ${of} ${type}`.toLowerCase().includes(words)) continue;
      if (of !== group) {
        const head = document.createElement("p");
        head.className = "group";
        head.textContent = group = of;
        rows.push(head);
      }
      const row = document.createElement("div"), told = document.createElement("span");
      row.setAttribute("role", "option");
      row.id = `part ${path}`;
      row.dataset.path = path;
      row.title = path;
      row.textContent = name;
      told.textContent = type.replaceAll("_", " ");
      row.append(told);
      row.setAttribute("aria-selected", path === this.chosen);
      row.addEventListener("click", () => this.choose(path));
      rows.push(row);
    }
    if (!rows.length) {
      const none = document.createElement("p");
      none.className = "muted";
      none.textContent = this.items.length ? "No part has that name." : "Loading the parts of the scene";
      rows.push(none);
    }
    $("tree").replaceChildren(...rows);
  }

  get rows() {
    return [...$("tree").querySelectorAll("[role=option]")];
  }

  // Up and down in the list.
  step(event) {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key], rows = this.rows;
    if (!by || !rows.length) return;
    event.preventDefault();
    const at = rows.findIndex((row) => row.dataset.path === this.chosen);
    const next = rows[Math.min(Math.max(at + by, 0), rows.length - 1)];
    this.choose(next.dataset.path);
    next.scrollIntoView({ block: "nearest" });
  }

  choose(path) {
    this.chosen = path;
    this.shape = "";
    for (const row of this.rows) row.setAttribute("aria-selected", row.dataset.path === path);
    $("tree").setAttribute("aria-activedescendant", path ? `part ${path}` : "");
    $("no-item").hidden = Boolean(path);
    $("steps").hidden = !/^(nodes|prototypes)\./.test(path) || path.endsWith(".light");
    $("item").textContent = this.items.find(([of]) => of === path)?.[1] ?? "Values";
    if (path) this.send("fields", { item: path });
    else $("fields").replaceChildren();
  }

  values({ item, fields }) {
    if (item !== this.chosen) return;
    // The same fields keep their elements, so that nobody is disturbed who is typing.
    const shape = JSON.stringify([item, fields.map((f) => [f.path, f.kind, f.choices])]);
    if (shape !== this.shape) {
      this.shape = shape;
      const made = fields.map((f) => makeField(f, (value) => this.edit(f.path, value)));
      this.fields = new Map(made.map((field) => [field.path, field]));
      $("fields").replaceChildren(...made.map(({ row }) => row));
      if (!fields.length) $("fields").textContent = "Nothing of it can be changed here.";
    }
    for (const field of fields) this.fields.get(field.path).set(field.value);
  }

  edit(path, value) {
    this.waiting = { item: this.chosen, path, value: JSON.stringify(value) };
    this.flush();
  }

  flush() {
    if (this.isBusy || !this.waiting) return;
    const next = this.waiting;
    this.waiting = null;
    this.isBusy = true;
    this.send("edit", next);
  }

  // The answer to an edit.
  answered({ path, why }) {
    this.isBusy = false;
    this.fields.get(path)?.tell(why);
    this.flush();
  }
}
