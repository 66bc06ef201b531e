// The tabs of the panel: one press of Tab reaches them, arrows go from one to the next.

const $ = (id) => document.getElementById(id);

export class Tabs {
  constructor() {
    this.panels = [...document.querySelectorAll("[role=tabpanel]")];
    this.buttons = this.panels.map((panel) => {
      const made = document.createElement("button");
      made.type = "button";
      made.id = `${panel.id}-button`;
      made.textContent = panel.dataset.tab;
      made.setAttribute("role", "tab");
      made.setAttribute("aria-controls", panel.id);
      panel.setAttribute("aria-labelledby", made.id);
      made.addEventListener("click", () => this.open(panel.dataset.tab));
      return made;
    });
    $("tabs").replaceChildren(...this.buttons);
    $("tabs").addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!by) return;
      event.preventDefault();
      const there = this.buttons.filter((button) => !button.hidden);
      const at = there.indexOf(document.activeElement);
      const next = there[(at + by + there.length) % there.length];
      this.open(next.textContent);
      next.focus();
    });
    this.open(this.panels[0].dataset.tab);
  }

  open(name) {
    this.name = name;
    this.panels.forEach((panel, i) => {
      const isOpen = panel.dataset.tab === name;
      panel.hidden = !isOpen;
      this.buttons[i].setAttribute("aria-selected", isOpen);
      this.buttons[i].tabIndex = isOpen ? 0 : -1;
    });
  }

  // Without its button a tab is not to be had.
  offer(name, isThere) {
    this.buttons.find((button) => button.textContent === name).hidden = !isThere;
    if (!isThere && this.name === name) this.open(this.panels[0].dataset.tab);
  }
}
