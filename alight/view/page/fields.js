// Fields of a form for the values of a scene, by what the server says that they take.

const decode = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const encode = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

// A picker knows colours up to white: brighter ones keep their brightness beside it.
const brightness = (color) => Math.max(1, ...color);
export const hex = (color) => `#${color.map((c) => Math.round(255 * encode(
  Math.min(1, Math.max(0, c / brightness(color))))).toString(16).padStart(2, "0")).join("")}`;
export const picked = (text, before) => [1, 3, 5].map((at) => Number((brightness(before)
  * decode(parseInt(text.slice(at, at + 2), 16) / 255)).toPrecision(5)));

const shown = (n) => String(Number(n.toPrecision(7)));

function element(tag, keys = {}, ...inside) {
  const made = Object.assign(document.createElement(tag), keys);
  made.append(...inside);
  return made;
}

const numeric = (label) => element("input", { type: "text", inputMode: "decimal", ariaLabel: label });
// "0,5" is half to much of the world; what is no number goes to the server as it is, and comes back
// with its words.
const read = (input) => {
  const text = input.value.trim().replace(/^([-+]?\d+),(\d+)$/, "$1.$2");
  return text !== "" && Number.isFinite(Number(text)) ? Number(text) : input.value;
};

// Each makes [elements, value getter, setter].
const MAKERS = {
  number(field, change) {
    const box = numeric(field.label), parts = [box];
    let slider = null;
    if (field.low !== null && field.high !== null && field.kind === "number") {
      slider = element("input", { type: "range", min: field.low, max: field.high,
        step: (field.high - field.low) / 200, ariaLabel: `${field.label}, slider` });
      slider.addEventListener("input", () => {
        box.value = shown(Number(slider.value));
        change();
      });
      parts.unshift(slider);
    }
    box.addEventListener("change", change);
    return [parts, () => read(box), (value) => {
      if (document.activeElement !== box) box.value = shown(value);
      if (slider && document.activeElement !== slider) slider.value = value;
    }];
  },
  vector(field, change) {
    const boxes = field.value.map((_, i) => numeric(`${field.label} ${i + 1}`));
    boxes.forEach((box) => box.addEventListener("change", change));
    return [boxes, () => boxes.map(read), (value) => value.forEach((n, i) => {
      if (document.activeElement !== boxes[i]) boxes[i].value = shown(n);
    })];
  },
  color(field, change) {
    const [boxes, get, set] = MAKERS.vector(field, change);
    const picker = element("input", { type: "color", ariaLabel: `${field.label}, colour` });
    let last = field.value;
    picker.addEventListener("input", () => {
      last = picked(picker.value, last);
      boxes.forEach((box, i) => { box.value = shown(last[i]); });
      change();
    });
    return [[picker, ...boxes], get, (value) => {
      last = value;
      set(value);
      if (document.activeElement !== picker) picker.value = hex(value);
    }];
  },
  choice(field, change) {
    const made = element("select", { ariaLabel: field.label }, ...field.choices.map(
      (name) => new Option(name.replaceAll("_", " "), name)));
    made.addEventListener("change", change);
    return [[made], () => made.value, (value) => { made.value = value; }];
  },
  truth(field, change) {
    const made = element("input", { type: "checkbox", ariaLabel: field.label });
    made.addEventListener("change", change);
    return [[made], () => made.checked, (value) => { made.checked = value; }];
  },
  told() {
    const made = element("output", { className: "muted" });
    return [[made], () => made.textContent, (value) => { made.textContent = value; }];
  },
};
MAKERS.whole = MAKERS.number;

// One row of the form: `send` is given the value.
export function makeField(field, send) {
  const wrong = element("p", { className: "wrong", hidden: true, id: `wrong-${field.path}` });
  const [parts, get, set] = MAKERS[field.kind](field, () => send(get()));
  const row = element("div", { className: `field ${field.kind}` },
    element("span", { className: "label", title: field.path,
      textContent: field.label.replaceAll("_", " ") }),
    element("span", { className: "inputs" }, ...parts), wrong);
  row.setAttribute("role", "group");
  row.setAttribute("aria-label", field.label);
  set(field.value);
  const tell = (why) => {
    wrong.hidden = !why;
    wrong.textContent = why ?? "";
    parts.forEach((part) => {
      if (why) {
        part.setAttribute("aria-invalid", "true");
        part.setAttribute("aria-describedby", wrong.id);
      } else part.removeAttribute("aria-invalid");
    });
  };
  return { row, set, tell, path: field.path };
}
