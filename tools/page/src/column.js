// The column in three dimensions: walls, particles, gas, and the camera around them.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Particles, COLOURINGS } from "./particles.js";
import { Slice } from "./slice.js";

function positions(numbers) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(numbers), 3));
  return geometry;
}

// Without a GPU smooth edges cost more than all parcels
function drawnInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Column {
  constructor(canvas) {
    this.canvas = canvas;
    const software = drawnInSoftware();
    // opaque, so that the browser need not blend it with what is behind it
    const context = canvas.getContext("webgl2", { alpha: false, antialias: !software, stencil: false });
    this.renderer = new WebGLRenderer({ canvas, context });
    this.finest = software ? 1 : 2;
    this.drawn = 0;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.renderer.setAnimationLoop(() => this.draw());
  }

  // Another column in place of the one before; one in the same box is seen from the same place
  stand(scene, walls) {
    this.scene?.traverse(({ geometry, material }) => {
      for (const part of [geometry, material?.map, material]) part?.dispose();
    });
    this.scene = new Scene();
    this.scene.background = new Color("#14171b");
    this.particles = new Particles(scene);
    this.slice = new Slice(scene);
    const solid = new Mesh(positions(walls.triangles), new MeshBasicMaterial({
      color: "#8090a0", transparent: true, opacity: 0.08, side: DoubleSide, depthWrite: false,
    }));
    const lines = new LineSegments(positions(walls.lines), new LineBasicMaterial({ color: "#7d8894" }));
    this.scene.add(lines, this.particles.points, this.slice.mesh, solid);
    const box = JSON.stringify([scene.box_m, scene.up]);
    if (box !== this.box) this.look(scene);
    this.box = box;
    this.resize();
  }

  // To where the whole column is in sight, a little from the side, gravity downwards
  look(scene) {
    const { low, span } = this.particles;
    const up = new Vector3(...scene.up);
    const middle = low.clone().addScaledVector(span, 0.5);
    const size = span.length();
    this.camera = new PerspectiveCamera(35, 1, 0.01 * size, 10 * size);
    this.camera.up.copy(up);
    const aside = Math.abs(up.x) > 0.9 ? new Vector3(0, 1, 0) : new Vector3(1, 0, 0);
    const front = new Vector3().crossVectors(aside, up).normalize();
    this.camera.position.copy(middle).addScaledVector(front, 1.62 * size)
      .addScaledVector(aside, 0.55 * size).addScaledVector(up, 0.12 * size);
    this.controls?.dispose();
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.copy(middle);
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.controls.update();
  }

  resize() {
    if (!this.camera) return;
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, this.finest));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    this.particles.material.uniforms.pixels.value = (this.canvas.height / 2) / half;
    this.stale = true;
  }

  show(frame) {
    this.particles.show(frame);
    this.slice.show(frame.samples);
    this.stale = true;
  }

  colourBy(name) {
    this.particles.material.uniforms.colouring.value = COLOURINGS.indexOf(name);
    this.stale = true;
  }

  showGas(visible) {
    this.slice.mesh.visible = visible;
    this.stale = true;
  }

  enlarge(factor) {
    this.particles.material.uniforms.scale.value = factor;
    this.stale = true;
  }

  draw() {
    if (!this.stale) return;
    this.stale = false;
    this.renderer.render(this.scene, this.camera);
    ++this.drawn;
  }

  // Pixel of the canvas at which a parcel is drawn, from its upper left corner; null if it is not there
  pixelOf(id) {
    const k = this.particles.find(id);
    if (k < 0) return null;
    const seen = this.particles.place(k).project(this.camera);
    return [((seen.x + 1) / 2) * this.canvas.width, ((1 - seen.y) / 2) * this.canvas.height];
  }
}
