// The robots that are shown: one for each law, all at the same sample, with what they left behind.

const KEPT = ["t", "x", "y", "theta", "v1", "omega", "torque", "V1", "margin", "distance", "command", "turning", "jump"];
const MOST_ROWS = 160000;
const PUSH_SECONDS = 0.5;
const UNSOUND = 32; // of filter_flags

// Columns of numbers that grow, and forget their older half when they are too long.
class History {
  constructor() {
    this.length = 0;
    this.columns = Object.fromEntries(KEPT.map((name) => [name, new Float32Array(4096)]));
  }

  add(values) {
    if (this.length === this.columns.t.length) this.makeRoom();
    for (let i = 0; i < KEPT.length; ++i) this.columns[KEPT[i]][this.length] = values[i];
    this.length += 1;
  }

  makeRoom() {
    const full = this.length >= MOST_ROWS, from = full ? this.length >> 1 : 0;
    for (const name of KEPT) {
      const old = this.columns[name], next = full ? old : new Float32Array(2 * old.length);
      next.set(old.subarray(from, this.length));
      this.columns[name] = next;
    }
    this.length -= from;
  }

  // Index of the first row at or after a time.
  after(time) {
    let low = 0, high = this.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.columns.t[middle] < time) low = middle + 1; else high = middle;
    }
    return low;
  }

  last(name) { return this.length ? this.columns[name][this.length - 1] : NaN; }
}

class Member {
  constructor(engine, law) {
    this.engine = engine;
    this.law = law;
    this.robot = null;
  }

  begin(plan, seed, tube, obstacles = []) {
    this.free();
    this.tube = tube;
    this.obstacles = obstacles;
    this.radius = plan.rows[0]["body.radius"];
    this.still = 0;
    this.braked = false;
    this.robot = this.engine.robot(plan.loop).begin(plan, seed);
    this.void = plan.void;
    this.step0 = plan.rows[0]["clock.plant"];
    this.history = new History();
    this.carried = { violations: 0, samples: 0, clipped: [0, 0], most: [0, 0], least: [0, 0], first: null, feasible: 1, flags: 0, gap: Infinity, hit: null };
    this.jumped = 0;
    this.within = false;
    this.touched = false;
    return this;
  }

  // Goes on with another loop, whose state takes over what the two have in common.
  handOver(plan, seed, time) {
    const before = this.robot, names = before.loop.state, state = Float64Array.from(before.state);
    this.carry();
    this.robot = this.engine.robot(plan.loop);
    const places = this.robot.places.state;
    names.forEach((name, i) => { if (name in places) plan.start[places[name]] = state[i]; });
    this.robot.begin(plan, seed);
    this.robot.resume(Math.round(time / this.robot.period));
    this.void = plan.void;
    before.free();
  }

  // Keeps what the loop has found so far, for another loop begins at nothing.
  carry() {
    const { violations, first, most } = this.found();
    Object.assign(this.carried, { violations, first, most });
  }

  sample() {
    const robot = this.robot;
    if (!robot.running) return;
    robot.sample();
    this.watch(robot);
    if (this.obstacles.length && this.radius !== undefined) this.look(robot);
    const torque = Math.max(Math.abs(robot.column("tau_right")), Math.abs(robot.column("tau_left")));
    const off = Math.hypot(robot.column("x") - robot.column("x_d"), robot.column("y") - robot.column("y_d"));
    this.within = this.within || (this.tube !== undefined && off <= widthOf(this.tube, robot.column("t")));
    this.history.add([
      robot.column("t"), robot.column("x"), robot.column("y"), robot.column("theta"), robot.column("v1"),
      robot.column("omega"), torque, robot.column("V1"), robot.column("margin"), off,
      robot.column("v_command"), robot.column("omega_command"), this.jumped,
    ]);
    this.jumped = 0;
  }

  watch(robot) {
    const kept = this.carried;
    kept.samples += 1;
    kept.feasible = robot.column("feasible");
    kept.flags = this.engine.told.filtered ? robot.column("filter_flags") : 0;
    for (const i of [0, 1]) {
      kept.clipped[i] += robot.column(`clip_active[${i + 1}]`);
      kept.least[i] = Math.max(kept.least[i], robot.column(`d_least[${i + 1}]`));
    }
  }

