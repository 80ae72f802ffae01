// The page: what is pressed, dragged and shown.

const FRAME_BUDGET = 14;
const CHART_SECONDS = 20;
const THROW_SECONDS = 0.12;
const FASTEST_THROW = 3;

const CHARTS = [
  { id: "v1", column: "v1", most: 2.5, marks: (fleet) => limitsOf(fleet, 1) },
  { id: "omega", column: "omega", most: 2.5, marks: (fleet) => limitsOf(fleet, 2) },
  { id: "torque", column: "torque", floor: 0, least: 1, share: 0.99, marks: (fleet) => (Number.isFinite(fleet.value("actuator.tau_max")) ? [{ value: fleet.value("actuator.tau_max"), beyond: 1 }] : []) },
  { id: "command", column: "command", most: 2.5, marks: (fleet) => limitsOf(fleet, 1) },
  { id: "turning", column: "turning", most: 2.5, marks: (fleet) => limitsOf(fleet, 2) },
  { id: "V1", column: "V1", floor: 0, least: 0.01, share: 0.99, marks: () => [] },
  { id: "margin", column: "margin", floor: -0.5, ceiling: 1, marks: () => [{ value: 0, beyond: -1 }] },
  { id: "distance", column: "distance", floor: 0, least: 0.05, times: 1000, marks: tubesOf },
];

function limitsOf(fleet, axis) {
  const [least, most] = fleet.sides(axis), threshold = fleet.value(`limits.v_u2[${axis}]`);
  const edges = [{ value: most, beyond: 1 }, { value: least, beyond: -1 }];
  return fleet.told.filtered ? edges : [...edges, { value: threshold, dotted: true }, { value: -threshold, dotted: true }];
}

function shownSides(least, most) {
  return least === -most ? shownNumber(most) : `${shownNumber(least)} to ${shownNumber(most)}`;
}

// Certified distances; beside them the chart may show less than without.
function tubesOf(fleet) {
  const known = [...fleet.members.values()].map((member) => ({ member, tube: fleet.tube(member) })).filter(({ tube }) => tube);
  return known.map(({ member, tube }) => ({ value: Math.max(...tube.widths), at: (t) => widthOf(tube, t), dotted: true, law: member.law }));
}

class Page {
  constructor(engine) {
    window.wmr.page = this;
    this.told = engine.told;
    this.fleet = new Fleet(engine);
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.playing = !this.still.matches;
    this.whole = false;
    this.held = null;
    this.before = null;
    this.frames = 0;
    this.plane = new Plane(byId("plane"), this.told.body);
    this.charts = CHARTS.filter((what) => byId(`chart-${what.id}`)).map((what) => new Chart(byId(`chart-${what.id}`), what));
    this.settings = new Settings(this.fleet, byId("settings"), (control, value) => this.moved(control, value));
    this.findLook();
    this.listen();
    this.open(asked(this.told, location.hash));
    requestAnimationFrame((now) => this.frame(now));
  }

  findLook() {
    const style = getComputedStyle(document.documentElement), read = (name) => style.getPropertyValue(`--${name}`).trim();
    const family = getComputedStyle(document.body).fontFamily;
    const dark = this.dark.matches && !document.documentElement.classList.contains("printing");
    this.look = {
      ...Object.fromEntries(["ink", "muted", "paper", "grid", "limit", "beyond"].map((name) => [name, read(name)])),
      small: `11px ${family}`,
      bold: `600 13px ${family}`,
      laws: Object.fromEntries(this.told.laws.map((law) => [
        law.name, { label: law.label, colour: dark ? law.dark : law.colour, dash: law.dash.map((item) => 1.7 * item) },
      ])),
    };
    for (const law of this.told.laws) document.documentElement.style.setProperty(`--law-${law.name}`, this.look.laws[law.name].colour);
  }

  open(wanted) {
    const { fleet } = this;
    this.unmet = wanted.unmet;
    fleet.overrides = wanted.overrides;
    fleet.seed = wanted.seed;
    fleet.begin(wanted.scene, wanted.variant, wanted.laws);
    this.speed = wanted.speed;
    this.plane.view = null;
    this.settings.build();
    this.refresh();
  }

  scene(number) {
    const scene = this.told.scenes[number];
    if (scene) this.open(asked(this.told, `scene=${scene.key}`));
  }

