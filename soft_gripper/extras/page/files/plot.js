// A plot of the last seconds of some signals: a line for every entry. Few lines have hues; entries of many have colours
// along a scale, from the first to the last, and signals of several entries each a dash.

const WINDOW = 10; // s
const HUES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
const SCALE = ["#440154", "#3b528b", "#21908c", "#5dc863", "#c8b020"]; // of entries: dark to bright, readable on white
const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3]];
const NAMED = 5; // entries of many that the legend names
const MARGIN = {left: 46, right: 8, top: 8, bottom: 18}; // px
// Half the smallest range that is drawn, so that neither a constant nor noise below what matters is magnified: a share of
// the largest value, and not less than this, by the unit.
const LEAST_SHARE = 0.02, LEAST = {"1": 1e-3, N: 0.05, mm: 0.2, kPa: 0.5, deg: 0.2, "mN m": 0.5};

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

  // Signals of one entry have hues; entries of several have colours, by which they are told apart in each signal.
  lines() {
    const signals = Object.entries(this.about.signals);
    return signals.flatMap(([signal, labels], s) =>
      labels.map((label, i) => ({
        signal, i, label,
        color: labels.length === 1 ? HUES[s % HUES.length] : entryColor(i, labels.length),
        dash: labels.length === 1 ? [] : DASHES[s % DASHES.length],
      })));
  }

  nameLines() {
    const signals = Object.entries(this.about.signals), [[, labels]] = signals;
    const owner = (signal) => signal.split(".").slice(0, -1).join(" ");
    const items = [];
    if (signals.length > 1) {
      signals.forEach(([signal, own], s) => items.push(
        own.length === 1 ? mark(HUES[s % HUES.length], [], owner(signal)) : mark("#1d2733", DASHES[s % DASHES.length], owner(signal))));
    }
    if (labels.length > 1) {
      const last = labels.length - 1, count = Math.min(labels.length, last < 6 ? labels.length : NAMED);
      const named = [...Array(count).keys()].map((n) => Math.round((n * last) / (count - 1)));
      named.forEach((i, n) => items.push(
        mark(entryColor(i, labels.length), [], n ? labels[i] : `${this.about.axes} ${labels[i]}`)));
    }
    this.legend.replaceChildren(...items);
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
    const least = Math.max(LEAST_SHARE * Math.max(-low, high), LEAST[this.about.unit] ?? 0.05);
    const middle = (low + high) / 2, half = Math.max(0.55 * (high - low), least);
    return [middle - half, middle + half];
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

  drawLine(pen, x, y, {signal, i, color, dash}) {
    [pen.strokeStyle, pen.lineWidth] = [color, 1.6];
    pen.setLineDash(dash);
    let piece = [];
    for (const [time, values] of this.samples) {
      const v = values[signal][i];
      if (v === null || v === undefined) {
        stroke(pen, piece);
        piece = [];
      } else piece.push([x(time), y(v)]);
    }
    stroke(pen, piece);
    pen.setLineDash([]);
  }
}

// The colour of an entry: a hue of its own if there are few, else one along the scale.
function entryColor(i, count) {
  if (count <= HUES.length) return HUES[i];
  const place = (i / (count - 1)) * (SCALE.length - 1), before = Math.min(Math.floor(place), SCALE.length - 2);
  const part = (color, j) => parseInt(color.slice(1 + 2 * j, 3 + 2 * j), 16);
  const mixed = [0, 1, 2].map((j) => part(SCALE[before], j) + (place - before) * (part(SCALE[before + 1], j) - part(SCALE[before], j)));
  return `rgb(${mixed.map(Math.round).join(" ")})`;
}

// A line with its name, for a legend.
function mark(color, dash, text) {
  const [item, line] = [document.createElement("span"), document.createElement("canvas")];
  [line.width, line.height] = [18, 5];
  const pen = line.getContext("2d");
  [pen.strokeStyle, pen.lineWidth] = [color, 3];
  pen.setLineDash(dash);
  stroke(pen, [[0, 2.5], [18, 2.5]]);
  item.append(line, text);
  return item;
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