  // The distance left to the nearest obstacle; a robot that touches one stays there.
  look(robot) {
    const kept = this.carried, at = robot.places.state, { state } = robot;
    kept.gap = Math.min(kept.gap, ...this.obstacles.map((shape) => distanceOf(shape, state[at.x], state[at.y]) - this.radius));
    if (kept.gap > 0) return;
    kept.hit = { time: robot.sampled * robot.period, speed: Math.abs(state[at.v1]) };
    for (const name of ["v1", "omega"]) robot.put(name, 0);
    robot.running = false;
  }

  // A brake holds the base once its command was 0 for so long [s]; `pushes` act as long as it does not.
  brake(rest, pushes) {
    const { robot } = this, zero = robot.column("v_command") === 0 && robot.column("omega_command") === 0;
    this.still = zero ? this.still + robot.period : 0;
    const holds = this.still > rest;
    if (holds) for (const name of ["v1", "omega"]) robot.put(name, 0);
    if (holds !== this.braked) robot.set(Object.fromEntries(pushes.map((push, i) => [`disturbance.push[${i + 1}]`, holds ? 0 : push])));
    this.braked = holds;
  }

  // Plant steps beyond a limit, time and axis of the first, largest |v1| and |omega|.
  found() {
    const robot = this.robot, kept = this.carried, step = robot.finding("first_step");
    const first = step < 0 ? null : { time: step * this.step0, axis: robot.finding("first_axis") };
    return {
      violations: kept.violations + robot.finding("violations"),
      first: kept.first ?? first,
      most: [Math.max(kept.most[0], robot.finding("max_v1")), Math.max(kept.most[1], robot.finding("max_omega"))],
    };
  }

  get ended() { return !this.robot.running; }

  place(values) {
    this.touched = true;
    for (const [name, value] of Object.entries(values)) this.robot.put(name, value);
    this.jumped = 1;
  }

  free() {
    if (this.robot) this.robot.free();
    this.robot = null;
  }
}

// Distance [m] of a place from a circle or polygon; below 0 inside of it.
function distanceOf(shape, x, y) {
  if (!Array.isArray(shape[0])) return Math.hypot(x - shape[0], y - shape[1]) - shape[2];
  let nearest = Infinity, side = 1;
  shape.forEach(([ax, ay], k) => {
    const [bx, by] = shape[(k + 1) % shape.length], [dx, dy, toX, toY] = [bx - ax, by - ay, x - ax, y - ay];
    const share = clamp((toX * dx + toY * dy) / Math.max(dx * dx + dy * dy, 1e-300), 0, 1);
    nearest = Math.min(nearest, Math.hypot(toX - share * dx, toY - share * dy));
    if (ay > y !== by > y && toX < (toY * dx) / dy) side = -side;
  });
  return side * nearest;
}

// Way [m] that the filter counts for a stop from a speed [m/s].
function wayToStop({ most, ways }, speed) {
  const place = Math.min(Math.abs(speed) / most, 1) * (ways.length - 1), k = Math.min(Math.floor(place), ways.length - 2);
  return ways[k] + (place - k) * (ways[k + 1] - ways[k]);
}

// Width [m] of a certified corridor at a time [s].
function widthOf(tube, t) { return tube.widths[Math.min(Math.floor(t / tube.every + 1e-6), tube.widths.length - 1)]; }

class Fleet {
  constructor(engine) {
    this.engine = engine;
    this.told = engine.told;
    this.members = new Map();
    this.overrides = {};
    this.seed = engine.told.seed;
    this.sampled = 0;
    this.pushed = null;
    this.touched = false;
  }

  get period() { return this.variant.period; }
  get time() { return this.sampled * this.period; }
  get laws() { return [...this.members.keys()]; }

  // The certified corridor of a robot that is in it, as long as it has met nothing but the scene.
  tube(member) {
    const { tube } = member;
    const own = !this.touched && this.variant === this.scene.variants[0] && !Object.keys(this.overrides).length;
    return tube && own && !member.touched && this.time < Number(tube.until) && member.within ? tube : null;
  }

  plan(law) { return planOf(this.told, this.scene, this.variant, law, this.overrides); }

  begin(scene, variant, laws) {
    this.scene = scene;
    this.variant = variant;
    this.sampled = 0;
    this.choose(laws);
    this.restart();
  }

  restart() {
    this.sampled = 0;
    this.behind = 0;
    this.pushed = null;
    this.touched = Object.keys(this.overrides).length > 0;
    for (const [law, member] of this.members) this.begun(member, law);
    this.path = this.desiredPath();
  }

