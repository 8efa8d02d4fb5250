// From a state (settings, feed) to an answer. Knows no page: see atlas_page.js.
"use strict";
const ATLAS = JSON.parse(document.getElementById("atlas").textContent);
const CUT_OFF = 0.1; // share of a law beyond the sizes that were run, more than of the case's own, above which it is beyond
const GROUP = 8; // bins in which parcels are counted

const expit = (x) => 1 / (1 + Math.exp(-x));

// Linear between points; beyond the ends their values
function interpolate(x, xs, ys) {
  const last = xs.length - 1;
  if (x <= xs[0]) return ys[0];
  if (x >= xs[last]) return ys[last];
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle; else high = middle;
  }
  const share = (x - xs[low]) / (xs[high] - xs[low]);
  return ys[low] + share * (ys[high] - ys[low]);
}

// The nodes around a point, each with its weight; and what a second derivative of 1 is off by, by axis
function surrounding(at) {
  let corners = [{ at: {}, weight: 1 }];
  const off = [];
  let inside = true;
  ATLAS.axes.forEach(function (axis) {
    const scale = axis.log ? Math.log : (x) => x;
    const values = axis.values, value = at[axis.name];
    if (!(value >= values[0] * (1 - 1e-9) && value <= values[values.length - 1] * (1 + 1e-9))) inside = false;
    let k = 0;
    while (k < values.length - 2 && value > values[k + 1]) k += 1;
    const low = values[k], high = values[Math.min(k + 1, values.length - 1)];
    const width = scale(high) - scale(low);
    let share = width > 0 ? (scale(value) - scale(low)) / width : 0;
    share = Math.min(Math.max(share, 0), 1);
    off.push(width * width * share * (1 - share));
    const next = [];
    corners.forEach(function (corner) {
      [[low, 1 - share], [high, share]].forEach(function ([end, weight]) {
        if (weight > 1e-12) next.push({ at: Object.assign({}, corner.at, { [axis.place]: end }), weight: corner.weight * weight });
      });
    });
    corners = next;
  });
  const nodes = corners.map(function (corner) {
    const node = ATLAS.nodes.find((one) => Object.keys(corner.at).every((place) => one.at[place] === corner.at[place]));
    return { node: node, weight: corner.weight };
  });
  return { nodes: nodes, off: off, inside: inside, complete: nodes.every((one) => one.node) };
}

// The curve of a material at a point: T and its limits at ln d
function curveAt(name, around, velocity) {
  const parts = around.nodes.map((one) => ({ curve: one.node.curves[name], node: one.node, weight: one.weight }));
  if (parts.some((one) => one.curve.cut === null)) return null;
  const mean = (of) => parts.reduce((sum, one) => sum + one.weight * of(one), 0);
  let cut = mean((one) => one.curve.cut);
  if (ATLAS.theory) cut += interpolate(Math.log(velocity), ATLAS.theory[name][0], ATLAS.theory[name][1]);
  const off = around.off.reduce((sum, size, axis) => sum + size * Math.max(...parts.map((one) => one.node.curvature[name][axis])), 0);
  const line = (which) => ATLAS.grid.map((_, k) => mean((one) => one.curve[which][k]));
  const lines = { t: line("t"), low: line("low"), high: line("high") };
  const value = (which, x) => expit(interpolate(x, ATLAS.grid, lines[which]));
  return {
    cut: cut,
    off: off,
    share: (y) => value("t", y - cut),
    low: (y) => value("low", y - cut - off),
    high: (y) => value("high", y - cut + off)
  };
}

// ln d at which a rising function of ln d crosses a level; null where it does not
function crossing(share, level, low, high) {
  if (share(low) > level || share(high) < level) return null;
  for (let k = 0; k < 60; k += 1) {
    const middle = (low + high) / 2;
    if (share(middle) < level) low = middle; else high = middle;
  }
  return (low + high) / 2;
}

// Shares of a material's mass by size bin: as it was run, or Rosin-Rammler within the sizes that were run
function feedShares(material, law) {
  if (!law) return material.fed;
  const ends = ATLAS.bins.map((y) => Math.min(Math.max(Math.exp(y), material.smallest), material.largest));
  const below = ends.map((d) => -Math.expm1(-Math.pow(d / law.d63, law.n)));
  const whole = below[below.length - 1] - below[0];
  return below.slice(1).map((b, k) => (b - below[k]) / whole);
}

// Share of a law that lies beyond the sizes that were run
function cutOff(material, law) {
  const below = (d) => -Math.expm1(-Math.pow(d / law.d63, law.n));
  return below(material.smallest) + 1 - below(material.largest);
}

// How many parcels of equal weight tell as much of a feed as those that were run (Kish)
function evidence(shares, around, name) {
  let squares = 0;
  for (let first = 0; first < shares.length; first += GROUP) {
    const sum = (values) => values.slice(first, first + GROUP).reduce((a, b) => a + b, 0);
    const parcels = around.nodes.reduce((all, one) => all + one.weight * sum(one.node.curves[name].parcels), 0);
    const share = sum(shares);
    squares += share * share / Math.max(parcels, 0.5);
  }
  return squares > 0 ? 1 / squares : 0;
}

