// The gas' speed on a plane through the column.

import { BufferGeometry, BufferAttribute, DataTexture, DoubleSide, Mesh, MeshBasicMaterial, NearestFilter, SRGBColorSpace, Vector3 } from "three";
import { viridis } from "./colours.js";

const NOWHERE = 65535;

export class Slice {
  constructor(scene) {
    const [corner, across, along] = ["corner_m", "across_m", "along_m"].map((name) => new Vector3(...scene.slice[name]));
    const [width, height] = scene.slice.points;
    this.fastest = 1;
    this.texture = new DataTexture(new Uint8Array(4 * width * height), width, height);
    this.texture.magFilter = NearestFilter;
    this.texture.colorSpace = SRGBColorSpace;
    const corners = [corner, corner.clone().add(across), corner.clone().add(across).add(along), corner.clone().add(along)];
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(corners.flatMap((c) => c.toArray())), 3));
    geometry.setAttribute("uv", new BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.mesh = new Mesh(geometry, new MeshBasicMaterial({
      map: this.texture, transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false,
    }));
  }

  show(samples) {
    if (!samples.length) return;
    for (const speed of samples) {
      if (speed !== NOWHERE) this.fastest = Math.max(this.fastest, speed);
    }
    const pixels = this.texture.image.data;
    samples.forEach((speed, k) => {
      const colour = viridis(speed / this.fastest);
      for (let i = 0; i < 3; ++i) pixels[4 * k + i] = 255 * colour[i];
      pixels[4 * k + 3] = speed === NOWHERE ? 0 : 255;
    });
    this.texture.needsUpdate = true;
  }
}
