// Questions about a place of the picture: a traced path, drawn into it, and why a region is noisy.

const $ = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

const figure = (n) => (n === null ? "–" : n === 0 ? "0" : Math.abs(n) < 1e-3 || Math.abs(n) >= 1e4
  ? n.toExponential(1) : String(Number(n.toPrecision(3))));
const percent = (share) => `${(100 * share).toFixed(1)} %`;

// Three numbers, or the one that all are.
const colour = (numbers) => [...new Set(numbers.map(figure))].length === 1
  ? figure(numbers[0]) : numbers.map(figure).join("  ");

// A path of nodes, which may go on in another line behind a slash or a hyphen.
const broken = (path) => path.split(/(?<=[/-])/).flatMap((part) => [part, document.createElement("wbr")]);

function drawn(name, keys) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(keys)) made.setAttribute(key, value);
  return made;
}

function cells(row, ...texts) {
  const made = document.createElement("tr");
  made.append(...texts.map((text) => {
    const cell = document.createElement(row);
    cell.append(text);
    return cell;
  }));
  return made;
}

export class Inspector {
  constructor(send, picture) {
    Object.assign(this, { send, picture, pixel: null, box: null, sample: 0, kind: "picture" });
    $("trace").addEventListener("click", () => this.trace(0));
    $("trace-before").addEventListener("click", () => this.trace(-1));
    $("trace-after").addEventListener("click", () => this.trace(1));
    $("select").addEventListener("click", () => this.arm(!this.isArmed));
    $("deselect").addEventListener("click", () => this.select(null));
    $("why").addEventListener("click", () => this.askWhy());
    $("part").addEventListener("click", () => { send("region", this.box); this.select(null); });
    $("whole").addEventListener("click", () => send("whole"));
  }

  show(state) {
    const isNew = state.number !== this.number || String(state.size) !== this.size;
    this.kind = state.kind;
    this.number = state.number;
    this.size = String(state.size);
    $("of-trace").hidden = $("of-region").hidden = state.kind !== "scene";
    $("whole").hidden = !state.is_part;
    $("overlay").setAttribute("viewBox", `0 0 ${state.size[0]} ${state.size[1]}`);
    // Another view: what was found out is of the one before.
    if (isNew) {
      $("pixel").hidden = true;
      $("no-pixel").hidden = false;
      this.at(null);
      this.select(null);
    }
  }

  at(pixel) {
    this.pixel = pixel;
    this.sample = 0;
    this.draw("path", []);
    $("vertices").hidden = $("trace-told").hidden = true;
    $("sample").textContent = "sample 0";
    for (const id of ["trace", "trace-before", "trace-after"]) $(id).disabled = !pixel;
  }

  trace(by) {
    if (!this.pixel || this.kind !== "scene") return;
    this.sample = Math.max(0, this.sample + by);
    $("sample").textContent = `sample ${this.sample}`;
    $("trace").disabled = true;
    this.send("trace", { ...this.pixel, sample: this.sample });
  }

  traced(message) {
    const isMine = this.pixel && message.x === this.pixel.x && message.y === this.pixel.y;
    $("trace").disabled = !this.pixel;
    $("trace-told").hidden = !message.why;
    $("trace-told").textContent = message.why ?? "";
    if (message.why || !isMine || message.number !== this.number) return;
    $("no-trace").hidden = true;
    this.draw("path", message.lines.flatMap(({ kind, points: [[x1, y1], [x2, y2]] }) => [
      drawn("line", { class: `${kind} under`, x1, y1, x2, y2 }),
      drawn("line", { class: kind, x1, y1, x2, y2 }),
    ]));
    $("vertices").hidden = false;
    $("vertices").tBodies[0].replaceChildren(...message.vertices.map((vertex) => {
      const words = [vertex.bsdf.replaceAll("_", " "), vertex.lobe].filter(Boolean).join(", ");
      const place = document.createElement("span"), told = document.createElement("small");
      told.textContent = words;
      place.append(...broken(vertex.place), told);
      return cells("td", String(vertex.depth), place, colour(vertex.contribution));
    }), cells("td", "", "in all", colour(message.value)));
  }

  // Whether the next drag selects a region.
  arm(isArmed) {
    this.isArmed = isArmed;
    $("select").setAttribute("aria-pressed", isArmed);
    $("stage").classList.toggle("selecting", isArmed);
  }

  // The region between two places of the screen.
  between(x1, y1, x2, y2) {
    const [a, b] = [this.picture.nearest(x1, y1), this.picture.nearest(x2, y2)];
    this.select({ x: Math.min(a.x, b.x), y: Math.min(a.y, b.y),
      width: Math.abs(a.x - b.x) + 1, height: Math.abs(a.y - b.y) + 1 });
  }

  select(box) {
    this.box = box;
    $("deselect").hidden = !box;
    $("why").disabled = $("part").disabled = !box;
    $("because").hidden = true;
    $("region").textContent = box
      ? `${box.width} × ${box.height} pixels from column ${box.x}, row ${box.y}`
      : "Drag over the picture after that.";
    this.draw("region", box ? [drawn("rect", { class: "region under", ...box }),
      drawn("rect", { class: "region", ...box })] : []);
  }

  askWhy() {
    $("because").hidden = false;
    $("because").textContent = "Measuring; the first time for a scene it compiles a kernel.";
    $("because").scrollIntoView({ block: "nearest" });
    $("why").disabled = true;
    this.send("why", this.box);
  }

  because({ why, error, parts, tables }) {
    $("why").disabled = !this.box;
    if (!this.box) return;
    if (why) {
      $("because").textContent = why;
      return;
    }
    const told = document.createElement("p"), list = document.createElement("table");
    told.textContent = parts.length ? `A sample of a pixel is off by ${percent(error)}. Of its variance:`
      : "Nothing varies: there is no noise to explain.";
    list.append(...parts.map(([words, share, spread]) => cells("td", words.replaceAll("`", ""),
      `${percent(share)} ± ${(100 * spread).toFixed(1)}`)));
    $("because").replaceChildren(told, list, ...tables.map(([title, rows]) => {
      const more = document.createElement("details"), head = document.createElement("summary");
      const body = document.createElement("table");
      head.textContent = title;
      body.append(...rows.map((row) => cells("td", ...row)));
      more.append(head, body);
      return more;
    }));
    $("because").scrollIntoView({ block: "nearest" });
  }

  draw(what, elements) {
    let group = $("overlay").querySelector(`[data-of=${what}]`);
    if (!group) {
      group = drawn("g", { "data-of": what });
      $("overlay").append(group);
    }
    group.replaceChildren(...elements);
  }
}
