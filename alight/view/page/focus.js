// The plane of focus of a lens, put through what the next click of the picture shows.

const $ = (id) => document.getElementById(id);

export class Focus {
  constructor(send) {
    this.send = send;
    this.isArmed = false;
    $("focus").addEventListener("click", () => this.arm(!this.isArmed));
  }

  show({ lens }) {
    const distance = lens?.focus_distance;
    $("focus-at").textContent = distance === undefined ? "Sharp everywhere"
      : `Focus at ${Number(distance.toPrecision(4))} m`;
  }

  // Whether the next click focuses.
  arm(isArmed) {
    this.isArmed = isArmed;
    $("focus").setAttribute("aria-pressed", isArmed);
    $("stage").classList.toggle("selecting", isArmed);
    $("focus-told").hidden = true;
  }

  at(pixel) {
    this.arm(false);
    if (!pixel) return;
    this.send("focus", pixel);
    this.say("looking; the first time for a scene it compiles a kernel", "muted");
  }

  tell({ why }) {
    this.say(why ?? "", "wrong");
  }

  say(text, kind) {
    $("focus-told").hidden = !text;
    $("focus-told").textContent = text;
    $("focus-told").className = kind;
  }
}
