// Settings in the address: only what differs from the scene is written.

function linkOf(fleet, speed) {
  const { scene, variant } = fleet, own = scene.variants[0], out = new URLSearchParams();
  if (scene !== fleet.told.scenes[0]) out.set("scene", scene.key);
  if (String(fleet.laws) !== String(inOrder(fleet.told, scene.shown))) out.set("laws", fleet.laws.join("."));
  if (variant.guard !== own.guard) out.set("guard", Number(variant.guard));
  if (!same(variant.period, own.period)) out.set("period", variant.period);
  if (!same(variant.delay, own.delay)) out.set("delay", variant.delay);
  if (fleet.seed !== fleet.told.seed) out.set("seed", fleet.seed);
  if (speed !== scene.speed) out.set("speed", speed);
  const moved = Object.entries(fleet.overrides).map(([name, value]) => `${name}:${value}`);
  if (moved.length) out.set("set", moved.join(","));
  return out.toString().replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%5B", "[").replaceAll("%5D", "]");
}

const inOrder = (told, laws) => told.laws.map((item) => item.name).filter((law) => laws.includes(law));

// What a link asks for, of what there is: nobody has to trust a link.
function asked(told, text) {
  const given = new URLSearchParams(text.replace(/^#/, ""));
  const scene = told.scenes.find((item) => item.key === given.get("scene")) ?? told.scenes[0], own = scene.variants[0];
  const number = (name, other) => (given.has(name) && Number.isFinite(Number(given.get(name))) ? Number(given.get(name)) : other);
  const guard = given.has("guard") ? given.get("guard") === "1" : own.guard;
  const wanted = findVariant(scene, guard, number("period", own.period), number("delay", own.delay));
  const laws = inOrder(told, (given.get("laws") ?? "").split("."));
  const found = {
    scene,
    variant: wanted && !wanted.refusal ? wanted : own,
    laws: laws.length ? laws : inOrder(told, scene.shown),
    seed: Math.min(Math.max(Math.round(number("seed", told.seed)), 0), Number.MAX_SAFE_INTEGER),
    speed: Math.min(Math.max(number("speed", scene.speed), 0.05), 20),
    overrides: movedNumbers(told, scene, given.get("set") ?? ""),
  };
  return { ...found, unmet: unmet(given, found) };
}

// What a link asks for in vain, in its own words.
function unmet(given, { scene, variant, laws, seed, speed, overrides }) {
  const set = Object.entries(overrides).map(([name, value]) => `${name}:${value}`);
  const met = { scene: [scene.key], laws, guard: [Number(variant.guard)], period: [variant.period], delay: [variant.delay], seed: [seed], speed: [speed], set };
  const isMet = (name, part) => (met[name] ?? []).some((one) => plain(one) === plain(part));
  const parts = [...given].flatMap(([name, text]) => text.split(SIGNS[name] ?? /$/).map((part) => [name, part]));
  return parts.filter(([name, part]) => !isMet(name, part)).map(([name, part]) => `${name}=${part}`.slice(0, 60));
}

const SIGNS = { laws: ".", set: "," };

// The same text for the same number, however it is written.
function plain(part) {
  const text = String(part), at = text.lastIndexOf(":") + 1, number = Number(text.slice(at) || NaN);
  return Number.isFinite(number) ? text.slice(0, at) + number : text;
}

// Numbers of a link that the scenario's fields admit; the limits only where they go together.
function movedNumbers(told, scene, text) {
  const numbers = Object.fromEntries(text.split(",").map((item) => moved(scene, item)).filter(Boolean));
  const base = numbered(Object.values(scene.base)[0]);
  if (!pairFault({ ...base, ...numbers })) return numbers;
  return Object.fromEntries(Object.entries(numbers).filter(([name]) => !name.startsWith("limits.")));
}

function moved(scene, item) {
  const at = item.lastIndexOf(":"), name = item.slice(0, at), value = Number(item.slice(at + 1));
  const control = scene.controls.find((one) => one.name === name || one.along.includes(name));
  if (at < 1 || !control || item.slice(at + 1) === "" || faultOf(scene, name, value)) return null;
  return [name, clamp(value, Number(control.bounds[0]), Number(control.bounds[1]))];
}

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
