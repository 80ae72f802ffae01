// Small charts over time, a line for each law.

const NICE = [1, 1.5, 2, 3, 4, 5, 7.5, 10];

function niceAbove(value) {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * NICE.find((item) => item * power >= value * (1 - 1e-9));
}

function shownNumber(value, digits = 3) {
  if (!Number.isFinite(value)) return value > 0 ? "∞" : value < 0 ? "−∞" : "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

// A value that so large a share of others is below; peaks beyond it leave the chart.
function shareOf(values, share) {
  const stride = Math.max(1, Math.floor(values.length / 500)), some = [];
  for (let k = 0; k < values.length; k += stride) if (values[k] === values[k]) some.push(values[k]);
  some.sort((a, b) => a - b);
  return some.length ? some[Math.floor(share * (some.length - 1))] : 0;
}

// A canvas that is as sharp as the screen.
class Sheet {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.fit();
  }

  fit() {
    const dots = window.devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    this.width = Math.max(box.width, 40);
    this.height = Math.max(box.height, 40);
    this.canvas.width = Math.round(this.width * dots);
    this.canvas.height = Math.round(this.height * dots);
    this.pen.setTransform(dots, 0, 0, dots, 0, 0);
  }
}

// `what`: column, marks of the fleet (limits, thresholds, and what varies: `at` a time); most (of the marks) and share (of the rows) that
// are shown, floor, ceiling and least top of the range; times: what a number is written as, over what it is.
class Chart extends Sheet {
  constructor(canvas, what) {
    super(canvas);
    this.what = what;
  }

  draw(fleet, look, from, to) {
    const { pen } = this, frame = { left: 38, right: this.width - 6, top: 6, low: this.height - 16 };
    const marks = this.what.marks(fleet);
    const [bottom, top] = this.range(fleet, marks, from, to);
    const X = (t) => frame.left + ((t - from) / (to - from)) * (frame.right - frame.left);
    const Y = (value) => frame.low - ((value - bottom) / (top - bottom)) * (frame.low - frame.top);
    pen.clearRect(0, 0, this.width, this.height);
    this.shade(look, frame, X, Y, marks, bottom, top, from, to);
    this.axes(look, frame, X, Y, bottom, top, from, to);
    pen.save();
    pen.beginPath();
    pen.rect(frame.left, frame.top - 2, frame.right - frame.left, frame.low - frame.top + 4);
    pen.clip();
    for (const member of fleet.members.values()) this.line(member, look, from, to, X, Y, frame);
    pen.restore();
    this.beyond(fleet, look, from, frame, bottom, top);
  }

  // Names those whose line leaves the chart, with how far it goes, at the edge where it leaves.
  beyond(fleet, look, from, frame, bottom, top) {
    const { pen } = this, ends = { "▲": [frame.right, frame.top + 7], "▼": [frame.right, frame.low - 7] };
    pen.font = look.small;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = look.paper;
    for (const { history, law } of fleet.members.values()) {
      const values = history.columns[this.what.column].subarray(history.after(from), history.length);
      let low = bottom, high = top;
      for (let k = 0; k < values.length; ++k) { if (values[k] < low) low = values[k]; else if (values[k] > high) high = values[k]; }
      for (const [arrow, value, left] of [["▲", high, high > top], ["▼", low, low < bottom]]) {
        if (!left) continue;
        const text = `${arrow} ${look.laws[law].label} ${shownNumber(value * (this.what.times ?? 1), 2)}`, [x, y] = ends[arrow];
        pen.fillStyle = look.laws[law].colour;
        pen.strokeText(text, x, y);
        pen.fillText(text, x, y);
        ends[arrow][0] -= pen.measureText(text).width + 10;
      }
    }
  }

