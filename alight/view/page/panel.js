// What stands around the picture: the state that the server has sent, in words and figures.

import { helpOf } from "./gestures.js";

const $ = (id) => document.getElementById(id);

const percent = (share) => (share === null ? "unknown" : share > 10 ? "over 1000 %"
  : `${(100 * share).toPrecision(3)} %`);
const figure = (n) => (n === null ? "unknown" : Number.isInteger(n) ? String(n) : n.toPrecision(4));

function fill(select, names, chosen, label = (name) => name) {
  const key = names.join("\n");
  if (select.dataset.names !== key) {
    select.replaceChildren(...names.map((name) => new Option(label(name), name)));
    select.dataset.names = key;
  }
  if (document.activeElement !== select || select.value !== chosen) select.value = chosen;
}

function list(element, pairs) {
  element.replaceChildren(...pairs.flatMap(([name, value]) => {
    const term = document.createElement("dt"), told = document.createElement("dd");
    term.textContent = name;
    told.textContent = value;
    return [term, told];
  }));
}

function items(element, texts) {
  const key = texts.join("\n");
  // A list that is read aloud is left alone while it stays the same.
  if (element.dataset.items === key) return;
  element.dataset.items = key;
  element.replaceChildren(...texts.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
}

// `ask` asks for the command of the picture.
export function makePanel(ask) {
  const saves = { scene: ["film.alight", "picture.exr", "picture.png", "scene.yaml"],
    film: ["film.alight", "picture.exr", "picture.png"], picture: ["picture.exr", "picture.png"] };

  return function show(state) {
    document.title = `${state.title} – alight`;
    $("title").textContent = state.title;
    $("of-render").hidden = state.kind === "picture";
    $("of-camera").hidden = state.kind !== "scene";
    $("of-error").hidden = state.kind === "picture";
    showWarnings(state.warnings);
    showPhase(state);
    showError(state);
    showRender(state);
    const cameras = state.cameras ?? [];
    $("of-cameras").hidden = cameras.length < 2;
    fill($("camera"), cameras, state.camera ?? "", (name) => name || "the scene's own");
    const { fov, height } = state.lens ?? {};
    $("lens").textContent = fov ? `Field of view ${fov.toPrecision(3)}°`
      : height ? `Height ${height.toPrecision(3)} m` : "";
    $("narrow").disabled = $("wide").disabled = !fov && !height;
    fill($("layer"), state.layers, state.layer);
    fill($("tone"), state.tone_maps, state.tone_map);
    $("stops").textContent = state.exposure.toFixed(2);
    if (document.activeElement !== $("exposure")) $("exposure").value = state.exposure;
    $("scale").hidden = !state.scale;
    if (state.scale) [$("low").textContent, $("high").textContent] = state.scale.map(
      (end) => (state.layer === "error" ? percent(end) : figure(end)));
    showWhite(state);
    showContrast(state);
    if ($("saves").dataset.kind !== state.kind) {
      $("saves").dataset.kind = state.kind;
      list($("keys"), helpOf(state.kind === "scene"));
      $("saves").replaceChildren(...saves[state.kind].map(link));
      if (state.kind === "scene") $("saves").append(button("Command", ask));
    }
  };
}

function showWarnings(warnings) {
  const count = warnings.length;
  $("of-warnings").hidden = $("warned").hidden = !count;
  $("warned").textContent = `${count} warning${count === 1 ? "" : "s"}`;
  items($("warnings"), warnings);
}

function link(name) {
  const made = document.createElement("a");
  made.className = "button";
  made.href = `save/${name}`;
  made.download = "";
  made.textContent = name.split(".")[0] === "scene" ? "Scene" : name.split(".")[1].toUpperCase()
    .replace("ALIGHT", "Film");
  return made;
}

function button(text, action) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  made.addEventListener("click", action);
  return made;
}

function showWhite(state) {
  const kelvin = /^([\d.]+)k$/i.exec(state.white_balance)?.[1];
  if (document.activeElement !== $("white")) $("white").value = kelvin ? "kelvin" : state.white_balance;
  $("of-kelvin").hidden = !kelvin;
  $("kelvin-told").textContent = kelvin ? `${kelvin} K` : "";
  if (kelvin && document.activeElement !== $("kelvin")) $("kelvin").value = kelvin;
  $("denoise").checked = state.denoise;
  $("denoise").disabled = !state.can_denoise;
  $("denoised").hidden = !(state.denoise || !state.can_denoise);
  $("denoised").textContent = state.denoised || (state.can_denoise ? "waits until the picture rests"
    : "needs a film and the extra “denoise”");
  // Differences are those of the pictures themselves.
  $("label").hidden = !state.denoised || Boolean(state.contrast);
}


