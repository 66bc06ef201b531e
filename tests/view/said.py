"""What is said to the page's scripts, and a socket that says it."""

SOCKET = """
window.sent = [];
window.WebSocket = class {
  static OPEN = 1;
  constructor() { this.readyState = 1; window.socket = this; setTimeout(() => this.onopen(), 0); }
  send(text) { window.sent.push(JSON.parse(text)); }
};
"""
#: A scene that is being rendered; no two numbers are the same.
SCENE = {
    "is": "state", "kind": "scene", "number": 3, "size": [40, 30], "title": "a room",
    "layers": ["picture", "error", "depth"], "layer": "picture", "tone_maps": ["none", "agx"],
    "tone_map": "agx", "exposure": 1.5, "white_balance": "4300k", "denoise": False,
    "can_denoise": True, "denoised": "", "scale": None, "warnings": [], "phase": "rendering",
    "spp": 6, "target": 24, "replicates": 8, "seconds": 2.25, "rate": 7.125, "seed": 11,
    "error": [0.0321, 0.0297, 0.0345], "promised": True, "asked": 0.02, "word": "", "line": "soon",
    "biases": ["a bias"], "camera": "eye", "cameras": ["", "eye"], "lens": {"fov": 41.25},
    "against": False, "way": "divider", "ways": {"divider": "divider", "difference": "difference"},
    "rival": "", "contrast": None, "differs": None, "undo": True, "redo": False, "prepares": False,
    "version": 5, "is_part": False, "problem": "",
}  # fmt: skip
FILM = SCENE | {"kind": "film", "number": 4, "title": "a film", "undo": False, "is_part": False}

#: Bytes of a frame: picture, width, height, number, and a red and a blue pixel.
FRAME = "new Uint8Array([...new Uint8Array(new Uint32Array([1, 2, 1, 7]).buffer), 255, 0, 0, 255, 0, 0, 255, 255])"  # noqa: E501
PIXELS = "[...{canvas}.getContext('2d').getImageData(0, 0, 2, 1).data]"
NOTEBOOK = """
import("./notebook.js").then(({ default: { render } }) => {
  const frame = %s, whole = new Uint8Array(frame.length + 5), el = document.createElement("div");
  whole.set(frame, 5);
  const held = { frame: new DataView(whole.buffer, 5), told: { text: "6 spp", share: 0.25 } };
  render({ el, model: {
    get: (key) => held[key], set: (key, value) => { held[key] = value; },
    on: () => {}, save_changes: () => { held.saved = true; },
  } });
  el.querySelector("button").click();
  return [[...el.querySelector("canvas").getContext("2d").getImageData(0, 0, 2, 1).data],
    el.querySelector("span").textContent, el.querySelector("progress").value, held.stops,
    held.saved];
})
"""
