// The page around answer(): sliders, pictures, tables. The state stands in the address.
(function () {
  const SVG = "http://www.w3.org/2000/svg";
  const byId = (id) => document.getElementById(id);
  const um = (d) => d === null || d === undefined ? "-" : (1e6 * d).toPrecision(4).replace(/\.?0+$/, (t) => t.startsWith(".") ? "" : t);
  const percent = (x) => (100 * x).toFixed(1);
  let state = asRun();

  function asRun() {
    const at = {}, feed = {};
    const whole = ATLAS.nodes.filter((node) => Object.values(node.curves).every((one) => one.cut !== null));
    const among = whole.length ? whole : ATLAS.nodes;
    ATLAS.axes.forEach((axis) => { at[axis.name] = among[Math.floor(among.length / 2)].at[axis.place]; });
    ATLAS.materials.forEach((one) => { feed[one.name] = { share: one.share, law: null }; });
    return { at: at, feed: feed };
  }

  // #gas_velocity_m_s=5.5&quartz.d63=0.0008&quartz.n=3&quartz.share=0.5
  function fromAddress() {
    new URLSearchParams(location.hash.slice(1)).forEach(function (text, name) {
      const value = Number(text);
      if (!isFinite(value)) return;
      if (name in state.at) { state.at[name] = value; return; }
      const place = name.lastIndexOf("."), fed = state.feed[name.slice(0, place)], entry = name.slice(place + 1);
      const material = ATLAS.materials.find((one) => one.name === name.slice(0, place));
      if (!fed || value < 0) return;
      if (entry === "share") fed.share = value;
      if ((entry === "d63" || entry === "n") && value > 0) {
        fed.law = fed.law || { d63: material.d63, n: material.n };
        fed.law[entry] = value;
      }
    });
  }

  function toAddress() {
    const words = new URLSearchParams(state.at);
    ATLAS.materials.forEach(function (one) {
      const fed = state.feed[one.name];
      if (fed.law) { words.set(one.name + ".d63", fed.law.d63); words.set(one.name + ".n", fed.law.n); }
      if (fed.share !== one.share) words.set(one.name + ".share", fed.share);
    });
    history.replaceState(null, "", "#" + words.toString());
  }

  function slider(label, unit, low, high, logarithmic, get, set) {
    const name = document.createElement("label"), range = document.createElement("input"), box = document.createElement("input"), cell = document.createElement("span");
    name.textContent = label;
    range.type = "range"; range.min = 0; range.max = 1000; range.step = 1;
    range.setAttribute("aria-label", label);
    box.type = "number"; box.step = "any"; box.setAttribute("aria-label", label + (unit ? ", " + unit : ""));
    const place = (value) => 1000 * (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
    const value = (at) => logarithmic ? low * Math.pow(high / low, at / 1000) : low + (high - low) * at / 1000;
    const show = () => { const now = get(); range.value = place(now); box.value = Number(now.toPrecision(4)); };
    range.addEventListener("input", () => { set(Number(value(Number(range.value)).toPrecision(4))); box.value = get(); update(); });
    box.addEventListener("change", () => { if (Number(box.value) >= 0) { set(Number(box.value)); show(); update(); } });
    cell.append(box, " " + unit);
    byId("sliders").append(name, range, cell);
    show();
  }

  function heading(text) {
    const title = document.createElement("h3");
    title.textContent = text;
    byId("sliders").append(title);
  }

  function makeSliders() {
    byId("sliders").replaceChildren();
    ATLAS.axes.forEach(function (axis) {
      const values = axis.values;
      slider(axis.label, axis.unit, values[0], values[values.length - 1], axis.log, () => state.at[axis.name], (x) => { state.at[axis.name] = x; });
    });
    ATLAS.materials.forEach(function (one) {
      heading("feed of " + one.name);
      const fed = state.feed[one.name];
      const law = () => fed.law || { d63: one.d63, n: one.n };
      slider("d63", "µm", 1e6 * one.smallest, 1e6 * one.largest, true, () => 1e6 * law().d63, (x) => { fed.law = { d63: 1e-6 * x, n: law().n }; });
      slider("n", "", 0.5, 10, true, () => law().n, (x) => { fed.law = { d63: law().d63, n: x }; });
      if (ATLAS.materials.length > 1) slider("share", "kg/kg", 0, 1, false, () => fed.share, (x) => { fed.share = x; });
    });
  }

  function element(parent, name, attributes, text) {
    const made = document.createElementNS(SVG, name);
    Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  }

  // Axes of a picture; gives the functions from values to places
  function frame(svg, height, top, label) {
    svg.replaceChildren();
    const left = 52, right = 628, low = ATLAS.bins[0], high = ATLAS.bins[ATLAS.bins.length - 1];
    const x = (y) => left + (right - left) * (y - low) / (high - low);
    const y = (value) => height - 40 - (height - 55) * value / top;
    const marks = high - low < 2.5 ? [1, 1.5, 2, 3, 4, 6, 8] : [1, 2, 3, 5];
    for (let decade = -9; decade < 1; decade += 1) marks.forEach(function (mark) {
      const at = Math.log(mark) + decade * Math.LN10;
      if (at < low || at > high) return;
      element(svg, "line", { x1: x(at), x2: x(at), y1: y(0), y2: y(top), class: "tick" });
      element(svg, "text", { x: x(at), y: y(0) + 16, "text-anchor": "middle" }, Number((mark * Math.pow(10, decade + 6)).toPrecision(3)));
    });
    const step = top <= 1 ? 0.2 : Math.pow(10, Math.floor(Math.log10(top))) / (top / Math.pow(10, Math.floor(Math.log10(top))) < 3 ? 2 : 1);
    for (let value = 0; value <= top * 1.0001; value += step) element(svg, "text", { x: left - 6, y: y(value) + 4, "text-anchor": "end" }, Number(value.toPrecision(3)));
    element(svg, "rect", { x: left, y: y(top), width: right - left, height: y(0) - y(top), class: "axis" });
    element(svg, "text", { x: (left + right) / 2, y: height - 6, "text-anchor": "middle" }, "particle diameter d (µm)");
    element(svg, "text", { x: 12, y: height / 2, transform: "rotate(-90 12 " + height / 2 + ")", "text-anchor": "middle" }, label);
    return { x: x, y: y, low: low, high: high };
  }

  const DASHES = ["", "7 3", "7 3 2 3", "2 2"];

  function drawCurves(found) {
    const svg = byId("curve"), f = frame(svg, 330, 1, "share to " + ATLAS.products[ATLAS.products.length - 1]);
    ATLAS.materials.forEach(function (one, k) {
      const own = found.materials[one.name];
      if (!own || !own.curve || !(own.share > 0)) return;
      const low = Math.log(one.smallest), high = Math.log(one.largest);
      const places = [];
      for (let i = 0; i <= 200; i += 1) places.push(low + (high - low) * i / 200);
      ATLAS.grid.forEach((x) => { const at = own.curve.cut + x; if (at > low && at < high) places.push(at); });
      places.sort((a, b) => a - b);
      const line = (which) => places.map((at) => f.x(at).toFixed(1) + "," + f.y(own.curve[which](at)).toFixed(1));
      const colour = COLOURS[k % COLOURS.length];
      element(svg, "polygon", { points: line("high").concat(line("low").reverse()).join(" "), fill: colour, "fill-opacity": 0.22 });
      element(svg, "polyline", { points: line("share").join(" "), fill: "none", stroke: colour, "stroke-width": 1.8, "stroke-dasharray": DASHES[k % 4] });
      element(svg, "line", { x1: 62, x2: 92, y1: 30 + 17 * k, y2: 30 + 17 * k, stroke: colour, "stroke-width": 2, "stroke-dasharray": DASHES[k % 4] });
      element(svg, "text", { x: 98, y: 34 + 17 * k }, one.name);
    });
  }

  function drawSizes(found) {
    const names = ["feed"].concat(Object.keys(found.sizes).filter((name) => name !== "feed"));
    const density = (name) => (found.sizes[name] || []).map((m, k) => m / ((ATLAS.bins[k + 1] - ATLAS.bins[k]) / Math.LN10));
    const top = 1.15 * Math.max(0.1, ...density("feed"));
    const svg = byId("sizes"), f = frame(svg, 250, top, "mass per decade");
    names.forEach(function (name, k) {
      const values = density(name), colour = name === "feed" ? "#888" : COLOURS[(k - 1) % COLOURS.length];
      const points = [f.x(f.low) + "," + f.y(0)];
      values.forEach((value, j) => points.push(f.x(ATLAS.bins[j]).toFixed(1) + "," + f.y(value).toFixed(1), f.x(ATLAS.bins[j + 1]).toFixed(1) + "," + f.y(value).toFixed(1)));
      points.push(f.x(f.high) + "," + f.y(0));
      element(svg, "polyline", { points: points.join(" "), fill: colour, "fill-opacity": name === "feed" ? 0.15 : 0.3, stroke: colour, "stroke-width": 1.2, "stroke-dasharray": k ? DASHES[k - 1] : "" });
      element(svg, "rect", { x: 62, y: 22 + 17 * k, width: 26, height: 10, fill: colour, "fill-opacity": 0.3, stroke: colour, "stroke-dasharray": k ? DASHES[k - 1] : "" });
      element(svg, "text", { x: 96, y: 31 + 17 * k }, name);
    });
  }

  function table(id, heads, rows) {
    const head = document.createElement("tr");
    heads.forEach(function ([name, unit], k) {
      const cell = document.createElement("th"), small = document.createElement("small");
      cell.textContent = name; small.textContent = unit; cell.append(small);
      if (!unit && k < 2) cell.className = "word";
      head.append(cell);
    });
    const made = rows.map(function (row) {
      const line = document.createElement("tr");
      row.forEach(function (text, k) {
        const cell = document.createElement("td");
        cell.textContent = text;
        if (!heads[k][1] && k < 2) cell.className = "word";
        line.append(cell);
      });
      return line;
    });
    byId(id).replaceChildren(head, ...made);
  }

  function writeTables(found) {
    const known = ATLAS.materials.filter((one) => found.materials[one.name] && found.materials[one.name].curve && found.materials[one.name].share > 0);
    table("cuts", [["material", ""], ["d50", "µm"], ["95 %", "µm"], ["d25", "µm"], ["d75", "µm"], ["d25/d75", "-"]], known.map(function (one) {
      const own = found.materials[one.name];
      return [one.name, um(own.d50), um(own.d50_low) + " .. " + um(own.d50_high), um(own.d25), um(own.d75), own.d25 && own.d75 ? (own.d25 / own.d75).toFixed(3) : "-"];
    }));
    const range = (limits) => limits ? percent(limits.low) + " .. " + percent(limits.high) : "-";
    const value = (limits) => limits ? percent(limits.value) : "-";
    table("products", [["product", ""], ["material", ""], ["yield", "%"], ["band", "%"], ["recovery", "%"], ["band", "%"], ["grade", "%"], ["band", "%"], ["d10", "µm"], ["d50", "µm"], ["d90", "µm"]],
      found.products.map((row) => [row.product, row.material, value(row.yield), range(row.yield), value(row.recovery), range(row.recovery), value(row.grade), range(row.grade), um(row.d10), um(row.d50), um(row.d90)]));
  }

  function writeBehind(found) {
    const lines = [];
    found.runs.forEach((one) => lines.push((100 * one.weight).toFixed(0) + " %: " + one.runs.join(", ")));
    ATLAS.materials.forEach(function (one) {
      const own = found.materials[one.name];
      if (own && own.share > 0) lines.push(one.name + ": this feed is known as from " + own.parcels.toFixed(0) + " parcels of equal weight" + (own.off > 0 ? "; interpolation moves d50 by up to " + (100 * own.off).toFixed(1) + " %" : ""));
    });
    if (isFinite(found.sparse)) lines.push("Particles begin to feel each other above a loading of " + found.sparse.toPrecision(2) + " kg/kg; these runs have " + found.loading.toPrecision(2) + ". Other feeds are answered as if they did not.");
    byId("behind").replaceChildren(...lines.map(function (text) { const item = document.createElement("li"); item.textContent = text; return item; }));
    const other = ATLAS.materials.some((one) => state.feed[one.name].law || state.feed[one.name].share !== one.share);
    const words = found.beyond.slice();
    const dense = other && found.loading > found.sparse;
    if (dense) words.push("at this loading particles feel each other, and another feed may change the curves");
    byId("state").textContent = words.length ? "Not answered by the runs: " + words.join("; ") + "." : "Within the runs" + (other ? "; another feed than was run." : ".");
    document.body.classList.toggle("beyond", words.length > 0);
  }

  function update() {
    const start = performance.now();
    const found = answer(state);
    drawCurves(found);
    drawSizes(found.sizes ? found : Object.assign(found, { sizes: {} }));
    writeTables(found);
    writeBehind(found);
    const shown = { state: state, beyond: found.beyond, runs: found.runs, products: found.products, materials: {} };
    Object.entries(found.materials).forEach(([name, own]) => { shown.materials[name] = Object.assign({}, own, { curve: undefined }); });
    byId("data").textContent = JSON.stringify(shown, null, 1);
    document.body.dataset.ms = (performance.now() - start).toFixed(1);
    toAddress();
  }

  byId("reset").addEventListener("click", function () { state = asRun(); makeSliders(); update(); });
  window.addEventListener("hashchange", function () { state = asRun(); fromAddress(); makeSliders(); update(); });
  fromAddress();
  makeSliders();
  update();
})();