  // Everything that shows settings.
  refresh() {
    const { fleet, told } = this;
    for (const button of document.querySelectorAll("[data-scene]")) {
      const chosen = button.dataset.scene === fleet.scene.key;
      button.setAttribute("aria-current", chosen ? "step" : "false");
      if (chosen) this.bringIntoView(button);
    }
    byId("scene-title").textContent = fleet.scene.title;
    byId("scene-text").textContent = fleet.scene.text;
    for (const box of document.querySelectorAll("[data-law]")) box.checked = fleet.laws.includes(box.dataset.law);
    byId("guard").checked = fleet.variant.guard;
    this.choices("period", this.places("period"), fleet.variant.period);
    this.choices("delay", this.places("delay"), fleet.variant.delay);
    byId("seed").value = fleet.seed;
    byId("speed").value = this.speed;
    this.settings.show();
    this.showPlaying();
    this.remember();
    this.board();
    this.dirty = true;
  }

  // Sideways only: the page itself stays where it is.
  bringIntoView(button) {
    const row = button.closest("ol"), box = button.getBoundingClientRect(), frame = row.getBoundingClientRect();
    row.scrollLeft += box.left + box.width / 2 - frame.left - frame.width / 2;
  }

  // Values of period or delay that the scene has a variant for.
  places(name) {
    const values = this.fleet.scene.variants.map((variant) => variant[name]);
    return [...new Set(values)].sort((a, b) => a - b);
  }

  choices(id, values, value) {
    const shown = (number) => (number ? `${shownNumber(1000 * number)} ms` : "none");
    byId(id).replaceChildren(...values.map((item) => made("option", { value: item, textContent: shown(item), selected: same(item, value) })));
  }

  remember() {
    this.link = linkOf(this.fleet, this.speed);
    clearTimeout(this.remembering);
    this.remembering = setTimeout(() => {
      try { history.replaceState(null, "", this.link ? `#${this.link}` : location.pathname + location.search); } catch { location.hash = this.link; }
    }, 300);
  }

  // Another variant, if there is one: what does not go with the choice goes back to the scene's.
  variant(change) {
    const { scene, variant } = this.fleet, own = scene.variants[0], wanted = { ...variant, ...change };
    const other = "period" in change ? { delay: own.delay } : "delay" in change ? { period: own.period } : {};
    const found = [wanted, { ...wanted, ...other }].map((w) => findVariant(scene, w.guard, w.period, w.delay)).find(Boolean);
    this.refused = found?.refusal ? `The guard stays as it was: ${found.refusal}` : "";
    if (found && !found.refusal) this.fleet.take(found);
    this.refresh();
  }

  moved(control, value) {
    const { fleet } = this, names = [control.name, ...control.along];
    const fault = value === null ? "" : faultOf(fleet.scene, control.name, value);
    this.refused = fault && `Refused: ${fault}`;
    if (fault) {
      // the number stays as it was
    } else if (value === null) {
      fleet.replace(Object.fromEntries(Object.entries(fleet.overrides).filter(([name]) => !names.includes(name))));
    } else {
      const before = fleet.value(control.name);
      const along = Object.fromEntries(control.along.map((name) => [name, (fleet.value(name) * value) / before]));
      fleet.set({ [control.name]: value, ...along });
    }
    this.settings.show();
    this.remember();
    this.board();
    this.dirty = true;
  }

