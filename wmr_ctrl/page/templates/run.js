// Plans (a law on a scene's stand, with overrides) and whole runs of them.

const SWITCHES = ["scene", "seed", "guard.enabled", "clock.control", "actuator.delay"];
const START = ["initial.pose[1]", "initial.pose[2]", "initial.pose[3]", "initial.velocity[1]", "initial.velocity[2]"];

const same = (a, b) => Math.abs(a - b) < 1e-9;

function findStand(scene, guard, period, delay) {
  return scene.stands.find((s) => s.guard === guard && same(s.period, period) && same(s.delay, delay));
}

function numbered(row) {
  return Object.fromEntries(Object.entries(row).map(([name, value]) => [name, Number(value)]));
}

// Loop, rows of parameters by name, their first plant steps, and the state at t = 0.
function planOf(told, scene, stand, law, overrides = {}, start = scene.start) {
  const chosen = stand.laws[law];
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

function chosenStand(told, overrides) {
  const scene = told.scenes.find((item) => item.key === (overrides.scene ?? told.scenes[0].key));
  if (!scene) throw new Error(`no scene is named ${overrides.scene}; known: ${told.scenes.map((s) => s.key).join(", ")}.`);
  const own = scene.stands[0];
  const guard = overrides["guard.enabled"] ?? own.guard;
  const period = overrides["clock.control"] ?? own.period, delay = overrides["actuator.delay"] ?? own.delay;
  const stand = findStand(scene, guard, period, delay);
  if (!stand) {
    const known = scene.stands.map((s) => `${s.period} s with a delay of ${s.delay} s`);
    throw new Error(`the page has no loop for a period of ${period} s with a delay of ${delay} s; it has: ${[...new Set(known)].join("; ")}.`);
  }
  if (stand.refusal) throw new Error(stand.refusal);
  return { scene, stand };
}

function checkNames(told, number, overrides) {
  for (const [name, value] of Object.entries(overrides)) {
    if (![...SWITCHES, ...START].includes(name) && !told.loops[number].parameters.includes(name))
      throw new Error(`${name} is no parameter of this loop; it has: ${told.loops[number].parameters.join(", ")}.`);
    if (name !== "scene" && typeof value !== "boolean" && Number.isNaN(Number(value)))
      throw new Error(`${name} = ${value} is not a number.`);
  }
}

// Columns of a run: arrays over the samples by element name. Overrides are parameters of the loop by
// element name, the start (initial.pose[1], ...), and what chooses the loop: scene, guard.enabled,
// clock.control, actuator.delay; and the seed. Nothing else follows from an override.
async function runColumns(engine, law, seconds, overrides = {}) {
  const told = engine.told, flat = byElement(overrides);
  if (!told.laws.some((item) => item.name === law))
    throw new Error(`no law is named ${law}; the page has: ${told.laws.map((item) => item.name).join(", ")}.`);
  if (!(seconds >= 0 && seconds <= 36000)) throw new Error(`seconds = ${seconds} must be from 0 to 36000.`);
  const { scene, stand } = chosenStand(told, flat);
  const number = stand.laws[law].loop;
  checkNames(told, number, flat);
  const start = scene.start.map((value, i) => Number(flat[START[i]] ?? value));
  const values = numbered(Object.fromEntries(Object.entries(flat).filter(([name]) => !SWITCHES.includes(name) && !START.includes(name))));
  const robot = engine.robot(number);
  robot.begin(planOf(told, scene, stand, law, values, start), flat.seed ?? told.seed);
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
  robot.free();
  return Object.fromEntries(names.map((name, i) => [name, columns[i].subarray(0, made)]));
}
