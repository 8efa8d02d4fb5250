// Numbers and controls beside the column.

import { MATERIALS, PRODUCTS, INSIDE } from "./colours.js";

const $ = (id) => document.getElementById(id);

const READ_MS = 200;

export function digits(value, count = 3) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(count))) : "–";
}

// What the run is doing, known before there is anything to draw
export function showState({ state, text }) {
  $("state").textContent = text;
  $("state").dataset.state = state;
}

// The runs of a sweep, as buttons; those without frames cannot be chosen
export function showRuns(runs, chosen, choose) {
  $("runs").hidden = false;
  const known = [...$("runs").children].map((button) => button.textContent).join("/");
  if (known !== runs.map(({ name }) => name).join("/")) {
    $("runs").replaceChildren(...runs.map(({ name }) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.onclick = () => choose(name);
      return button;
    }));
  }
  for (const [k, { name, state }] of runs.entries()) {
    const button = $("runs").children[k];
    button.dataset.state = state;
    button.disabled = !state;
    button.title = state || "no frames were recorded";
    button.setAttribute("aria-current", name === chosen);
  }
}

// The part of a slider's way, for factors from 1/4 to 4 of the case's value
const factor = (place) => 4 ** place;
const place = (value) => Math.log(value) / Math.log(4);

export class Panel {
  constructor(column, send) {
    this.column = column;
    this.send = send;
    this.asked = { gas: 1, loading: 1, pause: false, speed: 1 };
    $("colour").onchange = () => { column.colourBy($("colour").value); this.legend(); };
    $("slice").onchange = () => { column.showGas($("slice").checked); this.gasScale(); };
    $("larger").oninput = () => column.enlarge(Number($("larger").value));
    $("pause").onclick = () => this.ask({ pause: !this.asked.pause });
    $("speed").onchange = () => this.ask({ speed: Number($("speed").value) });
    for (const name of ["gas", "loading"]) {
      $(name).oninput = () => this.ask({ [name]: Number(factor(Number($(name).value)).toPrecision(4)) });
    }
    $("restart").onclick = () => this.send({ restart: true });
    $("time").oninput = () => this.send({ seek: Number($("time").value) });
  }

  start(message) {
    clearTimeout(this.due);
    this.due = null;
    this.scene = message.scene;
    this.about = message.about;
    document.title = `${message.about.name} – Elutria`;
    $("name").textContent = message.about.name;
    document.body.dataset.mode = message.mode;
    $("time").max = message.about.duration_s || 1;
    this.follow(message.control);
    this.legend();
    this.column.colourBy($("colour").value);
    this.column.showGas($("slice").checked);
    this.column.enlarge(Number($("larger").value));
    $("d50").textContent = "–";
    $("products").replaceChildren();
  }

  ask(change) {
    Object.assign(this.asked, change);
    this.follow(this.asked);
    this.send({ control: this.asked });
  }

  // What is asked for, by this page or by another
  follow(control) {
    this.asked = { ...control };
    $("pause").textContent = control.pause ? "go on" : "pause";
    $("speed").value = String(control.speed);
    for (const name of ["gas", "loading"]) {
      if (document.activeElement !== $(name)) $(name).value = place(control[name]);
    }
    $("gas-asked").textContent = `${digits(control.gas * this.about.gas_velocity_m_s)} m/s`;
    $("loading-asked").textContent = this.about.loading
      ? `${digits(control.loading * this.about.loading)} kg/kg` : `${digits(control.loading)} of the case's`;
  }

  // Nobody reads numbers that change thirty times a second
  numbers(frame, pace, rate) {
    this.newest = [frame, pace, rate];
    this.due ??= setTimeout(() => {
      this.due = null;
      this.write(...this.newest);
    }, READ_MS);
  }

  write(frame, pace, rate) {
    $("time-now").textContent = `${frame.time.toFixed(2)} s`;
    if (document.activeElement !== $("time")) $("time").value = frame.time;
    $("inside").textContent = `${frame.count} parcels, ${digits(1000 * frame.inside)} g`;
    $("fed").textContent = `${frame.fed} parcels`;
    $("pace").textContent = `${digits(pace, 2)} of real time`;
    $("rate").textContent = `${Math.round(rate)} a second`;
    $("gas-now").textContent = `${digits(frame.gas * this.about.gas_velocity_m_s)} m/s`;
    this.gasScale();
    $("lost-row").hidden = frame.lost === 0;
    $("lost").textContent = `${frame.lost} parcels`;
  }

  gasScale() {
    $("slice-scale").hidden = !$("slice").checked;
    $("slice-high").textContent = `${digits(this.column.slice.fastest / 1000, 2)} m/s`;
  }

  statistics(data) {
    const [d50, low, high] = (data.d50 ?? [NaN]).map((size) => digits(size === null ? NaN : 1e6 * size));
    $("d50").textContent = data.d50 ? `${d50} µm (${low} to ${high})` : "–";
    $("since").textContent = `from ${digits(data.since, 3)} s`;
    const head = ["", ...this.scene.products.map((name) => `${name}, g`)];
    const rows = data.products.map((row) => [row.material, ...row.mass_kg.map((m) => digits(1000 * m, 4))]);
    $("products").replaceChildren(...[head, ...rows].map((cells, k) => {
      const line = document.createElement("tr");
      line.append(...cells.map((text) => {
        const cell = document.createElement(k ? "td" : "th");
        cell.textContent = text;
        return cell;
      }));
      return line;
    }));
  }

  legend() {
    const by = $("colour").value;
    const entries = by === "material"
      ? this.scene.materials.map(({ name }, k) => [MATERIALS[k % MATERIALS.length], name])
      : by === "fate"
        ? [[INSIDE, "still inside"], ...this.scene.products.map((name, k) => [PRODUCTS[k % PRODUCTS.length], name])]
        : [];
    const scale = { size: ["small", "large"], velocity: ["falls 5 m/s", "rises 5 m/s"] }[by];
    $("legend").replaceChildren(...entries.map(([colour, name]) => {
      const item = document.createElement("span");
      const dot = document.createElement("i");
      dot.style.background = colour;
      item.append(dot, name);
      return item;
    }));
    $("scale").hidden = !scale;
    if (scale) [$("scale-low").textContent, $("scale-high").textContent] = scale;
  }
}