  listen() {
    const on = (id, type, act) => byId(id).addEventListener(type, act);
    on("play", "click", () => this.play(!this.playing));
    on("step", "click", () => this.step());
    on("restart", "click", () => this.restart());
    on("speed", "change", () => { this.speed = Number(byId("speed").value); this.remember(); });
    on("guard", "change", () => this.variant({ guard: byId("guard").checked }));
    on("period", "change", () => this.variant({ period: Number(byId("period").value) }));
    on("delay", "change", () => this.variant({ delay: Number(byId("delay").value) }));
    on("seed", "change", () => { this.fleet.seed = clamp(Math.round(Number(byId("seed").value)) || 0, 0, Number.MAX_SAFE_INTEGER); this.restart(); });
    on("push", "click", () => this.push());
    on("reset", "click", () => { this.refused = ""; this.fleet.replace({}); this.refresh(); });
    on("whole", "change", () => { this.whole = byId("whole").checked; this.dirty = true; });
    on("share", "click", () => this.share());
    for (const button of document.querySelectorAll("[data-scene]")) button.addEventListener("click", () => this.scene(this.told.scenes.findIndex((item) => item.key === button.dataset.scene)));
    for (const box of document.querySelectorAll("[data-law]")) box.addEventListener("change", () => this.chooseLaws());
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("hashchange", () => { if (location.hash.slice(1) !== this.link) this.open(asked(this.told, location.hash)); });
    window.addEventListener("resize", () => this.fit());
    new ResizeObserver(() => this.fit()).observe(byId("plane"));
    this.dark.addEventListener("change", () => { this.findLook(); this.dirty = true; });
    window.addEventListener("beforeprint", () => this.print(true));
    window.addEventListener("afterprint", () => this.print(false));
    this.listenToPlane(byId("plane"));
  }

  chooseLaws() {
    const laws = [...document.querySelectorAll("[data-law]:checked")].map((box) => box.dataset.law);
    if (laws.length) this.fleet.choose(laws);
    this.settings.build();
    this.refresh();
  }

  listenToPlane(canvas) {
    const point = (event) => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
    canvas.addEventListener("touchstart", (event) => { if (this.plane.near(this.fleet, ...point(event.touches[0]))) event.preventDefault(); }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      const member = this.plane.near(this.fleet, ...point(event));
      if (!member) return;
      canvas.setPointerCapture(event.pointerId);
      this.held = { member, way: [] };
      this.drag(point(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (this.held) this.drag(point(event)); else canvas.classList.toggle("near", this.plane.near(this.fleet, ...point(event)) !== null);
    });
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => this.release());
  }

  drag([px, py]) {
    const now = performance.now(), [x, y] = this.plane.world(px, py);
    this.held.way = [...this.held.way.filter((item) => now - item.now < 1000 * THROW_SECONDS), { now, x, y }];
    this.hold();
    this.dirty = true;
  }

  // What is in the hand stands still there.
  hold() {
    const { x, y } = this.held.way[this.held.way.length - 1];
    this.held.member.place({ x, y, v1: 0, omega: 0 });
  }

  // It keeps the hand's speed along its own heading.
  release() {
    if (!this.held) return;
    const { member, way } = this.held, first = way[0], last = way[way.length - 1];
    const seconds = Math.max((performance.now() - first.now) / 1000, 0.02), { theta } = member.seen;
    const speed = ((last.x - first.x) * -Math.sin(theta) + (last.y - first.y) * Math.cos(theta)) / seconds;
    member.place({ v1: clamp(speed, -FASTEST_THROW, FASTEST_THROW) });
    this.held = null;
    this.dirty = true;
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
    const onButton = event.target.closest("button, summary, a");
    const acts = { ".": () => this.step(), r: () => this.restart(), g: () => byId("guard").click(), p: () => this.push() };
    if (event.key === " " && onButton) return;
    if (event.key === " ") this.play(!this.playing);
    else if (/^[1-9]$/.test(event.key)) this.scene(Number(event.key) - 1);
    else if (event.key in acts) acts[event.key]();
    else if (event.target === byId("plane") && event.key.startsWith("Arrow")) this.nudge(event.key);
    else return;
    event.preventDefault();
  }

  nudge(key) {
    const [dx, dy] = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[key] ?? [0, 0];
    for (const member of this.fleet.members.values()) member.place({ x: member.seen.x + dx, y: member.seen.y + dy });
    this.dirty = true;
  }

  play(on) { this.playing = on; this.showPlaying(); }

  showPlaying() {
    const button = byId("play");
    button.textContent = this.playing ? "❚❚ Pause" : "▶ Play";
    button.setAttribute("aria-pressed", String(this.playing));
  }

  step() {
    this.play(false);
    this.fleet.sample();
    this.board();
    this.dirty = true;
  }

  restart() {
    this.fleet.restart();
    this.refresh();
  }

  push() {
    this.fleet.push(Number(byId("force").value));
    this.dirty = true;
  }

