// Plans (a law on a scene's variant, with overrides) and whole runs of them.

const SWITCHES = ["scene", "seed", "guard.enabled", "clock.control", "actuator.delay"];
const START = ["initial.pose[1]", "initial.pose[2]", "initial.pose[3]", "initial.velocity[1]", "initial.velocity[2]"];

// What the finding "stop" says of a run that ended early.
const NON_FINITE = 2;

const same = (a, b) => Math.abs(a - b) < 1e-9;

function findVariant(scene, guard, period, delay) {
  return scene.variants.find((s) => s.guard === guard && same(s.period, period) && same(s.delay, delay));
}

function numbered(row) {
  return Object.fromEntries(Object.entries(row).map(([name, value]) => [name, Number(value)]));
}

// Loop, rows of parameters by name, their first plant steps, and the state at t = 0.
function planOf(told, scene, variant, law, overrides = {}, start = scene.start) {
  const chosen = variant.laws[law];
  const rows = [];
  let row = numbered(scene.base[law]);
  for (const changes of chosen.rows) {
    row = { ...row, ...numbered(changes), ...overrides };
    rows.push(row);
  }
  const whole = [...told.loops[chosen.loop].start];
  start.forEach((value, i) => { whole[i] = value; });
  return { loop: chosen.loop, rows, phases: chosen.phases, start: whole, void: chosen.void };
}

// Overrides by element: "limits.v_u1": [0.8, 1.5] says both of its elements.
function byElement(overrides) {
  const flat = {};
  for (const [name, value] of Object.entries(overrides)) {
    if (Array.isArray(value)) value.forEach((item, i) => { flat[`${name}[${i + 1}]`] = item; });
    else flat[name] = value;
  }
  return flat;
}

function chosenVariant(told, overrides) {
  const scene = told.scenes.find((item) => item.key === (overrides.scene ?? told.scenes[0].key));
  if (!scene) throw new Error(`no scene is named ${overrides.scene}; known: ${told.scenes.map((s) => s.key).join(", ")}.`);
  const own = scene.variants[0];
  const guard = overrides["guard.enabled"] ?? own.guard;
  const period = overrides["clock.control"] ?? own.period, delay = overrides["actuator.delay"] ?? own.delay;
  const variant = findVariant(scene, guard, period, delay);
  if (!variant) {
    const known = scene.variants.map((s) => `${s.period} s with a delay of ${s.delay} s`);
    throw new Error(`the page has no loop for a period of ${period} s with a delay of ${delay} s; it has: ${[...new Set(known)].join("; ")}.`);
  }
  if (variant.refusal) throw new Error(variant.refusal);
  return { scene, variant };
}

// Why a number may not stand for a parameter: what its field of the scenario admits. "" if it may.
const LARGEST = 1e12;

function faultOf(scene, name, value) {
  const said = (what) => `${name} = ${value} must be ${what}. Change it, or leave it out for the scene's own value.`;
  if (typeof value !== "number" || Number.isNaN(value)) return said("a number");
  const range = scene.admitted[name.replace(/\[\d+\]$/, "")] ?? {};
  if (!Number.isFinite(value) && !range.infinite) return said("a finite number");
  if (Number.isFinite(value) && Math.abs(value) > LARGEST) return said(`at most ${LARGEST} in size`);
  if (range.above != null && !(value > range.above)) return said(`above ${range.above}`);
  if (range.minimum != null && !(value >= range.minimum)) return said(`at least ${range.minimum}`);
  if (range.below != null && !(value < range.below)) return said(`below ${range.below}`);
  if (range.maximum != null && !(value <= range.maximum)) return said(`at most ${range.maximum}`);
  return "";
}

