// The picture on its stage: fitted or zoomed, beside one that was kept, with the marked pixel.

import { draw } from "./frames.js";

const $ = (id) => document.getElementById(id);

export class Picture {
  constructor() {
    this.stage = $("stage");
    this.box = $("picture");
    this.canvases = [$("shown"), $("kept")];
    this.size = [1, 1];
    this.zoom = 1;
    this.shift = [0, 0];
    this.split = 50;
    this.isSplit = true;
    new ResizeObserver(() => this.place()).observe(this.stage);
  }

  resize([width, height]) {
    if (width !== this.size[0] || height !== this.size[1]) {
      this.size = [width, height];
      this.place();
    }
  }

  draw({ picture, image }) {
    draw(this.canvases[picture], image);
  }

  // Pixels of the screen that a pixel of the picture is wide.
  get scale() {
    const { clientWidth, clientHeight } = this.stage;
    return this.zoom * Math.min(clientWidth / this.size[0], clientHeight / this.size[1]);
  }

  place() {
    const [width, height] = this.size.map((side) => side * this.scale);
    const style = this.box.style;
    style.width = `${width}px`;
    style.height = `${height}px`;
    style.left = `${(this.stage.clientWidth - width) / 2 + this.shift[0]}px`;
    style.top = `${(this.stage.clientHeight - height) / 2 + this.shift[1]}px`;
    this.box.classList.toggle("pixels", this.scale > 2.5);
    this.divide(this.split);
    this.mark(this.marked);
  }

  zoomBy(factor, x, y) {
    const before = this.zoom, rect = this.stage.getBoundingClientRect();
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), 64);
    const from = [x - rect.left - rect.width / 2, y - rect.top - rect.height / 2];
    this.shift = this.shift.map((s, i) => from[i] + (s - from[i]) * (this.zoom / before));
    if (this.zoom === 1) this.shift = [0, 0];
    this.place();
  }

  moveBy(dx, dy) {
    this.shift = [this.shift[0] + dx, this.shift[1] + dy];
    this.place();
  }

  fit() {
    this.zoom = 1;
    this.shift = [0, 0];
    this.place();
  }

  // The pixel at a place of the screen; null outside the picture.
  pixelAt(x, y) {
    const rect = this.box.getBoundingClientRect();
    const at = [(x - rect.left) / this.scale, (y - rect.top) / this.scale].map(Math.floor);
    return at.every((n, i) => n >= 0 && n < this.size[i]) ? { x: at[0], y: at[1] } : null;
  }

  // The pixel of the picture that is nearest to a place of the screen.
  nearest(x, y) {
    const rect = this.box.getBoundingClientRect();
    const at = [(x - rect.left) / this.scale, (y - rect.top) / this.scale].map(
      (n, i) => Math.min(Math.max(Math.floor(n), 0), this.size[i] - 1));
    return { x: at[0], y: at[1] };
  }

  mark(pixel) {
    this.marked = pixel;
    $("mark").hidden = !pixel;
    if (pixel) {
      $("mark").style.left = `${(pixel.x + 0.5) * this.scale}px`;
      $("mark").style.top = `${(pixel.y + 0.5) * this.scale}px`;
    }
  }

  // `way` is "divider", or another picture lies over all of this one once it is there.
  compare(isOn, way, isThere) {
    const isSplit = way === "divider";
    this.canvases[1].hidden = !isOn || !(isSplit || isThere);
    $("divider").hidden = !isOn || !isSplit;
    this.isSplit = isSplit;
    this.divide(this.split);
  }

  // The kept picture is seen to the left of the divider.
  divide(percent) {
    this.split = percent;
    this.canvases[1].style.clipPath = this.isSplit ? `inset(0 ${100 - percent}% 0 0)` : "none";
    $("divider").style.left = `${percent}%`;
  }
}
