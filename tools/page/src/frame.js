// A frame as docs/user/outputs.md describes it, taken apart without copying.

const HEAD = 64, PARTICLE = 16, DEPARTURE = 24;

export function decode(buffer) {
  const view = new DataView(buffer);
  const number = (at) => view.getUint32(at, true);
  const [particles, departures, samples] = [number(4), number(8), number(12)];
  const samplesFrom = HEAD + PARTICLE * particles + DEPARTURE * departures;
  return {
    time: view.getFloat64(16, true),
    wall: view.getFloat64(24, true),
    inside: view.getFloat64(32, true),
    gas: view.getFloat32(40, true),
    loading: view.getFloat32(44, true),
    fed: number(48),
    lost: number(52),
    count: particles,
    // x y z, diameter, rise, material, low and high half of the number
    records: new Uint16Array(buffer, HEAD, (PARTICLE / 2) * particles),
    samples: new Uint16Array(buffer, samplesFrom, samples),
  };
}

export function idOf(records, k) {
  return records[8 * k + 6] + 65536 * records[8 * k + 7];
}
