// Drawers of sliders, made from the scene's controls.

const NOTCHES = 1000;

function made(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element && name !== "list") element[name] = value; else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const byId = (name) => document.getElementById(name);

// Three digits, as a slider means them.
const rounded = (value) => Number(value.toPrecision(3));

class Slider {
  constructor(control, fleet, changed) {
    Object.assign(this, { control, fleet, changed });
    this.open = fleet.value(control.name) === Infinity;
    const id = `set-${control.name}`;
    this.range = made("input", { type: "range", min: 0, max: NOTCHES, step: 1, id, oninput: () => this.slid() });
    this.number = made("input", { type: "number", step: "any", inputMode: "decimal", "aria-label": `${control.name}, ${control.meaning}`, onchange: () => this.typed() });
    this.undo = made("button", { type: "button", className: "undo", textContent: "↺", onclick: () => this.changed(control, null) });
    const words = made("label", { htmlFor: id }, made("span", { textContent: control.meaning }), made("code", { textContent: control.name }));
    const unit = made("span", { className: "unit", textContent: control.unit });
    this.element = made("div", { className: "control" }, words, this.range, this.number, unit, this.undo);
    this.show();
  }

  get span() { return this.control.span; }

  value(notch) {
    const [low, high] = this.span, share = notch / NOTCHES;
    if (this.open && notch === NOTCHES) return Infinity;
    return rounded(this.control.log ? low * (high / low) ** share : low + share * (high - low));
  }

  notch(value) {
    const [low, high] = this.span;
    if (value === Infinity) return NOTCHES;
    const share = this.control.log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.round(NOTCHES * clamp(share, 0, 1));
  }

  slid() { this.changed(this.control, this.value(Number(this.range.value))); }

  typed() {
    const value = this.number.value === "" ? Infinity : Number(this.number.value);
    if (Number.isNaN(value) || (value === Infinity && !this.open)) this.show(); else this.changed(this.control, value);
  }

  show() {
    const value = this.fleet.value(this.control.name), moved = this.control.name in this.fleet.overrides;
    this.range.value = this.notch(value);
    this.range.setAttribute("aria-valuetext", `${shownNumber(value)} ${this.control.unit}`);
    this.number.value = value === Infinity ? "" : String(Number(value.toPrecision(6)));
    this.number.placeholder = "∞";
    this.element.classList.toggle("moved", moved);
    this.undo.disabled = !moved;
    this.undo.title = moved ? "back to the scene’s value" : "";
    this.undo.setAttribute("aria-label", `${this.control.name} back to the scene’s value`);
  }
}

class Settings {
  constructor(fleet, holder, changed) {
    Object.assign(this, { fleet, holder, changed });
    this.sliders = [];
    this.opened = new Set(fleet.told.filtered ? ["base", "filter"] : ["limits", "robot"]);
  }

  // For another scene, or other laws.
  build() {
    const { fleet, holder } = this, shown = fleet.told.laws.filter((item) => fleet.laws.includes(item.name)).map((item) => item.law);
    const laws = fleet.told.laws.map((item) => item.law).filter((law) => !shown.includes(law));
    const hidden = (name) => laws.some((law) => name.startsWith(`gains.${law}.`));
    this.sliders = [];
    holder.replaceChildren();
    for (const group of fleet.told.groups) {
      const controls = fleet.scene.controls.filter((item) => item.group === group.key && !hidden(item.name));
      if (controls.length) holder.append(this.drawer(group, controls));
    }
  }

  drawer(group, controls) {
    const sliders = controls.map((control) => new Slider(control, this.fleet, this.changed));
    this.sliders.push(...sliders);
    const drawer = made("details", { open: this.opened.has(group.key) }, made("summary", { textContent: group.title }));
    drawer.addEventListener("toggle", () => (drawer.open ? this.opened.add(group.key) : this.opened.delete(group.key)));
    if (group.hint) drawer.append(made("p", { className: "hint", textContent: group.hint }));
    drawer.append(...sliders.map((item) => item.element));
    return drawer;
  }

  show() { this.sliders.forEach((slider) => slider.show()); }
}
