// The page: events go to the server, what the server sends is shown. Nothing is decided here.

import { Command } from "./command.js";
import { Connection } from "./connection.js";
import { Focus } from "./focus.js";
import { Gathered, listenToKeys, listenToPointer } from "./gestures.js";
import { Inspector } from "./inspect.js";
import { makePanel, showPixel } from "./panel.js";
import { Picture } from "./picture.js";
import { SceneTree } from "./scene.js";
import { Tabs } from "./tabs.js";

const $ = (id) => document.getElementById(id);
const picture = new Picture();
const show = makePanel(() => command.ask());
const tabs = new Tabs();
let state = { kind: "picture", layers: [], size: [1, 1], exposure: 0, tone_map: "none" };
let frames = 0;

const connection = new Connection({
  open(isOpen) {
    document.body.dataset.connected = isOpen;
    tree.forget();
    if (isOpen) return;
    $("phase").textContent = "no connection; trying again";
    $("phase").className = "bad";
  },
  state(message) {
    if (message.number !== state.number) picture.mark(null);
    // Who opens two pictures wants to compare them.
    if (message.against && message.kind !== "scene" && !state.title) tabs.open("Display");
    state = message;
    picture.resize(state.size);
    picture.compare(state.against, state.way, Boolean(state.contrast));
    show(state);
    inspector.show(state);
    tabs.offer("Scene", state.kind === "scene");
    if (state.kind === "scene") {
      tree.show(state);
      focus.show(state);
      command.show(state);
    }
  },
  frame(message) {
    picture.draw(message);
    document.body.dataset.frames = ++frames;
    if (message.picture === 0) document.body.dataset.drawn = message.number;
  },
  pixel: showPixel,
  trace: (message) => inspector.traced(message),
  why: (message) => inspector.because(message),
  focus: (message) => focus.tell(message),
  command: (message) => command.tell(message),
  tree: (message) => tree.tree(message),
  fields: (message) => tree.values(message),
  edited: (message) => tree.answered(message),
  wrong: (message) => tree.answered(message),
  refused({ why }) { console.warn(why); },
});

const send = (word, keys) => connection.send(word, keys);
const tree = new SceneTree(send), inspector = new Inspector(send, picture);
const focus = new Focus(send), command = new Command(send);
const gathered = new Gathered(send);
const moves = (word, keys) => { if (ui.isScene()) gathered.add(word, keys); };

const ui = {
  send,
  isScene: () => state.kind === "scene",
  orbit: (x, y) => moves("orbit", { x, y }),
  fly: (right, up, ahead) => moves("fly", { right, up, ahead }),
  roll: (by) => moves("roll", { by }),
  widen: (by) => moves("widen", { by }),
  zoom(factor) {
    const rect = $("stage").getBoundingClientRect();
    picture.zoomBy(factor, rect.left + rect.width / 2, rect.top + rect.height / 2);
  },
  fit: () => picture.fit(),
  // What is under the pointer becomes the pivot.
  grab(x, y) {
    const pixel = picture.pixelAt(x, y);
    if (pixel && ui.isScene()) send("pivot", pixel);
  },
  drag(dx, dy, pans) {
    if (!ui.isScene()) return picture.moveBy(dx, dy);
    const height = picture.size[1] * picture.scale;
    moves(pans ? "pan" : "orbit", { x: dx / height, y: dy / height });
  },
  rest() {
    gathered.flush();
    if (ui.isScene()) send("rest");
  },
  wheel(by, event) {
    if (!ui.isScene() || event.ctrlKey) {
      picture.zoomBy(Math.exp(2 * by), event.clientX, event.clientY);
    } else moves("dolly", { by });
  },
  ask(x, y) {
    const pixel = picture.pixelAt(x, y);
    if (focus.isArmed) return focus.at(pixel);
    if (!pixel) return;
    picture.mark(pixel);
    inspector.at(pixel);
    // The values of the pixel are there. A tab in which something is being set stays.
    if (tabs.name === "Render") tabs.open("Inspect");
    send("pixel", pixel);
  },
  trace: () => inspector.trace(0),
  focus: () => focus.arm(!focus.isArmed),
  isArmed: () => inspector.isArmed && ui.isScene(),
  arm: () => inspector.arm(!inspector.isArmed),
  select: (...box) => inspector.between(...box),
  selected: () => inspector.arm(false),
  reset: () => send("camera", { name: state.camera }),
  nextLayer() {
    const next = (state.layers.indexOf(state.layer) + 1) % state.layers.length;
    send("show", { layer: state.layers[next] });
  },
  develop(change) {
    const { exposure, tone_map, white_balance } = state;
    send("develop", { exposure, tone_map, white_balance, ...change });
  },
  expose: (by) => ui.develop({ exposure: state.exposure + by }),
  compare: () => send(state.against ? "drop" : "keep"),
  warnings() {
    if (document.body.classList.contains("folded")) ui.fold();
    tabs.open("Render");
    $("of-warnings").scrollIntoView();
  },
  fold() {
    const isFolded = document.body.classList.toggle("folded");
    $("fold").setAttribute("aria-expanded", !isFolded);
  },
};

listenToPointer($("stage"), ui);
listenToKeys(ui);

for (const [id, action] of Object.entries({
  more: () => send("more"), stop: () => send("stop"), keep: () => send("keep"),
  drop: () => send("drop"), fold: ui.fold, warned: ui.warnings, reset: ui.reset,
  narrow: () => ui.widen(-0.1), wide: () => ui.widen(0.1),
  "roll-left": () => ui.roll(-0.1), "roll-right": () => ui.roll(0.1),
})) $(id).addEventListener("click", action);

$("camera").addEventListener("change", () => send("camera", { name: $("camera").value }));
$("layer").addEventListener("change", () => send("show", { layer: $("layer").value }));
$("tone").addEventListener("change", () => ui.develop({ tone_map: $("tone").value }));
$("exposure").addEventListener("input", () => ui.develop({ exposure: Number($("exposure").value) }));
$("white").addEventListener("change", () => {
  const white = $("white").value;
  ui.develop({ white_balance: white === "kelvin" ? `${$("kelvin").value}K` : white });
});
$("kelvin").addEventListener("input", () => ui.develop({ white_balance: `${$("kelvin").value}K` }));
$("denoise").addEventListener("change", () => send("denoise", { on: $("denoise").checked }));
$("way").addEventListener("change", () => send("contrast", { way: $("way").value }));
$("split").addEventListener("input", () => picture.divide(Number($("split").value)));
paintRamp($("ramp"));
paintRamp($("contrast-ramp"));

// The scale of layers of numbers, as alight/view/shades.py paints it.
function paintRamp(canvas) {
  const context = canvas.getContext("2d"), gradient = context.createLinearGradient(0, 0, 128, 0);
  const colours = ["#000004", "#2b1050", "#701f69", "#b53454", "#e76230", "#f9a63e", "#fcf6be"];
  colours.forEach((colour, i) => gradient.addColorStop(i / (colours.length - 1), colour));
  context.fillStyle = gradient;
  context.fillRect(0, 0, 128, 1);
}
