// Sliders and exercises that run the library in the page: Python is loaded once, when the first is
// asked for.
"use strict";
const stays = "The page stays as it was made.";
const cannot = `This browser can't run Python in a page, which takes WebAssembly and Workers. ${stays}`;
const waiting = new Map();
let worker;
let asked = 0;
let ready;

function ask(task, content = {}, said) {
  asked += 1;
  const id = asked;
  return new Promise((done, failed) => {
    waiting.set(id, { done, failed, said });
    worker.postMessage({ id, task, ...content });
  });
}

function hear({ data }) {
  const { done, failed, said } = waiting.get(data.id);
  if ("said" in data) return said(data.said);
  waiting.delete(data.id);
  if ("failed" in data) failed(new Error(data.failed));
  else done(data.answer);
}

// Python, ready; `said` hears how far it is, as a share and in words.
async function loadPython(said) {
  const { parts, total } = window.runtimeParts;
  let so_far = 0;
  for (const [name, size] of parts) {
    said((0.4 * so_far) / total, `Reading ${Math.round(total / 1e6)} MB`);
    await load(`${root}live/${name}.js`);
    so_far += size;
  }
  const { "pyodide.js": loader, "worker.js": own, lock, ...files } = window.runtime;
  const text = [own, loader].map((part) => new TextDecoder().decode(Uint8Array.from(atob(part), (c) => c.charCodeAt(0))));
  worker = new Worker(URL.createObjectURL(new Blob([text.join("\n")], { type: "text/javascript" })));
  worker.onmessage = hear;
  const stages = ["Starting Python", "Unpacking numpy, scipy and matplotlib", "Importing them"];
  const reach = (stage) => said([0.45, 0.6, 0.8][stages.indexOf(stage)], stage);
  await ask("start", { files, lock: atob(lock) }, reach);
  delete window.runtime;
}

// ---- one drawing: its sliders, and the picture that they move
function control({ name, min, max, value, whole, description }, move) {
  const label = document.createElement("label");
  const words = document.createElement("span");
  const slider = document.createElement("input");
  const shown = document.createElement("output");
  words.textContent = description;
  // Steps from the low end would move the start, which need not be one of them.
  Object.assign(slider, { type: "range", min, max, step: whole ? 1 : "any", value, name });
  const show = () => (shown.textContent = whole ? slider.value : String(+(+slider.value).toPrecision(4)));
  slider.addEventListener("input", () => (show(), move()));
  show();
  label.append(words, slider, shown);
  return label;
}

// The picture that stands before a box in its cell; where none does, a new one.
function pictureBefore(box) {
  const stored = [...box.parentElement.querySelectorAll("figure img")].pop();
  if (stored) return stored;
  const figure = document.createElement("figure");
  const picture = document.createElement("img");
  figure.append(picture);
  box.before(figure);
  return picture;
}

function moving(box, name, controls) {
  const picture = pictureBefore(box);
  let busy = false;
  let behind = false;
  const told = document.createElement("p");
  told.setAttribute("role", "status");
  const sliders = controls.map((about) => control(about, draw));
  const values = () =>
    Object.fromEntries(sliders.map(({ control: input }) => [input.name, +input.value]));

  // While one is drawn others aren't asked for; then the newest is.
  async function draw() {
    if (busy) return (behind = true);
    busy = true;
    do {
      behind = false;
      const began = performance.now();
      try {
        const { picture: drawn, alt } = await ask("draw", { name, values: values() });
        // Decoded apart: the shown one may be lazy and out of sight, and then waits; while it shows
        // another, Firefox refuses some.
        const next = new Image();
        next.src = URL.createObjectURL(new Blob([drawn], { type: "image/bmp" }));
        await next.decode();
        URL.revokeObjectURL(picture.src);
        picture.src = next.src;
        picture.alt = alt;
        picture.closest("a")?.removeAttribute("href");
        box.dataset.moment = Math.round(performance.now() - began);
        box.dataset.drawn = +(box.dataset.drawn || 0) + 1;
        told.textContent = "";
      } catch (error) {
        told.textContent = error.message;
      }
    } while (behind);
    busy = false;
  }
  box.replaceChildren(...sliders, told);
  sliders[0].control.focus({ preventScroll: true });
  return draw();
}

// Load Python, which a box shows meanwhile; then go on with `next`, which gets that display.
async function whenReady(box, next) {
  const bar = document.createElement("progress");
  const told = document.createElement("p");
  told.setAttribute("role", "status");
  bar.setAttribute("aria-label", "Python is loading");
  if (typeof WebAssembly !== "object" || typeof Worker !== "function") {
    told.textContent = cannot;
    return box.replaceChildren(told);
  }
  box.replaceChildren(bar, told);
  const said = (share, text) => {
    if (share === null) bar.removeAttribute("value"); // on its way, nobody says how far
    else bar.value = share;
    if (told.textContent !== `${text} …`) told.textContent = `${text} …`;
  };
  let failed = "Python didn't start";
  let again = " Reload the page to try again.";
  try {
    const began = performance.now();
    said(0, "Loading Python");
    await (ready ??= loadPython(said));
    [failed, again] = ["That failed", ""];
    await next(said);
    box.dataset.ready = Math.round(performance.now() - began);
  } catch (error) {
    const why = error.message || "a file didn't load";
    told.textContent = `${failed} (${why}). ${stays}${again}`;
    box.replaceChildren(told);
  }
}

function run(event) {
  const box = event.target.closest(".live");
  const name = box.dataset.program;
  return whenReady(box, async (said) => {
    if (!window.programs?.[name]) await load(`${root}live/programs/${name}.js`);
    said(0.9, "Running the chapter's code");
    await moving(box, name, await ask("open", { name, program: window.programs[name] }));
  });
}

// ---- one exercise: its cell's code, for the reader to change, and what it prints
function trying(box, name, source) {
  const code = document.createElement("textarea");
  const button = document.createElement("button");
  const told = document.createElement("pre");
  Object.assign(code, { value: source, rows: source.split("\n").length + 2, spellcheck: false });
  code.setAttribute("aria-label", "The exercise's code");
  Object.assign(button, { type: "button", textContent: "Run" });
  told.setAttribute("role", "status");
  let busy = false;
  button.addEventListener("click", async () => {
    if (busy) return;
    busy = true;
    told.textContent = "Running; a reload of the page stops it …";
    try {
      told.textContent = await ask("run", { name, text: code.value });
    } catch (error) {
      told.textContent = error.message;
    }
    busy = false;
  });
  box.replaceChildren(code, button, told);
  code.focus({ preventScroll: true });
}

function tryIt(event) {
  const box = event.target.closest(".live");
  return whenReady(box, async () => {
    const { href } = document.querySelector(".download a");
    await load(`${href}.js`);
    const cell = +box.dataset.exercise;
    const name = `exercise-${cell}`;
    trying(box, name, await ask("exercise", { name, notebook: window.notebook, cell }));
  });
}

for (const [box, act] of [["[data-program]", run], ["[data-exercise]", tryIt]]) {
  for (const button of document.querySelectorAll(`${box} button`)) button.addEventListener("click", act);
}
