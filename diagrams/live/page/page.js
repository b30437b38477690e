// The page of `soft-gripper play`: Meshcat in a frame, plots beside it, and how things are above.

import {Plot} from "./plot.js";

const SLOW = 0.95; // a factor of real time below this is called slow
const LONG = 50; // ms that drawing the scene may take before it is done less often
const find = (id) => document.getElementById(id);
const about = await (await fetch("about.json")).json();
const plots = new Map(); // by their <figure>
let events = null, drawing = false;

function show() {
  document.title = `${about.name} - soft-gripper play`;
  find("name").textContent = about.name;
  find("description").textContent = about.description;
  find("scene").addEventListener("load", () => {
    const {viewer} = find("scene").contentWindow;
    openControls(viewer.gui);
    easeDrawing(viewer);
  });
  find("scene").src = "scene";
  window.addEventListener("keydown", handOn);
  find("add").addEventListener("click", () => addPlot(Object.keys(about.plots)[0]));
  find("keys").append(...about.keys.map(([name, ...keys]) => {
    const row = document.createElement("tr"), cell = document.createElement("td");
    cell.textContent = name;
    row.append(cell, ...keys.map((key) => {
      const [cell, mark] = [document.createElement("td"), document.createElement("kbd")];
      mark.textContent = key;
      cell.append(mark);
      return cell;
    }));
    return row;
  }));
  about.shown.forEach(addPlot);
}

// Meshcat's controls are folded at first, and its tree of the scene is not. In a narrow window they would hide the scene.
function openControls(gui) {
  gui.__folders.Scene?.close();
  gui.width = 300;
  if (!matchMedia("(max-width: 800px)").matches) gui.open();
}

// Where graphics are slow, drawing takes half of the time: the rest is for the messages that say what to draw.
function easeDrawing(viewer) {
  const animate = viewer.animate.bind(viewer);
  let due = 0;
  viewer.animate = () => {
    const began = performance.now();
    if (began < due || !viewer.needs_render) return;
    animate();
    requestAnimationFrame((ended) => { due = ended - began > LONG ? ended + (ended - began) : 0; });
  };
}

// Keys act wherever the page has been clicked, but not where they choose a signal.
function handOn(event) {
  if (event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey || event.altKey) return;
  const scene = find("scene").contentWindow;
  scene.dispatchEvent(new scene.KeyboardEvent("keydown", {code: event.code, key: event.key}));
}

function addPlot(kind) {
  const figure = document.createElement("figure");
  figure.innerHTML = `<figcaption><select aria-label="signal"></select><span class="unit"></span>
    <button class="close" type="button" aria-label="close the plot">&times;</button></figcaption>
    <canvas></canvas><div class="legend"></div>`;
  const select = figure.querySelector("select");
  select.append(...Object.keys(about.plots).map((name) => new Option(name, name, false, name === kind)));
  select.addEventListener("change", () => { choose(figure, select.value); select.blur(); });
  figure.querySelector(".close").addEventListener("click", () => { figure.remove(); plots.delete(figure); listen(); });
  find("plots").append(figure);
  choose(figure, kind);
}

function choose(figure, kind) {
  const {unit} = about.plots[kind];
  figure.querySelector(".unit").textContent = unit === "1" ? "" : unit;
  plots.set(figure, new Plot(figure.querySelector("canvas"), figure.querySelector(".legend"), about.plots[kind]));
  listen();
}

function listen() {
  if (events) events.close();
  const signals = new Set([...plots.values()].flatMap((plot) => Object.keys(plot.about.signals)));
  events = new EventSource(`live?${[...signals].map((name) => `signal=${encodeURIComponent(name)}`).join("&")}`);
  events.onmessage = ({data}) => take(JSON.parse(data));
  events.addEventListener("end", () => { events.close(); say("ended", "halted"); });
  events.onerror = () => {
    say("no connection", "halted");
    // It was refused: if somebody answers, something else is played here now.
    if (events.readyState === EventSource.CLOSED) fetch("about.json").then(() => location.reload(), () => {});
  };
}

function take({status, values}) {
  say(`${status.paused ? "paused" : "live"}${status.recording ? ", recording" : ""}`,
      status.recording ? "recording" : status.paused ? "halted" : "");
  find("time").textContent = `${status.time.toFixed(1)} s`;
  find("factor").textContent = `${status.factor.toFixed(2)} × real time`;
  find("factor").className = status.factor < SLOW ? "slow" : "";
  find("note").textContent = status.note;
  find("note").hidden = !status.note;
  if (!Object.keys(values).length) return;
  for (const plot of plots.values()) plot.add(status.time, values);
  if (!drawing) requestAnimationFrame(draw);
  drawing = true;
}

function say(mode, kind) {
  [find("mode").textContent, find("mode").className] = [mode, kind];
}

function draw() {
  drawing = false;
  for (const plot of plots.values()) plot.draw();
}

show();