  async share() {
    const link = location.href.split("#")[0] + (this.link ? `#${this.link}` : ""), field = byId("link");
    field.value = link;
    field.hidden = false;
    field.select();
    try { await navigator.clipboard.writeText(link); byId("shared").textContent = "Copied."; } catch { byId("shared").textContent = "Copy it from here."; }
  }

  fit() {
    for (const sheet of [this.plane, ...this.charts]) sheet.fit();
    this.dirty = true;
  }

  // Paper is light and narrow, whatever the screen is; pictures are drawn anew for it.
  print(begins) {
    document.documentElement.classList.toggle("printing", begins);
    this.findLook();
    this.fit();
    this.plane.view = null;
    this.draw();
  }

  frame(now) {
    const { fleet } = this, seconds = this.before === null ? 0 : Math.min((now - this.before) / 1000, 0.1);
    this.before = now;
    this.frames += 1;
    if (this.playing) this.late = !fleet.advance(seconds * this.speed, FRAME_BUDGET);
    if (this.held) this.hold();
    if (this.playing || this.dirty) this.draw();
    if (this.playing && !(now - this.boarded < 200)) { this.boarded = now; this.board(); }
    requestAnimationFrame((next) => this.frame(next));
  }

  // The robots in every frame; each chart in every third one, unless something else has changed.
  draw() {
    const { fleet, look } = this, { time } = fleet;
    const from = this.whole ? 0 : Math.max(0, time - CHART_SECONDS), to = Math.max(time, CHART_SECONDS);
    this.plane.follow(fleet, !this.still.matches && this.playing);
    this.plane.draw(fleet, look, this.held?.member ?? null);
    this.charts.forEach((chart, k) => { if (this.dirty || (k + this.frames) % 3 === 0) chart.draw(fleet, look, from, to); });
    byId("clock").textContent = `${time.toFixed(time < 100 ? 2 : 1)} s`;
    this.dirty = false;
  }

  // What each law has done so far, in words.
  board() {
    const { fleet } = this, rows = byId("rows"), limits = [1, 2].map((axis) => shownSides(...fleet.sides(axis)));
    rows.replaceChildren(...[...fleet.members.values()].map((member) => {
      const { most, first } = member.found(), { samples, clipped, gap, hit } = member.carried;
      const share = samples ? (100 * Math.max(...clipped)) / samples : 0;
      const kept = first === null && hit === null, axis = first && ["v₁", "ω", "a wheel's limit"][first.axis - 1];
      const left = first && `left ${axis} at ${first.time.toFixed(2)} s`, near = Number.isFinite(gap) ? `, ${length(gap)} to the obstacle` : "";
      const touched = hit && `drove into it at ${hit.time.toFixed(2)} s, with ${shownNumber(hit.speed, 2)} m/s`;
      const verdict = !samples ? "at the start" : kept ? `✓ keeps its limits${near}` : `✗ ${[left, touched].filter(Boolean).join(", ")}`;
      const cell = (text, more = {}) => made("td", { textContent: text, ...more });
      return made("tr", {},
        made("th", { scope: "row" }, swatch(member.law), this.look.laws[member.law].label),
        cell(`${verdict}${member.ended && !hit ? ", then gave up" : ""}`, { className: !samples ? "" : kept ? "kept" : "left" }),
        cell(`${shownNumber(most[0])} of ${limits[0]} m/s`),
        cell(`${shownNumber(most[1])} of ${limits[1]} rad/s`),
        cell(length(member.history.last("distance"))),
        cell(fleet.variant.guard || (this.told.filtered && share) ? `${shownNumber(share, 2)} %` : "–"));
    }));
    const tubes = tubesOf(fleet).map(({ law }) => `${this.look.laws[law].label} within ${fleet.members.get(law).tube.shown}`);
    byId("certified").hidden = !tubes.length;
    byId("certified").textContent = `Certified from a start on the path: ${tubes.join(", ")} of the desired position. Band about the path, dotted in the chart of the distance; both go when anything acts beside the scene’s own numbers, such as a push.`;
    const notices = this.notices();
    if (String(notices) !== this.noticed) {
      this.noticed = String(notices);
      byId("notices").replaceChildren(...notices.map((text) => made("li", { textContent: text })));
    }
  }