// Why limits do not go together, of a row of parameters. "" if they do.
function pairFault(row) {
  for (const axis of [1, 2]) {
    const high = row[`limits.v_u1[${axis}]`], low = row[`limits.v_u2[${axis}]`], clip = row["limits.clip"];
    if (high === undefined || low === undefined) continue;
    if (!(low < high))
      return `limits.v_u2[${axis}] = ${low} must be below limits.v_u1[${axis}] = ${high}: the barrier acts between the two. Lower v_u2 or raise v_u1.`;
    if (clip !== undefined && !(clip < high - low))
      return `limits.clip = ${clip} must be below v_u1[${axis}] - v_u2[${axis}] = ${high - low}, or the barrier never acts. Lower it.`;
  }
  return "";
}

function checkSwitches(overrides) {
  const { seed } = overrides, guard = overrides["guard.enabled"];
  if (guard !== undefined && typeof guard !== "boolean") throw new Error(`guard.enabled = ${JSON.stringify(guard)} must be true or false, without quotes.`);
  if (seed !== undefined && !(Number.isSafeInteger(seed) && seed >= 0)) throw new Error(`seed = ${seed} must be a whole number from 0 up, below 2^53.`);
  for (const name of ["clock.control", "actuator.delay"])
    if (overrides[name] !== undefined && !Number.isFinite(overrides[name])) throw new Error(`${name} = ${overrides[name]} must be a finite number of seconds.`);
}

function checkNumbers(told, scene, number, overrides) {
  for (const [name, value] of Object.entries(overrides)) {
    if (SWITCHES.includes(name)) continue;
    if (!START.includes(name) && !told.loops[number].parameters.includes(name))
      throw new Error(`${name} is no parameter of this loop; it has: ${told.loops[number].parameters.join(", ")}.`);
    const fault = faultOf(scene, name, value);
    if (fault) throw new Error(fault);
  }
}

// The scenario's keys where the loop has other names: reference.radius is ref_radius.
function byParameter(scene, overrides) {
  return Object.fromEntries(Object.entries(overrides).map(([name, value]) => [scene.aliases[name] ?? name, value]));
}

// Columns of a run: arrays over the samples by element name. Overrides are parameters of the loop by
// element name, the start (initial.pose[1], ...), and what chooses the loop: scene, guard.enabled,
// clock.control, actuator.delay; and the seed. Nothing else follows from an override.
async function runColumns(engine, law, seconds, overrides = {}) {
  const told = engine.told, given = byElement(overrides);
  if (!told.laws.some((item) => item.name === law))
    throw new Error(`no law is named ${law}; the page has: ${told.laws.map((item) => item.name).join(", ")}.`);
  if (!(seconds >= 0 && seconds <= 36000)) throw new Error(`seconds = ${seconds} must be from 0 to 36000.`);
  checkSwitches(given);
  const { scene, variant } = chosenVariant(told, given), flat = byParameter(scene, given);
  const number = variant.laws[law].loop;
  checkNumbers(told, scene, number, flat);
  const start = scene.start.map((value, i) => Number(flat[START[i]] ?? value));
  const values = numbered(Object.fromEntries(Object.entries(flat).filter(([name]) => !SWITCHES.includes(name) && !START.includes(name))));
  const plan = planOf(told, scene, variant, law, values, start);
  const apart = plan.rows.map(pairFault).find(Boolean);
  if (apart) throw new Error(apart);
  const robot = engine.robot(number);
  robot.begin(plan, flat.seed ?? told.seed);
  const most = Math.round(seconds / robot.period), names = told.loops[number].columns;
  const columns = names.map(() => new Float64Array(most));
  let made = 0, rested = Date.now();
  for (; made < most && robot.running; ++made) {
    robot.sample();
    for (let i = 0; i < names.length; ++i) columns[i][made] = robot.row[i];
    if (made % 256 === 255 && Date.now() - rested > 30) {
      await new Promise((done) => setTimeout(done, 0));
      rested = Date.now();
    }
  }
  const stop = robot.finding("stop"), sample = robot.sampled;
  robot.free();
  if (stop === NON_FINITE)
    throw new Error(`the run of ${law} was no longer finite after ${sample} samples. Take numbers nearer to the scene's own.`);
  return Object.fromEntries(names.map((name, i) => [name, columns[i].subarray(0, made)]));
}
