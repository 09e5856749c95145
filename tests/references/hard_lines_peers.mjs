// Let the routines of npm packages answer the rays of hard_lines_peers.py: see there.
//
//     npm install @dimforge/rapier3d-compat jolt-physics three
//     node hard_lines_peers.mjs FOLDER

import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import Rapier from "@dimforge/rapier3d-compat";
import initJolt from "jolt-physics";
import * as THREE from "three";

const folder = process.argv[2];
const rays = JSON.parse(readFileSync(join(folder, "rays.json")));

const add = (a, b) => a.map((x, i) => x + b[i]);
const scale = (a, k) => a.map((x) => x * k);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const xyz = ([x, y, z]) => ({ x, y, z });

// Centre, unit axes and half lengths of a shape; its axis is the second, along y.
function pose(ray) {
  const s = ray.shape;
  if (ray.kind === "box") {
    const edges = [s.slice(3, 6), s.slice(6, 9), s.slice(9, 12)];
    const half = edges.map((e) => length(e) / 2);
    const axes = edges.map((e) => scale(e, 1 / length(e)));
    if (dot(cross(axes[0], axes[1]), axes[2]) < 0) axes[0] = scale(axes[0], -1);
    const sum = add(add(edges[0], edges[1]), edges[2]);
    return { centre: add(s.slice(0, 3), scale(sum, 0.5)), axes, half };
  }
  const a = s.slice(0, 3), b = s.slice(3, 6), v = add(b, scale(a, -1));
  const tall = length(v);
  let y = scale(v, 1 / tall);
  if (ray.kind === "frustum" && s[7] > s[6]) y = scale(y, -1); // the narrow end is on top
  const least = y.map(Math.abs).indexOf(Math.min(...y.map(Math.abs)));
  let x = cross(y, [0, 1, 2].map((i) => (i === least ? 1 : 0)));
  x = scale(x, 1 / length(x));
  return { centre: scale(add(a, b), 0.5), axes: [x, y, cross(x, y)], half: [tall / 2] };
}

function quaternion(axes) {
  const m = new THREE.Matrix4().makeBasis(...axes.map((a) => new THREE.Vector3(...a)));
  const q = new THREE.Quaternion().setFromRotationMatrix(m);
  return { x: q.x, y: q.y, z: q.z, w: q.w };
}

function keep(routine, name, answers) {
  const { version } = JSON.parse(readFileSync(new URL(`node_modules/${name}/package.json`, import.meta.url)));
  writeFileSync(join(folder, `${routine.replace(" ", "_")}.json`), JSON.stringify({ routine, version, answers }));
  console.log(routine, answers.filter((x) => typeof x === "number").length);
}

function withRapier(ray) {
  const { centre, axes, half } = pose(ray);
  const [wide, other] = [Math.max(ray.shape[6], ray.shape[7]), Math.min(ray.shape[6], ray.shape[7])];
  let shape;
  if (ray.kind === "box") shape = new Rapier.Cuboid(...half);
  else if (ray.kind === "rod") shape = new Rapier.Cylinder(half[0], wide);
  else if (ray.kind === "capsule") shape = new Rapier.Capsule(half[0], wide);
  else if (other === 0) shape = new Rapier.Cone(half[0], wide);
  else return "none";
  const line = new Rapier.Ray(xyz(ray.origin), xyz(ray.direction));
  const found = shape.castRay(line, xyz(centre), quaternion(axes), ray.reach, true);
  return Number.isFinite(found) && found !== null && found >= 0 ? found : null;
}

function withJolt(J, ray) {
  const { centre, axes, half } = pose(ray);
  const [wide, other] = [Math.max(ray.shape[6], ray.shape[7]), Math.min(ray.shape[6], ray.shape[7])];
  let settings;
  if (ray.kind === "box") settings = new J.BoxShapeSettings(new J.Vec3(...half), 0);
  else if (ray.kind === "rod") settings = new J.CylinderShapeSettings(half[0], wide, 0);
  else if (ray.kind === "capsule") settings = new J.CapsuleShapeSettings(half[0], wide);
  else settings = new J.TaperedCylinderShapeSettings(half[0], other, wide, 0);
  const made = settings.Create();
  if (!made.IsValid()) return "none"; // it refuses the shape
  const shape = made.Get();
  shape.AddRef();
  const placed = new J.TransformedShape();
  placed.mShape = shape;
  const q = quaternion(axes);
  placed.SetWorldTransform(new J.RVec3(...centre), new J.Quat(q.x, q.y, q.z, q.w), new J.Vec3(1, 1, 1));
  const cast = new J.RRayCast(new J.RVec3(...ray.origin), new J.Vec3(...scale(ray.direction, ray.reach)));
  const hit = new J.RayCastResult();
  placed.CastRay(cast, hit);
  const fraction = hit.mFraction;
  for (const made of [cast, hit, placed]) J.destroy(made);
  shape.Release();
  return fraction <= 1 ? fraction * ray.reach : null;
}

function withThree(ray) {
  if (ray.kind !== "box") return "none";
  const { centre, axes, half } = pose(ray);
  const local = (v) => new THREE.Vector3(...axes.map((a) => dot(a, v)));
  const line = new THREE.Ray(local(add(ray.origin, scale(centre, -1))), local(ray.direction));
  const box = new THREE.Box3(new THREE.Vector3(...scale(half, -1)), new THREE.Vector3(...half));
  const found = line.intersectBox(box, new THREE.Vector3());
  return found ? found.sub(line.origin).dot(line.direction) / line.direction.lengthSq() : null;
}

function answers(answer) {
  return rays.map((ray) => {
    try {
      return answer(ray);
    } catch {
      return null; // an exception is no answer
    }
  });
}

keep("three.js", "three", answers(withThree));
await Rapier.init();
keep("Rapier", "@dimforge/rapier3d-compat", answers(withRapier));
const J = await initJolt();
keep("Jolt", "jolt-physics", answers((ray) => withJolt(J, ray)));
