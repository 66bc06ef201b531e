// A render in a notebook (alight/view/notebook.py): its picture, how far it is, a button to stop.
import { draw, frameOf } from "./frames.js";

function render({ model, el }) {
  const canvas = document.createElement("canvas"), line = document.createElement("div");
  const bar = document.createElement("progress"), text = document.createElement("span");
  const stop = document.createElement("button");
  canvas.setAttribute("role", "img");
  canvas.style.maxWidth = "100%";
  Object.assign(line.style, { display: "flex", gap: "0.8em", alignItems: "center" });
  stop.textContent = "Stop";
  bar.setAttribute("aria-label", "Progress");
  line.append(stop, bar, text);
  const warnings = document.createElement("ul");
  warnings.style.fontSize = "smaller";
  el.append(canvas, line, warnings);

  const show = () => {
    const bytes = model.get("frame");
    if (!bytes?.byteLength) return;
    // A copy begins where numbers of four bytes may begin.
    const data = new Uint8Array(bytes.buffer ?? bytes, bytes.byteOffset ?? 0, bytes.byteLength);
    draw(canvas, frameOf(data.slice().buffer).image);
  };
  const tell = () => {
    const told = model.get("told");
    text.textContent = told.text ?? "";
    canvas.setAttribute("aria-label", told.text ?? "");
    warnings.hidden = !told.warnings?.length;
    warnings.replaceChildren(...(told.warnings ?? []).map((warning) => {
      const item = document.createElement("li");
      item.textContent = `Warning: ${warning}`;
      return item;
    }));
    stop.hidden = bar.hidden = told.phase === "done";
    if (told.share === null || told.share === undefined) bar.removeAttribute("value");
    else bar.value = told.share;
  };
  stop.onclick = () => {
    stop.disabled = true;
    model.set("stops", true);
    model.save_changes();
  };
  model.on("change:frame", show);
  model.on("change:told", tell);
  show();
  tell();
}

export default { render };
