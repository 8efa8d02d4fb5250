// All parcels as one draw call: a frame's records go to the GPU as they are. Each is a disc shaded as
// a sphere, as large as its true diameter looks from where one stands.

import {
  BufferGeometry, Color, DynamicDrawUsage, InterleavedBuffer, InterleavedBufferAttribute,
  BufferAttribute, Points, ShaderMaterial, Sphere, Vector3,
} from "three";
import { idOf } from "./frame.js";
import { INSIDE, MATERIALS, PRODUCTS, VIRIDIS_RGB } from "./colours.js";

export const COLOURINGS = ["material", "size", "velocity", "fate"];

const vertexShader = `
  attribute float size;       // of the largest
  attribute float rise;       // m/s + 32.768, over 65.535
  attribute float kind;
  attribute float fate;       // 0: inside, then the products
  uniform vec3 low, span;
  uniform float largest, pixels, scale, rises;
  uniform float smallest;
  uniform int colouring;
  uniform vec3 materials[8], fates[8], steps[9];
  varying vec3 shade;

  vec3 along(float share) {
    float place = clamp(share, 0.0, 1.0)*8.0;
    int k = int(min(place, 7.0));
    return mix(steps[k], steps[k + 1], place - float(k));
  }

  void main() {
    vec4 seen = modelViewMatrix*vec4(low + position*span, 1.0);
    gl_Position = projectionMatrix*seen;
    gl_PointSize = max(size*largest*scale*pixels/-seen.z, 1.5);
    if (colouring == 0) shade = materials[int(min(kind, 7.0) + 0.5)];
    else if (colouring == 1) shade = along((size - smallest)/(1.0 - smallest));
    else if (colouring == 2) shade = along(0.5 + 0.5*(rise*65.535 - 32.768)/rises);
    else shade = fates[int(min(fate, 7.0) + 0.5)];
  }
`;

const fragmentShader = `
  varying vec3 shade;
  void main() {
    vec2 p = 2.0*gl_PointCoord - 1.0;
    float r2 = dot(p, p);
    if (r2 > 1.0) discard;
    float light = 0.45 + 0.55*max(0.0, dot(vec3(p.x, -p.y, sqrt(1.0 - r2)), vec3(0.36, 0.48, 0.8)));
    gl_FragColor = vec4(shade*light, 1.0);
  }
`;

const palette = (colours) =>
  Array.from({ length: 8 }, (_, k) => new Vector3(...new Color(colours[k % colours.length]).convertLinearToSRGB().toArray()));

export class Particles {
  constructor(scene) {
    const [low, high] = scene.box_m;
    this.low = new Vector3(...low);
    this.span = new Vector3(...high).sub(this.low);
    this.fates = new Uint8Array(0);
    this.room = 0;
    this.material = new ShaderMaterial({
      vertexShader,
      fragmentShader,
      uniforms: {
        low: { value: this.low }, span: { value: this.span },
        largest: { value: scene.largest_diameter_m },
        pixels: { value: 1 }, scale: { value: 1 }, rises: { value: 5 }, smallest: { value: 0 },
        colouring: { value: 0 },
        materials: { value: palette(MATERIALS) },
        fates: { value: palette([INSIDE, ...PRODUCTS]) },
        steps: { value: VIRIDIS_RGB.map((c) => new Vector3(...c)) },
      },
    });
    this.points = new Points(new BufferGeometry(), this.material);
    this.points.frustumCulled = false;
    this.grow(1024);
  }

  // Buffers are kept: a frame of more parcels than ever gets larger ones
  grow(count) {
    this.room = Math.max(2 * this.room, count);
    this.points.geometry.dispose();
    const geometry = new BufferGeometry();
    geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    this.records = new InterleavedBuffer(new Uint16Array(8 * this.room), 8).setUsage(DynamicDrawUsage);
    this.fate = new BufferAttribute(new Uint8Array(this.room), 1).setUsage(DynamicDrawUsage);
    const part = (items, offset, normalised) =>
      new InterleavedBufferAttribute(this.records, items, offset, normalised);
    geometry.setAttribute("position", part(3, 0, true));
    geometry.setAttribute("size", part(1, 3, true));
    geometry.setAttribute("rise", part(1, 4, true));
    geometry.setAttribute("kind", part(1, 5, false));
    geometry.setAttribute("fate", this.fate);
    this.points.geometry = geometry;
  }

  show(frame) {
    if (frame.count > this.room) this.grow(frame.count);
    this.frame = frame;
    this.records.array.set(frame.records);
    this.records.clearUpdateRanges();
    this.records.addUpdateRange(0, frame.records.length);
    this.records.needsUpdate = true;
    for (let k = 0; k < frame.count; ++k) {
      this.fate.array[k] = this.fates[idOf(frame.records, k)] || 0;
    }
    this.fate.needsUpdate = true;
    this.points.geometry.setDrawRange(0, frame.count);
    this.fitScales(frame);
  }

  // Colour scales only widen: a colour keeps its meaning
  fitScales(frame) {
    if (this.material.uniforms.smallest.value === 0 && frame.count > 50) {
      let smallest = 65535;
      for (let k = 0; k < frame.count; ++k) smallest = Math.min(smallest, frame.records[8 * k + 3]);
      this.material.uniforms.smallest.value = Math.min(smallest / 65535, 0.9);
    }
  }

  place(k) {
    const share = [0, 1, 2].map((i) => this.frame.records[8 * k + i] / 65535);
    return new Vector3(...share).multiply(this.span).add(this.low);
  }

  find(id) {
    for (let k = 0; k < this.frame.count; ++k) {
      if (idOf(this.frame.records, k) === id) return k;
    }
    return -1;
  }
}
