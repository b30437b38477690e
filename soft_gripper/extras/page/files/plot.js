// A plot of the last seconds of some signals: a line for every entry, a hue for every signal.

const WINDOW = 10; // s
const HUES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
const MARGIN = {left: 46, right: 8, top: 8, bottom: 18}; // px
const LEAST = {"1": 1e-4}; // half the smallest range that is drawn; of what has a unit, 0.05 of it

export class Plot {
  // `about`: unit, scale and signals with the labels of their entries; `legend`: where the lines are named.
  constructor(canvas, legend, about) {
    [this.canvas, this.legend, this.about] = [canvas, legend, about];
    this.samples = []; // [time, {signal: [entries]}]
    this.nameLines();
  }

  add(time, values) {
    if (this.samples.length && time <= this.samples.at(-1)[0]) this.samples = []; // the run was reset
    const scaled = {};
    for (const signal of Object.keys(this.about.signals)) {
      scaled[signal] = (values[signal] ?? []).map((v) => (v === null ? null : v * this.about.scale));
    }
    this.samples.push([time, scaled]);
    while (this.samples[0][0] < time - WINDOW) this.samples.shift();
  }

  // Of several signals each has a hue; of a single one each entry.
  lines() {
    const signals = Object.entries(this.about.signals);
    return signals.flatMap(([signal, labels], s) =>
      labels.map((label, i) => ({
        signal, i, label,
        color: HUES[(signals.length > 1 ? s : i) % HUES.length],
        faint: signals.length > 1 ? 0.25 + (0.75 * (labels.length - i)) / labels.length : 1,
      })));
  }

  nameLines() {
    const several = Object.keys(this.about.signals).length > 1;
    const named = several ? this.lines().filter((line) => line.i === 0) : this.lines();
    this.legend.replaceChildren(...(named.length < 2 ? [] : named.map((line) => {
      const [item, mark] = [document.createElement("span"), document.createElement("i")];
      mark.style.background = line.color;
      item.append(mark, several ? line.signal.split(".").slice(0, -1).join(" ") : line.label);
      return item;
    })));
  }

  draw() {
    const ratio = window.devicePixelRatio, {clientWidth: width, clientHeight: height} = this.canvas;
    [this.canvas.width, this.canvas.height] = [width * ratio, height * ratio];
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "11px system-ui, sans-serif";
    if (!this.samples.length) return;
    const end = Math.max(this.samples.at(-1)[0], WINDOW), [low, high] = this.range();
    const x = (t) => MARGIN.left + ((t - end + WINDOW) / WINDOW) * (width - MARGIN.left - MARGIN.right);
    const y = (v) => MARGIN.top + ((high - v) / (high - low)) * (height - MARGIN.top - MARGIN.bottom);
    this.drawGrid(pen, x, y, [end - WINDOW, end], [low, high], width, height);
    for (const line of this.lines()) this.drawLine(pen, x, y, line);
  }

  range() {
    let [low, high] = [Infinity, -Infinity];
    for (const [, values] of this.samples) {
      for (const v of Object.values(values).flat()) {
        if (v !== null) [low, high] = [Math.min(low, v), Math.max(high, v)];
      }
    }
    if (low > high) return [-1, 1];
    const room = Math.max(0.05 * (high - low), LEAST[this.about.unit] ?? 0.05);
    return [low - room, high + room];
  }

  drawGrid(pen, x, y, times, values, width, height) {
    [pen.strokeStyle, pen.fillStyle, pen.lineWidth] = ["#dfe4ea", "#5b6775", 1];
    const rows = ticks(...values, 4), digits = Math.max(0, -Math.floor(Math.log10(rows[1] - rows[0]) + 1e-9));
    [pen.textAlign, pen.textBaseline] = ["right", "middle"];
    for (const v of rows) {
      stroke(pen, [[MARGIN.left, y(v)], [width - MARGIN.right, y(v)]]);
      pen.fillText(v.toFixed(digits), MARGIN.left - 5, y(v));
    }
    [pen.textAlign, pen.textBaseline] = ["center", "top"];
    for (const t of ticks(...times, 5)) {
      stroke(pen, [[x(t), MARGIN.top], [x(t), height - MARGIN.bottom]]);
      pen.fillText(`${t} s`, Math.min(x(t), width - MARGIN.right - 10), height - MARGIN.bottom + 4);
    }
  }

  drawLine(pen, x, y, {signal, i, color, faint}) {
    [pen.strokeStyle, pen.globalAlpha, pen.lineWidth] = [color, faint, 1.6];
    let piece = [];
    for (const [time, values] of this.samples) {
      const v = values[signal][i];
      if (v === null || v === undefined) {
        stroke(pen, piece);
        piece = [];
      } else piece.push([x(time), y(v)]);
    }
    stroke(pen, piece);
    pen.globalAlpha = 1;
  }
}

function stroke(pen, points) {
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.stroke();
}

// At most `most` + 1 round numbers from low to high.
function ticks(low, high, most) {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((s) => s * power >= raw * 0.999);
  const found = [];
  for (let n = Math.ceil(low / step); n * step <= high + 1e-9 * step; n++) found.push(n * step);
  return found;
}
