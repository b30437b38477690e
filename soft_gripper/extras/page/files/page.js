// The page of `soft-gripper play` and `live`: the scene in a frame, tables below it, controls and plots beside it, and how
// things are above.

import {Controls, element} from "./controls.js";
import {Plot} from "./plot.js";

const SLOW = 0.95; // a factor of real time below this is called slow
const LATE = 0.5; // s by which the picture may be behind without a word
const LONG = 50; // ms that drawing the scene may take before it is done less often
const AGAIN = 1000; // ms until another try to connect
const find = (id) => document.getElementById(id);
const about = await (await fetch("about.json")).json();
const plots = new Map(); // by their <figure>
const controls = new Controls(find("buttons"), find("sliders"), about, send);
let socket = null, hasEnded = false, drawing = false;

function show() {
  document.title = `${about.name} - soft-gripper ${about.command}`;
  find("name").textContent = about.name;
  find("description").textContent = find("description").title = about.description;
  window.addEventListener("keydown", (event) => controls.press(event));
  find("scene").addEventListener("load", openScene);
  if (find("scene").contentDocument?.readyState === "complete") openScene();
  find("add").addEventListener("click", () => addPlot(Object.keys(about.plots)[0]));
  about.shown.forEach(addPlot);
  connect();
}

function openScene() {
  const scene = find("scene").contentWindow;
  if (!scene.viewer) return; // it was refused
  const style = new scene.CSSStyleSheet();
  style.replaceSync(".dg.main { display: none !important }"); // Meshcat's own controls, which come later
  scene.document.adoptedStyleSheets = [style];
  scene.addEventListener("keydown", (event) => controls.press(event));
  easeDrawing(scene.viewer);
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

function addPlot(kind) {
  const figure = document.createElement("figure");
  figure.innerHTML = `<figcaption><select aria-label="signal"></select><span class="unit"></span>
    <button class="close" type="button" aria-label="close the plot">&times;</button></figcaption>
    <canvas></canvas><div class="legend"></div>`;
  const select = figure.querySelector("select");
  select.append(...Object.keys(about.plots).map((name) => new Option(name, name, false, name === kind)));
  select.addEventListener("change", () => { choose(figure, select.value); select.blur(); });
  figure.querySelector(".close").addEventListener("click", () => { figure.remove(); plots.delete(figure); ask(); });
  find("plots").append(figure);
  choose(figure, kind);
}

function choose(figure, kind) {
  const {unit} = about.plots[kind];
  figure.querySelector(".unit").textContent = unit === "1" ? "" : unit;
  plots.set(figure, new Plot(figure.querySelector("canvas"), figure.querySelector(".legend"), about.plots[kind]));
  ask();
}

function connect() {
  socket = new WebSocket(new URL("live", location.href.replace(/^http/, "ws")));
  socket.onopen = ask;
  socket.onmessage = ({data}) => take(JSON.parse(data));
  socket.onclose = () => {
    if (hasEnded) return;
    say("no connection", "halted");
    setTimeout(tryAgain, AGAIN);
  };
}

// Whoever answers and does not know this page plays something else.
async function tryAgain() {
  const answer = await fetch("about.json").catch(() => null);
  if (answer === null || answer.ok) connect();
  else {
    say("ended", "halted");
    note("This page is of a session that has ended. Open the address that soft-gripper has printed since.");
  }
}

function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function ask() {
  send({signals: [...new Set([...plots.values()].flatMap((plot) => Object.keys(plot.about.signals)))]});
}

function take({end, number, status, values}) {
  if (end) {
    hasEnded = true;
    say("ended", "halted");
    return;
  }
  send({seen: number});
  const {time, mode = status.paused ? "paused" : "live", alarm} = status;
  say(`${mode}${status.recording ? ", recording" : ""}`, alarm || status.recording ? "alarm" : status.paused ? "halted" : "");
  find("time").textContent = `${time.toFixed(1)} s`;
  const isLate = status.late > LATE;
  const pace = status.latency ?? `${status.factor.toFixed(2)} × real time`;
  find("pace").textContent = isLate ? `picture late by ${status.late.toFixed(1)} s, ${pace}` : pace;
  find("pace").className = isLate || status.factor < SLOW ? "slow" : "";
  note(status.note);
  controls.update(status);
  if (status.tables) find("tables").replaceChildren(...status.tables.map(table));
  if (!Object.keys(values).length) return;
  for (const plot of plots.values()) plot.add(time, values);
  if (!drawing) requestAnimationFrame(draw);
  drawing = true;
}

// A cell is its text, or its text and a class.
function table([caption, head, ...rows]) {
  const row = (kind) => (cells) => element("tr", {}, ...cells.map((cell) => {
    const [text, className = ""] = [cell].flat();
    return element(kind, {className}, text);
  }));
  return element("table", {}, element("caption", {}, caption), element("thead", {}, row("th")(head)),
                 element("tbody", {}, ...rows.map(row("td"))));
}

function say(mode, kind) {
  [find("mode").textContent, find("mode").className] = [mode, kind];
}

function note(text) {
  [find("note").textContent, find("note").hidden] = [text, !text];
}

function draw() {
  drawing = false;
  for (const plot of plots.values()) plot.draw();
}

show();