  notices() {
    const { fleet } = this, found = new Set(this.refused ? [this.refused] : []);
    if (this.unmet.length) found.add(`The link asks for what cannot be had here, and was followed without it: ${this.unmet.slice(0, 3).join(", ")}${this.unmet.length > 3 ? " and more" : ""}.`);
    for (const number of ["gain", "tau"]) {
      for (const axis of [1, 2]) {
        const name = `base.${number}[${axis}]`, apart = Number.isNaN(fleet.value(`filter.${number}[4]`)) ? 0 : 2 * (axis - 1);
        const [low, high] = [1, 2].map((end) => fleet.value(`filter.${number}[${end + apart}]`));
        const own = fleet.value(name), all = number === "gain" && own > high;
        if (own < low || own > high) found.add(`${name} = ${shownNumber(own)} is outside of filter.${number}, ${shownNumber(low)} to ${shownNumber(high)}: ${all ? "no filter" : "the governor does not"} promise${all ? "s" : ""} anything for such a base.`);
      }
    }
    const { stops } = fleet.scene;
    if (stops) {
      const own = fleet.value("base.delay"), [low, high] = stops.delay, pushed = fleet.pushed?.force ?? fleet.value("disturbance.push[1]");
      const drift = (pushed * fleet.value("base.tau[1]")) / fleet.value("robot.m"), most = fleet.value("filter.d[1]");
      if (own < low || own > high) found.add(`base.delay = ${shownNumber(own)} s is outside of filter.delay, ${shownNumber(low)} to ${shownNumber(high)} s: the filter promises nothing for such a base.`);
      if (drift > most) found.add(`A push of ${shownNumber(pushed)} N alone leads to ${shownNumber(drift)} m/s, more than filter.d = ${shownNumber(most)} m/s: the filter promises nothing.`);
    }
    for (const member of fleet.members.values()) {
      const { feasible, least, flags } = member.carried;
      if (flags & UNSOUND) found.add(`${this.look.laws[member.law].label} sends 0: with these numbers no command is safe (a push beyond the limit, or bounds the wrong way round).`);
      if (!fleet.variant.guard) continue;
      if (member.void) found.add(`No promise of the guard: ${member.void}`);
      if (!feasible) found.add("The guard’s bounds cannot be met with these numbers: it filters, and promises nothing.");
      const dbar = [1, 2].map((axis) => fleet.value(`guard.dbar[${axis}]`));
      const units = ["N", "N m"], beyond = [0, 1].find((i) => least[i] > 1.01 * dbar[i]);
      if (beyond !== undefined) found.add(`Something acted on ${this.look.laws[member.law].label} that the guard does not count on: at least ${shownNumber(least[beyond], 2)} ${units[beyond]}, and dbar is ${shownNumber(dbar[beyond], 2)} ${units[beyond]}.`);
    }
    if (this.late) found.add("This machine is not fast enough for this speed: the clock goes slower.");
    return [...found];
  }
}

const length = (metres) => (!Number.isFinite(metres) ? "–" : metres < 1 ? `${shownNumber(1000 * metres, 2)} mm` : `${shownNumber(metres, 2)} m`);

// A short line in a law's colour and dashes.
function swatch(law) {
  const space = "http://www.w3.org/2000/svg", svg = document.createElementNS(space, "svg"), line = document.createElementNS(space, "line");
  const { colour, dash } = window.wmr.page.look.laws[law];
  for (const [name, value] of Object.entries({ width: 30, height: 10, "aria-hidden": true })) svg.setAttribute(name, value);
  for (const [name, value] of Object.entries({ x1: 1, x2: 29, y1: 5, y2: 5, stroke: colour, "stroke-width": 3, "stroke-dasharray": dash.join(" ") })) line.setAttribute(name, value);
  svg.append(line);
  return svg;
}

document.documentElement.classList.toggle("embedded", window !== window.top);

window.wmr = (() => {
  const ready = openEngine(JSON.parse(byId("told").textContent), byId("module").textContent);
  const run = async (law, seconds, overrides) => runColumns(await ready, law, seconds, overrides);
  ready.then((engine) => { new Page(engine); }, (error) => {
    byId("trouble").hidden = false;
    byId("trouble").textContent = `The loops could not be started here: ${error.message}. A browser of 2023 or newer is needed, with WebAssembly switched on.`;
  });
  return { ready, run, page: null };
})();
