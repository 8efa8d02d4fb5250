// The page of `elutria view`: frames from the server to the picture, wishes back.

import { Column } from "./column.js";
import { Curve } from "./curve.js";
import { decode } from "./frame.js";
import { Panel, showRuns, showState } from "./panel.js";
import { open } from "./source.js";

const page = { frames: 0, statistics: null, state: null };
window.elutria = page;      // what tests ask

const pastFrames = [];      // [time of the run, time here] of the last second or two

function paceOf(frame) {
  const now = performance.now() / 1000;
  const last = pastFrames.at(-1);
  if (last && (frame.time < last[0] || now - last[1] > 1)) pastFrames.length = 0;   // a jump, a pause
  pastFrames.push([frame.time, now]);
  while (pastFrames.length > 2 && now - pastFrames[0][1] > 2) pastFrames.shift();
  const [time, since] = pastFrames[0];
  const passed = Math.max(now - since, 1e-3);
  return pastFrames.length > 1 ? [(frame.time - time) / passed, (pastFrames.length - 1) / passed] : [NaN, 0];
}

// A run, the first or another one: all that is known of one before is forgotten
function start(message) {
  if (!page.column) {
    page.column = new Column(document.getElementById("column"));
    page.curve = new Curve(document.getElementById("curve"));
    page.panel = new Panel(page.column, (wish) => page.stream.send(wish));
  }
  page.column.stand(message.scene, message.walls);
  page.panel.start(message);
  const several = message.scene.materials.length > 1;
  page.curve.label = `share to ${message.scene.partition_to ?? message.scene.products.at(-1)}${several ? ", of all" : ""}`;
  page.curve.show({ curve: [], classes: [] });
  page.statistics = page.frame = null;
  page.frames = pastFrames.length = 0;
}

page.stream = open({
  scene: start,
  frame(buffer) {
    const frame = decode(buffer);
    page.frame = frame;
    ++page.frames;
    page.column.show(frame);
    page.panel.numbers(frame, ...paceOf(frame));
  },
  fates(fates) {
    page.column.particles.fates = fates;
  },
  statistics(message) {
    page.statistics = message;
    page.curve.show(message);
    page.panel.statistics(message);
  },
  control(message) {
    page.panel.follow(message.control);
  },
  state(message) {
    page.state = message.state;
    showState(message);
  },
  runs({ runs, chosen }) {
    showRuns(runs, chosen, (name) => page.stream.send({ run: name }));
  },
  gone() {
    page.state = "gone";
    showState({ state: "gone", text: "elutria view has ended" });
  },
});
