// Where frames come from: the server's stream, or a recording that lies in the page itself.

import { decode } from "./frame.js";

class Stream {
  constructor(handlers) {
    this.handlers = handlers;
    this.socket = new WebSocket(new URL("stream", location.href.replace(/^http/, "ws")));
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => this.receive(data);
    this.socket.onclose = () => handlers.gone();
  }

  receive(data) {
    if (typeof data === "string") {
      const message = JSON.parse(data);
      this.handlers[message.kind]?.(message);
    } else if (new DataView(data).getUint32(0, true) === 0xffffffff) {
      this.handlers.fates(new Uint8Array(data, 4));
    } else {
      this.handlers.frame(data);
    }
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}

const bytesOf = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

class Recording {
  constructor(handlers, data) {
    this.handlers = handlers;
    this.data = data;
    this.control = data.scene.control;
    this.shown = this.told = -1;
    this.start();
  }

  async start() {
    const content = await inflated(bytesOf(this.data.frames));
    const view = new DataView(content);
    this.frames = [];
    for (let at = 0; at < content.byteLength; at += view.getUint32(at, true)) {
      this.frames.push(content.slice(at, at + view.getUint32(at, true)));
    }
    this.times = this.frames.map((frame) => decode(frame).time);
    this.time = this.times[0];
    this.handlers.scene(this.data.scene);
    this.handlers.fates(bytesOf(this.data.fates));
    this.handlers.state({ state: "running", text: "recorded" });
    this.last = performance.now();
    setInterval(() => this.step(), 30);
  }

  step() {
    const now = performance.now();
    if (!this.control.pause) this.time += ((now - this.last) / 1000) * (this.control.speed || 10);
    this.last = now;
    this.time = Math.min(this.time, this.times.at(-1));
    const after = (times, time) => {
      const k = times.findIndex((t) => t > time);
      return Math.max((k < 0 ? times.length : k) - 1, 0);
    };
    const number = after(this.times, this.time);
    if (number !== this.shown) this.handlers.frame(this.frames[number]);
    this.shown = number;
    const told = after(this.data.statistics.map((entry) => entry.time), this.time);
    if (told !== this.told) this.handlers.statistics(this.data.statistics[told]);
    this.told = told;
  }

  send(message) {
    if (message.control) this.control = message.control;
    if (message.seek !== undefined) this.time = message.seek;
  }
}

export function open(handlers) {
  const data = document.getElementById("recording");
  document.body.classList.toggle("standalone", Boolean(data));    // nobody fits a new curve there
  return data ? new Recording(handlers, JSON.parse(data.textContent)) : new Stream(handlers);
}