  begun(member, law) {
    const { tubes, stops, obstacles } = this.scene;
    return member.begin(this.plan(law), this.seed, tubes[law], stops ? obstacles : []);
  }

  // Shows these laws; one that is new catches up from the start, with the settings of now.
  choose(laws) {
    for (const [law, member] of this.members) if (!laws.includes(law)) { member.free(); this.members.delete(law); }
    const order = this.told.laws.map((item) => item.name).filter((law) => laws.includes(law));
    const members = new Map();
    for (const law of order) members.set(law, this.members.get(law) ?? this.arrived(law));
    this.members = members;
  }

  arrived(law) {
    const member = this.begun(new Member(this.engine, law), law);
    for (let k = 0; k < this.sampled && !member.ended; ++k) this.drive(member);
    return member;
  }

  // Another variant of the scene, while the robots drive on.
  take(variant) {
    const time = this.time;
    this.variant = variant;
    this.touched = true;
    this.sampled = Math.round(time / variant.period);
    for (const [law, member] of this.members) member.handOver(this.plan(law), this.seed, time);
  }

  // Parameters that hold for all laws from now on, in place of the scene's.
  set(values) { this.replace({ ...this.overrides, ...values }); }

  replace(overrides) {
    const before = this.overrides;
    this.overrides = overrides;
    this.touched = true;
    for (const [law, member] of this.members) {
      member.robot.load(this.plan(law).rows);
      member.braked = false;
    }
    if (before["base.delay"] !== overrides["base.delay"]) this.restart(); // commands under way are counted at the start
    if ([before, overrides].some((set) => Object.keys(set).some((name) => name.startsWith("ref_")))) this.path = this.desiredPath();
  }

  // The value that holds for a parameter, of whichever law has it.
  value(name) {
    if (name in this.overrides) return this.overrides[name];
    for (const law of [...this.laws, ...this.told.laws.map((item) => item.name)]) {
      const row = this.variant.laws[law]?.rows[0] ?? {}, base = this.scene.base[law];
      if (name in row) return Number(row[name]);
      if (name in base) return Number(base[name]);
    }
    return NaN;
  }

  // Least and largest velocity of an axis that are within its limits.
  sides(axis) {
    const most = this.value(`limits.v_u1[${axis}]`), [low, high] = ["v_min", "v_max"].map((side) => this.value(`limits.${side}[${axis}]`));
    return [Number.isNaN(low) ? -most : low, Number.isNaN(high) ? most : high];
  }

  push(force) {
    this.pushed = { until: this.time + PUSH_SECONDS, force };
    this.touched = true;
    for (const member of this.members.values()) if (!member.braked) member.robot.set({ "disturbance.push[1]": force });
  }

  sample() {
    if (this.pushed && this.time >= this.pushed.until) {
      this.pushed = null;
      this.replace(this.overrides);
    }
    for (const member of this.members.values()) this.drive(member);
    this.sampled += 1;
  }

  drive(member) {
    member.sample();
    const { stops } = this.scene;
    if (!stops || member.ended) return;
    const [forwards, turning] = [1, 2].map((axis) => this.value(`disturbance.push[${axis}]`));
    member.brake(stops.rest, [this.pushed?.force ?? forwards, turning]);
  }

  // So much simulated time, unless it takes longer than `budget` ms; true if all of it was done.
  advance(seconds, budget) {
    this.behind += seconds;
    const begun = performance.now();
    const count = Math.floor(this.behind / this.period + 1e-6);
    this.behind -= count * this.period;
    for (let k = 0; k < count; ++k) {
      this.sample();
      if (k % 32 === 31 && performance.now() - begun > budget) { this.behind = 0; return false; }
    }
    return true;
  }

  // The desired path over the scene's duration, from the loop with the longest period.
  desiredPath() {
    const variants = this.scene.variants.filter((item) => !item.refusal);
    const slow = variants.reduce((a, b) => (b.period > a.period ? b : a));
    const law = this.told.laws[0].name;
    const robot = this.engine.robot(slow.laws[law].loop);
    robot.begin(planOf(this.told, this.scene, slow, law, this.overrides), 0);
    const count = Math.min(Math.round(this.scene.duration / slow.period), 20000), points = [];
    for (let k = 0; k < count; ++k) {
      robot.sample();
      points.push([robot.column("x_d"), robot.column("y_d")]);
    }
    robot.free();
    this.pathPeriod = slow.period;
    return points;
  }
}