  // What is beyond a limit, and the limits' edges.
  shade(look, frame, X, Y, marks, bottom, top, from, to) {
    const { pen } = this, width = frame.right - frame.left;
    pen.fillStyle = look.beyond;
    pen.lineWidth = 1.2;
    for (const { value, beyond, dotted, law, at } of marks) {
      if (value <= bottom || value >= top) continue;
      const edge = Y(value);
      pen.strokeStyle = law ? look.laws[law].colour : look.limit;
      if (beyond > 0) pen.fillRect(frame.left, frame.top, width, Math.max(edge - frame.top, 0));
      if (beyond < 0) pen.fillRect(frame.left, edge, width, Math.max(frame.low - edge, 0));
      pen.setLineDash(dotted ? [1.5, 3] : []);
      pen.beginPath();
      const level = (t) => (at ? Y(at(Math.max(t, 0))) : edge), parts = at ? 200 : 1;
      for (let i = 0; i <= parts; ++i) { const t = from + ((to - from) * i) / parts; pen.lineTo(X(t), level(t)); }
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  axes(look, frame, X, Y, bottom, top, from, to) {
    const { pen } = this;
    pen.font = look.small;
    pen.fillStyle = look.muted;
    pen.strokeStyle = look.grid;
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const values = bottom < 0 ? [bottom, 0, top] : [bottom, (bottom + top) / 2, top];
    for (const value of values) {
      pen.beginPath();
      pen.moveTo(frame.left, Y(value));
      pen.lineTo(frame.right, Y(value));
      pen.stroke();
      pen.fillText(shownNumber(value * (this.what.times ?? 1)), frame.left - 5, Y(value));
    }
    pen.textBaseline = "top";
    const every = niceAbove((to - from) / 4);
    for (let t = Math.ceil(from / every) * every; t <= to; t += every) {
      pen.textAlign = X(t) < frame.left + 14 ? "left" : "center"; // clear of the number beside the corner
      if (X(t) < frame.right - 14) pen.fillText(`${shownNumber(t)} s`, X(t), frame.low + 4);
    }
  }

  // Rows fall into columns of some pixels, at fixed times, each drawn as the span of its values.
  line(member, look, from, to, X, Y, frame) {
    const { pen, what } = this, { history, law } = member, times = history.columns.t, values = history.columns[what.column];
    const first = Math.max(history.after(from) - 1, 0), per = (1.5 * (to - from)) / Math.max(frame.right - frame.left, 1);
    pen.strokeStyle = look.laws[law].colour;
    pen.setLineDash(look.laws[law].dash);
    pen.lineWidth = 1.7;
    pen.lineJoin = "round";
    pen.beginPath();
    let k = first, open = false;
    while (k < history.length) {
      const begun = values[k], t = times[k], end = (Math.floor(t / per) + 1) * per;
      let low = begun, high = begun;
      for (k += 1; k < history.length && times[k] < end; ++k) {
        const value = values[k];
        if (value < low) low = value;
        if (value > high) high = value;
      }
      if (!(low === low && high === high)) { open = false; continue; }
      const x = X(t);
      const [one, other] = high - begun < begun - low ? [high, low] : [low, high];
      if (open) pen.lineTo(x, Y(one)); else pen.moveTo(x, Y(one));
      if (high !== low) pen.lineTo(x, Y(other));
      open = true;
    }
    pen.stroke();
    pen.setLineDash([]);
  }

  // From nice numbers, so that it stands still while lines move.
  range(fleet, marks, from, to) {
    const { what } = this;
    let low = 0, high = 0, most = Infinity;
    for (const { value } of marks) { low = Math.min(low, value * 1.15); high = Math.max(high, value * 1.15); }
    if (what.most) most = what.most * Math.max(...marks.map((item) => Math.abs(item.value)));
    for (const { history } of fleet.members.values()) {
      const values = history.columns[what.column];
      const shown = values.subarray(history.after(from), history.length);
      if (what.share) { high = Math.max(high, shareOf(shown, what.share)); continue; }
      for (let k = 0; k < shown.length; ++k) {
        if (shown[k] < low) low = shown[k];
        if (shown[k] > high) high = shown[k];
      }
    }
    const bound = (value) => Math.min(niceAbove(Math.min(value, most)), most);
    const top = Math.max(bound(high), marks.some((item) => item.law) ? 0 : what.least ?? 0);
    return [what.floor !== undefined ? Math.max(-bound(-low), what.floor) : -bound(-low), what.ceiling ?? top];
  }
}
