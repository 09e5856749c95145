// Drawings that the page makes itself: a form's machine with the form's letters, and paths.
"use strict";

function svg(name, about, ...within) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(about)) made.setAttribute(key, value);
  made.append(...within);
  return made;
}

const line = (points, kind = "") => svg("path", { d: `M${points.map((point) => point.join(" ")).join("L")}`, class: kind });
const disc = ([cx, cy], r, kind = "") => svg("circle", { cx, cy, r, class: kind });

// A drawing into a box: shapes in units of their own, of which one is so many px across and up, and
// letters, each a place in these units, a text, and the field that it stands for.
function draw(box, said, [across, up], shapes, letters) {
  const scaled = svg("g", { transform: `scale(${across} ${-up})` }, ...shapes);
  const texts = letters.map(([x, y, text, name = ""]) => {
    const made = svg("text", { x: across * x, y: -up * y, "data-name": name });
    made.textContent = text;
    return made;
  });
  const made = svg("svg", { class: "sketch", role: "img", "aria-label": said }, scaled, ...texts);
  box.append(made);
  const { x, y, width, height } = made.getBBox();
  const size = { width: width + 16, height: height + 16 };
  for (const [key, value] of Object.entries({ ...size, viewBox: `${x - 8} ${y - 8} ${size.width} ${size.height}` })) made.setAttribute(key, value);
}

// ---- machine and tunnel about the horizontal joint, in one scale; x points forward, y left, z up,
// lengths are in metres and angles in radians, by their names in a job
const SIZES = ["r", "R", "theta_min", "theta_max", "phi_min", "phi_max", "cutter_radius", "depth", "height"];
const PIXELS = 240; // from the back of the drawing to the cutter's front

// The outline of an egg or of a circle about the centre of its roof, deeper by d.
function outline({ a, radius }, d = 0) {
  const arc = (size, x, y) => `A${size + d} ${size + d} 0 0 1 ${x} ${y}`;
  if (radius) return `M${radius + d} 0${arc(radius, -radius - d, 0)}${arc(radius, radius + d, 0)}Z`;
  const [side, low] = [0.4 * a + 0.8 * d, -1.8 * a - 0.6 * d];
  return `M${a + d} 0${arc(a, -a - d, 0)}${arc(3 * a, -side, low)}${arc(a / 2, side, low)}${arc(3 * a, a + d, 0)}Z`;
}

// What draws the machine of these numbers into a box; where one is missing it stays empty.
function drawMachine(box, job) {
  box.replaceChildren();
  const { r, R, cutter_radius: ball, depth, height } = job;
  const roof = job.radius || job.a;
  if (!SIZES.every((name) => Number.isFinite(job[name])) || !(r > 0 && R > 0 && ball > 0 && roof > 0)) return;
  const [back, reach, centre] = [-0.4 * R, r + R, -height];
  const scale = Array(2).fill(PIXELS / (reach + ball - back));
  const posed = (joints, kind = "faint") => [line(joints, `arm ${kind}`), disc(joints.at(-1), ball, `ball ${kind}`)];
  const arc = (low, high, place) => line(Array.from({ length: 25 }, (_, k) => place(low + ((high - low) * k) / 24)), "angle");
  const along = (heights, kind) => heights.map((z) => line([[back, z], [reach + ball, z]], kind));

  const lifted = (size) => (theta) => [size * Math.cos(theta), -size * Math.sin(theta)];
  const [crown, invert] = [centre + roof, centre - (job.radius ? roof : 2 * roof)];
  const thetas = [job.theta_min, job.theta_max];
  draw(box, "The machine from the side, with theta at its limits and at zero", scale, [
    ...along([crown, invert], "wall"), ...along([crown + depth, invert - depth], "wanted"),
    ...thetas.flatMap((theta) => posed([[0, 0], lifted(r)(theta), lifted(reach)(theta)])),
    ...posed([[0, 0], [r, 0], [reach, 0]], ""),
    disc([0, 0], 0.03 * R, "joint"), disc([r, 0], 0.03 * R, "joint"), arc(...thetas, lifted(0.6 * R)), line([[back / 2, 0], [back / 2, centre]], "size"), line([[back, centre], [r, centre]], "size"),
  ], [
    [0, 0.06 * R, "r", "r"], [r + 0.35 * R, 0.06 * R, "R", "R"], [reach - ball, ball + 0.05 * R, "cutter radius", "cutter_radius"],
    [...lifted(0.68 * R)(thetas[0]), "θ min", "theta_min"], [...lifted(0.68 * R)(thetas[1]), "θ max", "theta_max"],
    [back / 2 + 0.03 * R, centre / 2, "height", "height"], [back, crown + depth + 0.03 * R, "depth", "depth"],
  ]);

  const swung = (phi) => [r + R * Math.cos(phi), R * Math.sin(phi)];
  const phis = [job.phi_min, job.phi_max];
  draw(box, "The machine from above, with phi at its limits and at zero", scale, [
    ...along([-roof, roof], "wall"), ...along([-roof - depth, roof + depth], "wanted"),
    ...phis.flatMap((phi) => posed([[0, 0], [r, 0], swung(phi)])),
    ...posed([[0, 0], [r, 0], [reach, 0]], ""),
    arc(...phis, (phi) => [r + 0.6 * R * Math.cos(phi), 0.6 * R * Math.sin(phi)]),
  ], phis.map((phi, at) => [r + 0.4 * R * Math.cos(phi), 0.75 * R * Math.sin(phi), ["φ min", "φ max"][at], ["phi_min", "phi_max"][at]]));

  const name = job.radius ? "radius" : "a";
  const section = [[0, "wall"], [depth, "wanted"]].map(([d, kind]) => svg("path", { d: outline(job, d), class: kind, transform: `translate(0 ${centre})` }));
  draw(box, "The tunnel's section, with the joint and the cutter before it", scale, [
    ...section, disc([0, 0], ball, "ball"), disc([0, 0], 0.03 * R, "joint"),
    line([[0, centre], [0.8 * roof, centre + 0.6 * roof]], "size"),
  ], [[0.3 * roof, centre + 0.4 * roof, name, `section.${name}`]]);
}

// ---- ways between two joint positions in the plane of both angles, in degrees
function drawPaths(box, paths) {
  const places = Object.values(paths).flat();
  const [low, high] = [Math.min, Math.max].map((pick) => [0, 1].map((k) => pick(...places.map((place) => place[k]))));
  const scale = [520, 300].map((pixels, k) => pixels / Math.max(high[k] - low[k], 1e-6));
  const lines = Object.entries(paths).map(([name, path]) => line(path, name.replace(" ", "-")));
  const step = 18 / scale[1];
  const words = Object.keys(paths).map((name, k) => [low[0] + 60 / scale[0], low[1] - (k + 3) * step, name]);
  const samples = Object.keys(paths).map((name, k) => line([0, 50].map((x) => [low[0] + x / scale[0], low[1] - (k + 2.8) * step]), name.replace(" ", "-")));
  const said = (k) => `${+low[k].toFixed(2)}° to ${+high[k].toFixed(2)}°`;
  draw(box, `Paths in the plane of the joint angles: ${Object.keys(paths).join(", ")}`, scale,
    [svg("rect", { x: low[0], y: low[1], width: high[0] - low[0], height: high[1] - low[1], class: "size" }), ...lines, ...samples],
    [[low[0], low[1] - step, `across: θ, ${said(0)}; up: φ, ${said(1)}`], ...words]);
}
