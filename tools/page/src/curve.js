// The partition curve: share to a product against size, with its band, over points of the size classes.

const ROOM = { left: 52, right: 12, top: 12, bottom: 34 };

// Round sizes, as many as there is room for
function ticks(low, high) {
  const among = (digits) => {
    const found = [];
    for (let decade = Math.floor(Math.log10(low)); decade <= Math.log10(high); ++decade) {
      found.push(...digits.map((digit) => digit * 10 ** decade));
    }
    return found.filter((size) => size >= low && size <= high);
  };
  const few = among([1, 2, 5]);
  return few.length > 3 ? few : among([1, 1.5, 2, 3, 4, 5, 7]);
}

export class Curve {
  constructor(canvas) {
    this.canvas = canvas;
    this.label = "";
    this.data = { curve: [], classes: [] };
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  show(data) {
    this.data = data;
    this.draw();
  }

  draw() {
    const ratio = Math.min(window.devicePixelRatio, 2);
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "11px system-ui, sans-serif";
    const sizes = [...this.data.curve, ...this.data.classes].map((row) => row[0]);
    const [low, high] = sizes.length ? [Math.min(...sizes), Math.max(...sizes) * 1.0001] : [1e-4, 1e-3];
    const x = (size) => ROOM.left + (Math.log(size / low) / Math.log(high / low)) * (width - ROOM.left - ROOM.right);
    const y = (share) => height - ROOM.bottom - share * (height - ROOM.top - ROOM.bottom);
    this.axes(pen, width, height, x, y, low, high);
    this.band(pen, x, y);
    this.points(pen, x, y);
  }

  axes(pen, width, height, x, y, low, high) {
    pen.strokeStyle = "#3a4148";
    pen.fillStyle = "#aeb6be";
    pen.lineWidth = 1;
    pen.textBaseline = "middle";
    pen.textAlign = "right";
    for (const share of [0, 0.25, 0.5, 0.75, 1]) {
      pen.beginPath();
      pen.moveTo(ROOM.left, y(share));
      pen.lineTo(width - ROOM.right, y(share));
      pen.stroke();
      pen.fillText(String(share), ROOM.left - 6, y(share));
    }
    pen.textAlign = "center";
    for (const size of ticks(low, high)) {
      pen.fillText(String(Math.round(size * 1e7) / 10), x(size), height - ROOM.bottom + 10);
    }
    pen.fillText("size, µm", (width + ROOM.left) / 2, height - 8);
    pen.save();
    pen.translate(9, y(0.5));
    pen.rotate(-Math.PI / 2);
    pen.fillText(this.label, 0, 0);
    pen.restore();
  }

  band(pen, x, y) {
    const rows = this.data.curve;
    if (!rows.length) return;
    pen.fillStyle = "rgba(86, 180, 233, 0.28)";
    pen.beginPath();
    rows.forEach(([size, , lower], k) => pen[k ? "lineTo" : "moveTo"](x(size), y(lower)));
    [...rows].reverse().forEach(([size, , , upper]) => pen.lineTo(x(size), y(upper)));
    pen.fill();
    pen.strokeStyle = "#56b4e9";
    pen.lineWidth = 2;
    pen.beginPath();
    rows.forEach(([size, share], k) => pen[k ? "lineTo" : "moveTo"](x(size), y(share)));
    pen.stroke();
  }

  points(pen, x, y) {
    pen.fillStyle = pen.strokeStyle = "#e8eaed";
    pen.lineWidth = 1;
    for (const [size, share, lower, upper] of this.data.classes) {
      pen.beginPath();
      pen.moveTo(x(size), y(lower));
      pen.lineTo(x(size), y(upper));
      pen.stroke();
      pen.beginPath();
      pen.arc(x(size), y(share), 2.5, 0, 7);
      pen.fill();
    }
  }
}
