// Pointer and keys become events of the camera, at most one message of each a frame of the screen.

const STEP = 0.06;

// [key, words of the help, action]; the action is given `ui`, see main.js.
const OF_SCENES = [
  ["w", "", (ui) => ui.fly(0, 0, STEP)],
  ["a", "", (ui) => ui.fly(-STEP, 0, 0)],
  ["s", "", (ui) => ui.fly(0, 0, -STEP)],
  ["d", "", (ui) => ui.fly(STEP, 0, 0)],
  ["r", "", (ui) => ui.fly(0, STEP, 0)],
  ["f", "", (ui) => ui.fly(0, -STEP, 0)],
  ["ArrowLeft", "", (ui) => ui.orbit(-STEP, 0)],
  ["ArrowRight", "", (ui) => ui.orbit(STEP, 0)],
  ["ArrowUp", "", (ui) => ui.orbit(0, -STEP)],
  ["ArrowDown", "", (ui) => ui.orbit(0, STEP)],
  ["q", "", (ui) => ui.roll(-STEP)],
  ["e", "", (ui) => ui.roll(STEP)],
  ["[", "", (ui) => ui.widen(-STEP)],
  ["]", "", (ui) => ui.widen(STEP)],
  ["Home", "reset the camera", (ui) => ui.reset()],
  ["m", "twice the samples", (ui) => ui.send("more")],
  ["x", "stop", (ui) => ui.send("stop")],
  ["t", "trace a path of the clicked pixel", (ui) => ui.trace()],
  ["b", "select a region by the next drag", (ui) => ui.arm()],
  ["g", "focus by the next click", (ui) => ui.focus()],
];

const OF_ALL = [
  ["l", "next layer", (ui) => ui.nextLayer()],
  [",", "", (ui) => ui.expose(-0.5)],
  [".", "", (ui) => ui.expose(0.5)],
  ["c", "keep, or drop the kept picture", (ui) => ui.compare()],
  ["+", "", (ui) => ui.zoom(1.5)],
  ["-", "", (ui) => ui.zoom(1 / 1.5)],
  ["0", "", (ui) => ui.fit()],
  ["p", "show or hide the panel", (ui) => ui.fold()],
];

const HELP_OF_SCENES = [
  ["drag", "orbit about what is under the pointer"],
  ["Shift or right drag", "pan"],
  ["wheel", "towards the pivot and back"],
  ["Alt drag", "select a region"],
  ["Ctrl wheel, + − 0", "zoom into the pixels, fit"],
  ["W A S D R F", "fly"],
  ["arrows", "orbit"],
  ["Q E", "roll"],
  ["[ ]", "field of view"],
  ["Ctrl Z, Ctrl Shift Z", "undo, redo an edit"],
];

const HELP_OF_PICTURES = [
  ["drag", "pan"],
  ["wheel, + − 0", "zoom, fit"],
];

// The keys and gestures of a view, each with what it does.
export function helpOf(isScene) {
  const keys = isScene ? [...OF_SCENES, ...OF_ALL] : OF_ALL;
  return [
    ...(isScene ? HELP_OF_SCENES : HELP_OF_PICTURES),
    ["click", "values of a pixel"],
    [", .", "exposure"],
    ...keys.filter(([, words]) => words).map(([key, words]) => [key.length === 1 ? key.toUpperCase() : key, words]),
  ];
}

export function listenToKeys(ui) {
  const actionsOf = (keys) => new Map(keys.map(([key, , action]) => [key, action]));
  const ofScenes = actionsOf(OF_SCENES), ofAll = actionsOf(OF_ALL);
  document.addEventListener("keydown", (event) => {
    const typing = event.target.matches("input, select, textarea");
    if (!typing && (event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "z") {
      event.preventDefault();
      if (ui.isScene()) ui.send(event.shiftKey ? "redo" : "undo");
    }
    // Arrows in tabs and lists are theirs.
    if (event.defaultPrevented) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = ofAll.get(key) ?? (ui.isScene() && ofScenes.get(key));
    if (!action || typing || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action(ui);
  });
}

export function listenToPointer(stage, ui) {
  let drag = null;

  stage.addEventListener("contextmenu", (event) => event.preventDefault());

  stage.addEventListener("pointerdown", (event) => {
    if (drag) return;
    stage.focus({ preventScroll: true });
    stage.setPointerCapture(event.pointerId);
    const pans = event.shiftKey || event.button !== 0;
    const selects = event.altKey || ui.isArmed();
    drag = { x: event.clientX, y: event.clientY, moved: false, pans, selects, id: event.pointerId };
    drag.from = [drag.x, drag.y];
  });

  stage.addEventListener("pointermove", (event) => {
    if (!drag || event.pointerId !== drag.id) return;
    const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
    if (!drag.moved && Math.hypot(dx, dy) < 4) return;
    if (drag.selects) {
      drag.moved = true;
      ui.select(...drag.from, event.clientX, event.clientY);
      return;
    }
    if (!drag.moved) ui.grab(drag.x, drag.y);
    Object.assign(drag, { x: event.clientX, y: event.clientY, moved: true });
    ui.drag(dx, dy, drag.pans);
  });

  const end = (event) => {
    if (!drag || event.pointerId !== drag.id) return;
    if (drag.selects) ui.selected();
    else if (drag.moved) ui.rest();
    else if (event.type === "pointerup") ui.ask(event.clientX, event.clientY);
    drag = null;
  };
  stage.addEventListener("pointerup", end);
  stage.addEventListener("pointercancel", end);

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const by = -event.deltaY * (event.deltaMode ? 0.05 : 0.002);
    ui.wheel(Math.max(-1, Math.min(1, by)), event);
  }, { passive: false });
}

// Adds up what is said between two frames of the screen and sends the sum.
export class Gathered {
  constructor(send) {
    this.send = send;
    this.waiting = new Map();
  }

  add(word, keys) {
    if (!this.waiting.size) requestAnimationFrame(() => this.flush());
    const sum = this.waiting.get(word) ?? {};
    for (const [key, value] of Object.entries(keys)) sum[key] = (sum[key] ?? 0) + value;
    this.waiting.set(word, sum);
  }

  flush() {
    for (const [word, keys] of this.waiting) this.send(word, keys);
    this.waiting.clear();
  }
}
