// Sliders and buttons, and their keys.

const OTHER = {pause: "go on", record: "keep"}; // what a button that is on does
const PATIENCE = 500; // ms after a slider was moved here, in which what the station says of it is old

export class Controls {
  // `about`: sliders and buttons; `send` takes what is commanded.
  constructor(buttons, sliders, about, send) {
    this.send = send;
    this.keys = new Map(); // what each does, by its code
    this.buttons = new Map(about.buttons.map((button) => [button.name, this.makeButton(button)]));
    this.sliders = about.sliders.map((slider) => this.makeSlider(slider));
    buttons.append(...this.buttons.values());
    sliders.append(...this.sliders.map(({row}) => row));
  }

  makeButton({name, key, sign}) {
    const button = element("button", {type: "button", id: name}, labelled(name), ...marks(sign));
    const click = () => { this.send({button: name}); button.blur(); };
    button.addEventListener("click", click);
    if (key) this.keys.set(key, (event) => event.repeat || click());
    return button;
  }

  makeSlider({name, low, high, step, keys, signs}) {
    const [title, unit] = name.split(/ \[|\]/), limits = {min: low, max: high, step: "any"};
    const slider = element("input", {type: "range", ...limits, "aria-label": name});
    const number = element("input", {type: "number", ...limits, "aria-label": `${name}, as a number`});
    const found = {name, slider, number, moved: -Infinity};
    found.row = element("div", {className: "slider"}, element("span", {}, title),
                        element("span", {className: "value"}, number, ` ${unit}`),
                        element("span", {className: "track"}, ...marks(signs[0]), slider, ...marks(signs[1])));
    const move = (value) => {
      found.moved = performance.now();
      const within = Math.min(Math.max(value, low), high);
      show(found, within);
      this.send({slider: name, value: within});
    };
    const whole = (value) => low + step * Math.round((value - low) / step);
    slider.addEventListener("input", () => move(whole(slider.valueAsNumber)));
    number.addEventListener("change", () => { if (!isNaN(number.valueAsNumber)) move(number.valueAsNumber); });
    number.addEventListener("focus", () => number.select());
    keys.forEach((key, i) => key && this.keys.set(key, () => move(slider.valueAsNumber + (i ? step : -step))));
    return found;
  }

  // Keys act wherever the page or the scene in it was clicked, but not where something is written or chosen.
  press(event) {
    const act = this.keys.get(event.code);
    if (!act || event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.("select, [type=number]")) return;
    event.preventDefault();
    act(event);
  }

  // How things are, as the station says it; a slider that is being moved here stays.
  update({sliders, paused, zeroing, recording}) {
    const now = performance.now();
    for (const found of this.sliders) {
      const isOld = now - found.moved < PATIENCE || document.activeElement === found.number;
      if (!isOld) show(found, sliders[found.name]);
    }
    for (const [name, isOn] of Object.entries({pause: paused, zero: zeroing, record: recording})) {
      turn(this.buttons.get(name), isOn);
    }
  }
}

function show({slider, number}, value) {
  slider.value = value;
  number.value = +value.toFixed(1);
}

function labelled(name) {
  const texts = name in OTHER ? [name, OTHER[name]] : [name];
  return element("span", {className: "label"}, ...texts.map((text, i) => element("span", {ariaHidden: i > 0}, text)));
}

function turn(button, isOn) {
  if (!button) return;
  const [off, on] = button.firstChild.children;
  if (on) [off.ariaHidden, on.ariaHidden] = [isOn, !isOn];
  button.ariaPressed = isOn;
}

const marks = (sign) => (sign ? [element("kbd", {}, sign)] : []);

export function element(kind, attributes, ...content) {
  const made = document.createElement(kind);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in made) made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...content);
  return made;
}