function showContrast(state) {
  const isSplit = state.way === "divider", contrast = state.contrast;
  $("drop").hidden = $("of-way").hidden = !state.against;
  $("no-contrast").hidden = state.against;
  $("of-split").hidden = !state.against || !isSplit;
  $("of-contrast").hidden = !state.against || isSplit;
  fill($("way"), Object.keys(state.ways), state.way, (way) => state.ways[way]);
  $("rival").textContent = `left: ${state.rival}`;
  $("here").textContent = `right: ${state.kind === "scene" ? "now" : state.title}`;
  const told = $("differs");
  if (isSplit || !state.against) return delete told.dataset.way;
  const isMetric = state.way !== "difference", write = isMetric ? figure : percent;
  // While the next one is worked out, that of a moment ago stays.
  if (!contrast && !state.differs && told.dataset.way === state.way) return;
  told.dataset.way = contrast ? state.way : "";
  told.textContent = !contrast ? state.differs ?? "being worked out …"
    : isMetric ? `mean ${state.ways[state.way]} ${figure(contrast.mean)}`
      : `root of the relative MSE ${percent(contrast.mean)}`;
  $("contrast-low").textContent = contrast ? write(contrast.low) : "";
  $("contrast-high").textContent = contrast ? write(contrast.high) : "";
}

function showPhase(state) {
  const spp = state.spp === undefined ? "" : `${figure(state.spp)}${
    state.target ? ` of ${figure(state.target)}` : ""} spp`;
  const words = { compiling: "compiling kernels", moving: "moving", rendering: spp || "rendering",
    done: state.kind === "scene" ? `done, ${spp}` : spp, stopped: `stopped, ${spp}`,
    failed: "failed" };
  $("phase").textContent = words[state.phase] || `${state.size[0]} × ${state.size[1]}`;
  $("phase").className = state.phase === "failed" ? "bad" : "";
  $("progress").hidden = state.kind !== "scene";
  if (state.phase === "compiling") $("progress").removeAttribute("value");
  else $("progress").value = state.phase === "done" ? 1 : (state.spp ?? 0) / (state.target || Infinity);
  $("notice").hidden = !(state.phase === "compiling" || state.problem);
  $("notice").textContent = state.problem
    || "Compiling kernels for this combination of models; the next time they are there at once.";
  Object.assign(document.body.dataset, { phase: state.phase, view: state.number });
}

function showError(state) {
  const [value, low, high] = state.error ?? [null, null, null];
  $("error").textContent = value === null ? "–" : percent(value);
  $("interval").textContent = value === null ? unknown(state)
    : high === null ? "relRMSE or more: an interval takes 4 replicates"
    : `relRMSE, ${state.promised ? "95 % interval " : ""}${percent(low)} to ${percent(high)}`
      + (state.promised ? "" : " (not promised: pixels share paths)");
  const word = state.word && state.asked ? state.word : state.asked ? `asked ${percent(state.asked)}` : "";
  $("promise").hidden = !word;
  $("promise").textContent = word;
  $("promise").className = `chip ${word === "met" ? "met" : word.startsWith("not") ? "missed" : ""}`;
  $("verdict").textContent = state.line ?? "";
  items($("biases"), state.biases ?? []);
}

function unknown({ replicates, spp }) {
  return replicates > spp ? `unknown below ${replicates} samples per pixel` : "unknown as yet";
}

function showRender(state) {
  const facts = [["size", `${state.size[0]} × ${state.size[1]}`]];
  if (state.spp !== undefined) facts.push(["samples per pixel", figure(state.spp)]);
  if (state.seconds) facts.push(["time", `${state.seconds.toFixed(1)} s`],
    ["rate", `${state.rate.toFixed(2)} Msamples/s`]);
  if (state.seed !== undefined) facts.push(["seed", state.seed]);
  list($("facts"), facts);
  const ended = ["done", "stopped"].includes(state.phase);
  $("more").hidden = $("stop").hidden = state.kind !== "scene";
  $("more").disabled = !ended;
  $("stop").disabled = state.phase !== "rendering";
}

export function showPixel({ x, y, values }) {
  $("no-pixel").hidden = true;
  $("pixel").hidden = false;
  const colours = values.picture?.length === 3 ? "; red, green, blue" : "";
  $("where").textContent = `column ${x}, row ${y}${colours}`;
  $("pixel").tBodies[0].replaceChildren(...Object.entries(values).map(([name, numbers]) => {
    const row = document.createElement("tr"), head = document.createElement("th");
    head.textContent = name;
    row.append(head, ...numbers.slice(0, 3).map((n) => {
      const cell = document.createElement("td");
      cell.textContent = n === null ? "–" : Math.abs(n) >= 1e5 ? n.toExponential(2) : figure(n);
      return cell;
    }));
    return row;
  }));
}