function quantile(masses, level) {
  const total = masses.reduce((sum, mass) => sum + mass, 0);
  if (!(total > 0)) return null;
  let below = 0;
  for (let k = 0; k < masses.length; k += 1) {
    if (below + masses[k] >= level * total) {
      const share = masses[k] > 0 ? (level * total - below) / masses[k] : 0;
      return Math.exp(ATLAS.bins[k] + share * (ATLAS.bins[k + 1] - ATLAS.bins[k]));
    }
    below += masses[k];
  }
  return Math.exp(ATLAS.bins[ATLAS.bins.length - 1]);
}

// state: { at: {axis: value}, feed: {material: {share, law: null | {d63, n}}} }
function answer(state) {
  const around = surrounding(state.at);
  const reasons = [];
  if (!around.inside) reasons.push("the settings lie beyond those that were run");
  if (!around.complete) reasons.push("a setting beside this point was not run");
  const velocityAxis = ATLAS.axes.find((axis) => axis.name === "gas_velocity_m_s");
  if (!around.complete) return { beyond: reasons, runs: [], materials: {}, products: [] };
  const velocity = velocityAxis ? state.at[velocityAxis.name] : around.nodes[0].node.at[0];
  const middle = ATLAS.bins.slice(1).map((y, k) => (y + ATLAS.bins[k]) / 2);
  const total = ATLAS.materials.reduce((sum, one) => sum + state.feed[one.name].share, 0);
  const found = { runs: [], materials: {}, products: [], bins: ATLAS.bins, sizes: {} };
  around.nodes.forEach((one) => found.runs.push({ runs: one.node.runs, weight: one.weight }));
  const split = [];
  ATLAS.materials.forEach(function (material) {
    const fed = state.feed[material.name];
    const share = total > 0 ? fed.share / total : 0;
    const curve = curveAt(material.name, around, velocity);
    const shares = feedShares(material, fed.law);
    const cut = fed.law ? cutOff(material, fed.law) - cutOff(material, material) : 0;
    const own = { share: share, parcels: evidence(shares, around, material.name), cut_off: cut };
    found.materials[material.name] = own;
    if (share > 0 && curve === null) reasons.push(material.name + ": a run beside this point has no cut size");
    if (share > 0 && cut > CUT_OFF) reasons.push(material.name + ": " + (100 * cut).toFixed(0) + " % of this feed lie beyond the sizes that were run");
    if (curve === null) return;
    const ends = [ATLAS.bins[0], ATLAS.bins[ATLAS.bins.length - 1]];
    const size = (which, level) => { const y = crossing(curve[which], level, ends[0], ends[1]); return y === null ? null : Math.exp(y); };
    Object.assign(own, {
      curve: curve, off: curve.off,
      d25: size("share", 0.25), d50: size("share", 0.5), d75: size("share", 0.75),
      d50_low: size("high", 0.5), d50_high: size("low", 0.5)
    });
    const mass = shares.map((s) => s * share);
    const coarse = ["share", "low", "high"].map((which) => mass.map((m, k) => m * curve[which](middle[k])));
    split.push({ name: material.name, mass: mass, coarse: coarse });
  });
  found.beyond = reasons;
  found.sparse = Math.min(...around.nodes.map((one) => one.node.sparse === null ? Infinity : one.node.sparse));
  found.loading = Math.max(...around.nodes.map((one) => one.node.loading === null ? 0 : one.node.loading));
  addProducts(found, split);
  return found;
}

// Share of a mass beside that of the others; its band: all of one at one end, all others at the other
function grade(own, others) {
  const share = (m, rest) => m + rest > 0 ? m / (m + rest) : 0;
  return {
    value: share(own[0], others[0]),
    low: share(Math.min(...own), Math.max(...others)),
    high: share(Math.max(...own), Math.min(...others))
  };
}

// Yield, recovery, grade and sizes of the last product, of which T is the share, and of the others together
function addProducts(found, split) {
  const names = ATLAS.products, last = names[names.length - 1];
  const sum = (values) => values.reduce((a, b) => a + b, 0);
  [[names.slice(0, -1).join(" + "), false], [last, true]].forEach(function ([product, isCoarse]) {
    const of = (one, which) => isCoarse ? one.coarse[which] : one.mass.map((m, k) => m - one.coarse[which][k]);
    const whole = [0, 1, 2].map((which) => sum(split.map((one) => sum(of(one, which)))));
    const limits = (values) => ({ value: values[0], low: Math.min(...values), high: Math.max(...values) });
    const all = split.length ? split[0].mass.map((_, k) => sum(split.map((one) => of(one, 0)[k]))) : [];
    found.sizes[product] = all;
    const rows = split.map((one) => ({ name: one.name, own: [0, 1, 2].map((which) => sum(of(one, which))), fed: sum(one.mass), masses: of(one, 0) }));
    if (split.length > 1) rows.push({ name: "all", own: whole, fed: sum(split.map((one) => sum(one.mass))), masses: all });
    rows.forEach(function (row) {
      found.products.push({
        product: product, material: row.name,
        yield: limits(row.own),
        recovery: row.fed > 0 ? limits(row.own.map((m) => m / row.fed)) : null,
        grade: whole[0] > 0 ? grade(row.own, whole.map((m, k) => m - row.own[k])) : null,
        d10: quantile(row.masses, 0.1), d50: quantile(row.masses, 0.5), d90: quantile(row.masses, 0.9)
      });
    });
  });
  found.sizes.feed = split.length ? split[0].mass.map((_, k) => sum(split.map((one) => one.mass[k]))) : [];
}
