// The robots from above, on their paths, with what can be grabbed.

const TRAIL_SECONDS = 60;
const TRAIL_POINTS = 900;
const REACH = 26;

class Plane extends Sheet {
  constructor(canvas, body) {
    super(canvas);
    this.body = body;
    this.view = null;
  }

  // Centre and metres per pixel that show path, start and robots; those who left are pointed at.
  wanted(fleet) {
    const { scene, path } = fleet, xs = [], ys = [];
    for (const [x, y] of path) { xs.push(x); ys.push(y); }
    xs.push(scene.start[0]);
    ys.push(scene.start[1]);
    const span = (list) => [list.reduce((a, b) => Math.min(a, b)), list.reduce((a, b) => Math.max(a, b))];
    let [left, right] = span(xs), [low, high] = span(ys);
    const room = 1.2 * Math.max(right - left, high - low, 1);
    const near = [left - room, right + room, low - room, high + room];
    for (const { history } of fleet.members.values()) {
      const x = history.last("x"), y = history.last("y");
      if (x > near[0] && x < near[1] && y > near[2] && y < near[3]) {
        [left, right, low, high] = [Math.min(left, x), Math.max(right, x), Math.min(low, y), Math.max(high, y)];
      }
    }
    const border = 0.75;
    const scale = Math.max((right - left + 2 * border) / this.width, (high - low + 2 * border) / this.height);
    return { x: (left + right) / 2, y: (low + high) / 2, scale };
  }

  follow(fleet, gently) {
    const next = this.wanted(fleet), share = gently && this.view ? 0.08 : 1, old = this.view ?? next;
    const mixed = (name) => old[name] + share * (next[name] - old[name]);
    this.view = { x: mixed("x"), y: mixed("y"), scale: mixed("scale") };
  }

  X(x) { return this.width / 2 + (x - this.view.x) / this.view.scale; }
  Y(y) { return this.height / 2 - (y - this.view.y) / this.view.scale; }
  world(px, py) {
    return [this.view.x + (px - this.width / 2) * this.view.scale, this.view.y - (py - this.height / 2) * this.view.scale];
  }

