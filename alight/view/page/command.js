// The command line that renders the picture: asked for, shown and copied.

const $ = (id) => document.getElementById(id);

export class Command {
  constructor(send) {
    this.view = this.asked = null;
    this.ask = () => {
      this.asked = this.view;
      send("command");
    };
    $("copy").addEventListener("click", () => this.copy());
  }

  // Of another picture it is another one.
  show(state) {
    const view = JSON.stringify([state.number, state.version, state.target, state.exposure,
      state.tone_map, state.white_balance, state.denoise]);
    if (view !== this.view) $("of-command").hidden = true;
    this.view = view;
  }

  tell({ text, notes, why }) {
    // The answer took its time, and the picture is another one by now.
    if (this.asked !== this.view) return this.ask();
    $("of-command").hidden = false;
    $("command").hidden = $("copy").hidden = Boolean(why);
    $("command").value = text ?? "";
    $("command-told").textContent = why ?? notes.join("; ");
  }

  async copy() {
    $("command").select();
    try {
      await navigator.clipboard.writeText($("command").value);
      $("command-told").textContent = "copied";
    } catch {
      // Pages over plain HTTP from another machine may not: what is selected can be copied by hand.
      $("command-told").textContent = "selected: copy it with Ctrl C";
    }
  }
}