  draw(fleet, look, held) {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, this.height);
    this.grid(look);
    this.obstacles(fleet.scene.obstacles, look);
    for (const member of fleet.members.values()) this.tube(fleet, member, look);
    this.desired(fleet, look);
    for (const member of fleet.members.values()) this.trail(member, look);
    const order = [...fleet.members.values()].reverse();
    for (const member of order) this.robot(member, fleet, look, held === member);
    if (fleet.scene.stops) [...fleet.members.values()].forEach((member, k) => this.bar(fleet, member, look, k));
    this.labels(order, look);
  }

  grid(look) {
    const { pen } = this, step = niceAbove(70 * this.view.scale);
    pen.strokeStyle = look.grid;
    pen.fillStyle = look.muted;
    pen.font = look.small;
    pen.lineWidth = 1;
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    const [left, high] = this.world(0, 0), [right, low] = this.world(this.width, this.height);
    for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
      this.stroke([[this.X(x), 0], [this.X(x), this.height]]);
      if (this.X(x) < this.width - 36) pen.fillText(`${shownNumber(Math.abs(x) < 1e-9 ? 0 : x)} m`, this.X(x) + 3, this.height - 5);
    }
    for (let y = Math.ceil(low / step) * step; y <= high; y += step) {
      this.stroke([[0, this.Y(y)], [this.width, this.Y(y)]]);
      if (this.Y(y) < this.height - 18 && this.Y(y) > 12) pen.fillText(`${shownNumber(Math.abs(y) < 1e-9 ? 0 : y)} m`, 4, this.Y(y) - 3);
    }
  }

  // Circles and polygons; a wall has two ends.
  obstacles(shapes, look) {
    const { pen } = this;
    pen.strokeStyle = look.muted;
    pen.fillStyle = look.grid;
    for (const shape of shapes) {
      pen.lineWidth = shape.length === 2 ? 5 : 1.5;
      pen.beginPath();
      if (Array.isArray(shape[0])) { for (const [x, y] of shape) pen.lineTo(this.X(x), this.Y(y)); pen.closePath(); }
      else pen.arc(this.X(shape[0]), this.Y(shape[1]), shape[2] / this.view.scale, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    }
  }

  // The body's disc, and ahead of it the way that the filter counts for a stop from this speed; bars
  // of several robots are beside one another.
  bar(fleet, member, look, k) {
    const { pen } = this, { state } = member.robot, at = member.robot.places.state, wide = 0.5 * member.radius;
    const [x, y, theta, v] = ["x", "y", "theta", "v1"].map((name) => state[at[name]]);
    const long = wayToStop(fleet.scene.stops, v), way = v < 0 ? -1 : 1, middle = way * (member.radius + long / 2);
    pen.strokeStyle = pen.fillStyle = look.laws[member.law].colour;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.arc(this.X(x), this.Y(y), member.radius / this.view.scale, 0, 2 * Math.PI);
    pen.stroke();
    if (Math.abs(v) < 1e-3) return;
    this.box(x - middle * Math.sin(theta), y + middle * Math.cos(theta), theta, [long, wide], 1.25 * (k - 1) * wide);
    pen.globalAlpha = 0.6;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
  }

  stroke(points) {
    const { pen } = this;
    pen.beginPath();
    points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
  }

  // The certified corridor about the desired path, to scale.
  tube(fleet, member, look) {
    const { pen } = this, tube = fleet.tube(member);
    if (!tube) return;
    const places = [], stride = this.stride(fleet);
    fleet.path.forEach(([x, y], k) => {
      const at = places[places.length - 1], width = widthOf(tube, k * fleet.pathPeriod);
      if (k % stride || k * fleet.pathPeriod >= Number(tube.until)) return;
      if (at && at.x === x && at.y === y) at.width = Math.max(at.width, width); // it stands still
      else places.push({ x, y, width });
    });
    const edge = (side) => places.map(({ x, y, width }, k) => {
      const before = places[Math.max(k - 1, 0)], after = places[Math.min(k + 1, places.length - 1)];
      const [a, b] = [after.x - before.x, after.y - before.y], long = Math.hypot(a, b) || 1;
      return [this.X(x - (side * width * b) / long), this.Y(y + (side * width * a) / long)];
    });
    pen.fillStyle = look.laws[member.law].colour;
    pen.globalAlpha = 0.25;
    pen.beginPath();
    for (const [x, y] of [...edge(1), ...edge(-1).reverse()]) pen.lineTo(x, y);
    pen.fill();
    pen.globalAlpha = 1;
  }

  // One in so many points of the desired path is drawn.
  stride(fleet) { return Math.max(1, Math.floor(fleet.path.length / 600)); }

  // The desired path, in as many points as are seen.
  along(fleet) {
    const stride = this.stride(fleet);
    this.stroke(fleet.path.filter((_, i) => i % stride === 0).map(([x, y]) => [this.X(x), this.Y(y)]));
  }

  desired(fleet, look) {
    const { pen } = this;
    pen.strokeStyle = look.muted;
    pen.lineWidth = 1.6;
    pen.setLineDash([2, 4]);
    this.along(fleet);
    const one = fleet.members.values().next().value;
    if (one && one.robot.sampled) {
      pen.setLineDash([5, 4]);
      pen.lineWidth = 1.4;
      this.box(one.robot.column("x_d"), one.robot.column("y_d"), one.robot.column("theta_d"), this.body.size, 0);
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  trail(member, look) {
    const { pen } = this, { columns, length } = member.history, end = member.history.last("t");
    const first = member.history.after(end - TRAIL_SECONDS), stride = Math.max(1, Math.floor((length - first) / TRAIL_POINTS));
    pen.strokeStyle = look.laws[member.law].colour;
    pen.setLineDash(look.laws[member.law].dash.map((item) => 1.3 * item));
    pen.lineWidth = 2.2;
    pen.lineJoin = "round";
    pen.beginPath();
    for (let k = first - (first % stride), open = false; k < length; k += stride) {
      let jumped = false;
      for (let i = Math.max(k - stride + 1, 0); i <= k; ++i) jumped = jumped || columns.jump[i] !== 0;
      const x = this.X(columns.x[k]), y = this.Y(columns.y[k]);
      if (open && !jumped) pen.lineTo(x, y); else pen.moveTo(x, y);
      open = true;
    }
    if (length) pen.lineTo(this.X(member.history.last("x")), this.Y(member.history.last("y")));
    pen.stroke();
    pen.setLineDash([]);
  }

  // Path of a box with its front along theta: (-sin, cos) is ahead, (cos, sin) to the right.
  box(x, y, theta, [long, wide], aside) {
    const { pen } = this, ahead = [-Math.sin(theta), Math.cos(theta)], right = [ahead[1], -ahead[0]];
    pen.beginPath();
    for (const [i, j] of [[1, 1], [1, -1], [-1, -1], [-1, 1]]) {
      const l = (i * long) / 2, w = (j * wide) / 2 + aside;
      pen.lineTo(this.X(x + l * ahead[0] + w * right[0]), this.Y(y + l * ahead[1] + w * right[1]));
    }
    pen.closePath();
  }

  robot(member, fleet, look, held) {
    const { pen, body } = this, state = member.robot.state, at = member.robot.places.state;
    const [x, y, theta, v1, omega] = ["x", "y", "theta", "v1", "omega"].map((name) => state[at[name]]);
    member.seen = { x, y, theta, beyond: [v1, omega].some((v, i) => v < fleet.sides(i + 1)[0] || v > fleet.sides(i + 1)[1]) };
    const colour = look.laws[member.law].colour;
    this.box(x, y, theta, body.size, 0);
    pen.globalAlpha = held ? 0.6 : 0.3;
    pen.fillStyle = colour;
    pen.fill();
    pen.globalAlpha = 1;
    pen.strokeStyle = member.seen.beyond ? look.limit : colour;
    pen.lineWidth = member.seen.beyond ? 3.5 : 1.8;
    pen.stroke();
    pen.fillStyle = look.ink;
    for (const side of [1, -1]) { this.box(x, y, theta, body.wheel, side * body.track); pen.fill(); }
    pen.strokeStyle = look.ink;
    pen.lineWidth = 2.5;
    pen.lineCap = "round";
    const nose = body.size[0] / 2;
    this.stroke([[this.X(x), this.Y(y)], [this.X(x - nose * Math.sin(theta)), this.Y(y + nose * Math.cos(theta))]]);
    pen.lineCap = "butt";
  }

  // Names beside the robots, one below the other where robots stand together; arrows to those who left.
  labels(members, look) {
    const { pen } = this, taken = [];
    pen.font = look.bold;
    pen.textBaseline = "middle";
    for (const member of members) {
      const { label, colour } = look.laws[member.law], { seen } = member;
      const px = this.X(seen.x), py = this.Y(seen.y), edge = 16;
      const away = !(px > 0 && px < this.width && py > 0 && py < this.height);
      const above = member.obstacles.length ? member.radius / this.view.scale + 30 : 0; // clear of the bars
      let x = clamp(px + (away ? 0 : 24), edge, this.width - 60), y = clamp(py - (away ? 0 : above || 22), edge, this.height - edge);
      const way = above || y > this.height / 2 ? -17 : 17;
      while (taken.some((other) => Math.abs(other.x - x) < 70 && Math.abs(other.y - y) < 17)) y += way;
      taken.push({ x, y });
      const word = member.carried.hit ? `${label} drove into it` : member.ended ? `${label} gave up` : seen.beyond ? `${label} too fast` : label;
      const metres = Math.hypot(seen.x - this.view.x, seen.y - this.view.y);
      const text = away ? `${word}, ${shownNumber(metres, 2)} m away` : word;
      x = clamp(x, edge, this.width - pen.measureText(text).width - 8);
      pen.textAlign = "left";
      pen.lineWidth = 4;
      pen.strokeStyle = look.paper;
      pen.lineJoin = "round";
      pen.strokeText(text, x, y);
      pen.fillStyle = seen.beyond ? look.limit : colour;
      pen.fillText(text, x, y);
    }
  }

  // The robot that is nearest to a point of the canvas, if it is near.
  near(fleet, px, py) {
    const reach = Math.max(REACH, (0.45 * this.body.size[0]) / this.view.scale);
    const distances = [...fleet.members.values()].filter((member) => member.seen).map((member) => ({
      member, distance: Math.hypot(this.X(member.seen.x) - px, this.Y(member.seen.y) - py),
    }));
    const nearest = distances.reduce((a, b) => (b.distance < a.distance ? b : a), { distance: Infinity });
    return nearest.distance <= reach ? nearest.member : null;
  }
}
