// Search and scenes. Pages are opened as files, where nothing can be fetched: what is wanted
// late comes as a script.
"use strict";
const root = document.body.dataset.root;

function load(address) {
  return new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = done;
    script.onerror = failed;
    document.head.append(script);
  });
}

// ---- code: shown or not, as chosen on the page before
const shown = document.getElementById("code");
if (shown) {
  if (kept.code) shown.checked = kept.code === "shown";
  shown.addEventListener("change", () => (kept.code = shown.checked ? "shown" : "hidden"));
}

// ---- a link that leads to a cell opens its code
const unfold = () => {
  const cell = document.getElementById(location.hash.slice(1));
  cell?.querySelector(":scope > details.source")?.setAttribute("open", "");
};
unfold();
addEventListener("hashchange", unfold);

// ---- lists of headings and pages: open beside the text, folded above it; they show where this is
const beside = matchMedia("(min-width: 60rem)");
const lists = document.querySelectorAll(".contents details");
const lay = () => lists.forEach((list) => (list.open = beside.matches));
for (const list of lists) {
  list.addEventListener("toggle", () => {
    const here = list.querySelector("[aria-current]");
    if (here) list.lastElementChild.scrollTop = here.offsetTop - list.lastElementChild.clientHeight / 3;
  });
}
lay();
beside.addEventListener("change", lay);

// ---- code is copied by a button, where the browser lets a page do that
const copied = navigator.clipboard ? "main pre:not(.output, .signature pre)" : "none";
for (const code of document.querySelectorAll(copied)) {
  const box = Object.assign(document.createElement("div"), { className: "copied" });
  const button = Object.assign(document.createElement("button"), { type: "button", className: "copy", textContent: "Copy" });
  button.addEventListener("click", async () => {
    await navigator.clipboard.writeText(code.textContent);
    button.textContent = "Copied";
  });
  code.replaceWith(box);
  box.append(button, code);
}

// ---- boxes that scroll are reached by keyboard
function reach(box) {
  const scrolls = box.scrollWidth > box.clientWidth;
  if (scrolls) box.tabIndex = 0;
  else box.removeAttribute("tabindex");
  box.classList.toggle("scrolls", scrolls);
}
const wide = new ResizeObserver((entries) => entries.forEach(({ target }) => reach(target)));
for (const box of document.querySelectorAll("main pre, main table, main .wide, math[display=block]")) {
  reach(box);
  wide.observe(box);
}

// ---- what a document prints: shown while a mouse rests on the equation or keys are there, or by a
// click or a tap beside it; Escape hides it
for (const printed of document.querySelectorAll("details.printed")) {
  const box = printed.parentElement;
  const hands = {
    pointerenter: (event) => event.pointerType === "mouse" && (printed.open = true),
    pointerleave: (event) => event.pointerType === "mouse" && (printed.open = false),
    focusin: ({ target }) => target.matches(":focus-visible") && (printed.open = true),
    focusout: () => (printed.open = false),
    keydown: ({ key }) => key === "Escape" && (printed.open = false),
  };
  for (const [kind, act] of Object.entries(hands)) box.addEventListener(kind, act);
}

// ---- a notebook is saved; from the disk a link would open it, so there it comes as a script
const download = document.querySelector(".download a");
download?.addEventListener("click", async (event) => {
  if (location.protocol !== "file:") return;
  event.preventDefault();
  const { href } = download;
  try {
    await load(`${href}.js`);
  } catch {
    return location.assign(href);
  }
  const link = document.createElement("a");
  link.download = decodeURIComponent(href.split("/").pop());
  link.href = URL.createObjectURL(new Blob([window.notebook], { type: "application/x-ipynb+json" }));
  link.click();
});

// ---- the first page's machine: it stands still where motion isn't wanted
const machine = document.querySelector("svg#moving"); /* a function may have that name, too */
if (machine) {
  const button = document.getElementById("still");
  const stop = (still) => {
    if (still) machine.pauseAnimations();
    else machine.unpauseAnimations();
    button.setAttribute("aria-pressed", still);
  };
  stop(matchMedia("(prefers-reduced-motion: reduce)").matches);
  button.addEventListener("click", () => stop(!machine.animationsPaused()));
}

// ---- search: index.words[word] = numbers of sections, index.sections[n] = [title, address, text]
const field = document.getElementById("search");
const found = document.getElementById("found");
let loading;

function wordsOf(text) {
  return text.normalize("NFKD").toLowerCase().match(/[\p{L}\p{N}_]+/gu) || [];
}

// How well a word answers what is wanted: it is that, begins with that, or a part of a name does.
function weigh(word, part) {
  if (word === part) return 3;
  return word.startsWith(part) || word.includes("_" + part) ? 1 : 0;
}

const best = (words, part) => Math.max(0, ...words.map((word) => weigh(word, part)));

// Whether two words differ by a letter at most: one more, one less, or another.
function alike(one, other) {
  const [short, long] = one.length < other.length ? [one, other] : [other, one];
  let same = 0;
  while (same < short.length && short[same] === long[same]) same++;
  const rest = long.slice(same + 1);
  return long.length - short.length < 2 && [short.slice(same), short.slice(same + 1)].includes(rest);
}

// A word as it stands in the index, where one that nothing begins with is mistaken by a letter.
function mended(part, words) {
  const every = Object.keys(words);
  if (part.length < 4 || every.some((word) => weigh(word, part))) return part;
  const near = every.filter((word) => alike(word, part));
  return near.sort((a, b) => words[b].length - words[a].length)[0] || part;
}

// How well a section's name answers a word: its own heading, its page's title, its chapter's file.
// A function of the library counts the more, the more sections name it.
function named([title, address], part, words) {
  const titles = title.split(" · ");
  const heading = titles.pop();
  const [file, anchor] = address.split("#");
  if (file.startsWith("library/")) {
    const own = best(wordsOf(heading.split(".").pop()), part);
    // A method, or a module.
    if (heading.includes(".")) return own;
    return 4 * own + (own && anchor && words[heading] ? 6.5 + Math.log2(words[heading].length) : 0);
  }
  const chapter = file.startsWith("chapters/") && !titles.length && best(file.split(/[/_.]/), part);
  return 4 * best(wordsOf(heading), part) + best(wordsOf(titles.join(" ")), part) + 5 * chapter;
}

// Sections with every word, best first.
function search(text) {
  const { words, sections } = window.searchIndex;
  const wanted = wordsOf(text).map((part) => mended(part, words));
  const scores = new Map();
  wanted.forEach((part, n) => {
    const here = new Map();
    for (const [word, places] of Object.entries(words)) {
      const weight = weigh(word, part);
      if (!weight) continue;
      for (const place of places) here.set(place, Math.max(here.get(place) || 0, weight));
    }
    for (const [place, weight] of here) {
      const [so_far, count] = scores.get(place) || [0, 0];
      if (count < n) continue;
      scores.set(place, [so_far + weight + named(sections[place], part, words), n + 1]);
    }
  });
  return [...scores]
    .filter(([, [, count]]) => wanted.length && count === wanted.length)
    .sort(([a, [x]], [b, [y]]) => y - x || a - b)
    .map(([place]) => sections[place]);
}

function entry([title, address, text], wanted) {
  const link = document.createElement("a");
  const head = document.createElement("b");
  const body = document.createElement("span");
  const start = Math.max(0, text.toLowerCase().indexOf(wanted[0]) - 60);
  head.textContent = title;
  // A formula's letters are pairs of units: no half is left at an end.
  const cut = text.slice(start, start + 170).replace(/^[\udc00-\udfff]|[\ud800-\udbff]$/g, "");
  body.textContent = (start ? "… " : "") + cut + " …";
  link.href = root + address;
  link.append(head, body);
  return link;
}

async function answer() {
  loading ??= load(root + "search-index.js");
  await loading;
  const wanted = wordsOf(field.value);
  const results = search(field.value);
  const shown = results.slice(0, 30);
  const more = results.length > shown.length ? `; the best ${shown.length} are shown` : "";
  const count = results.length ? `${results.length} found${more}` : "Nothing found";
  list(wanted.length ? count : "", shown.map((result) => entry(result, wanted)));
}

// Only the count is read out when it changes.
function list(count, entries) {
  document.getElementById("count").textContent = count;
  document.getElementById("results").replaceChildren(...entries);
}

field.addEventListener("input", answer);
field.form.addEventListener("submit", (event) => event.preventDefault());
field.form.addEventListener("keydown", (event) => {
  const links = [field, ...found.querySelectorAll("a")];
  const at = links.indexOf(document.activeElement);
  if (event.key === "Escape") {
    list("", []);
    field.focus();
  } else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
    const next = links[at + (event.key === "ArrowDown" ? 1 : -1)];
    if (next) next.focus();
    event.preventDefault();
  }
});
document.addEventListener("keydown", (event) => {
  const writes = event.target.closest("input, textarea, select, .stage");
  if (event.key !== "/" || writes || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  field.focus();
});
document.addEventListener("click", (event) => {
  if (!field.form.contains(event.target)) list("", []);
});

// ---- scenes: one viewer for all, and a script with the data of each
const how =
  "Drag or press the arrow keys to turn, + and − to come nearer or go back. " +
  "The wheel scrolls the page, with Ctrl it brings the scene nearer.";
// What a key does: degrees across and up, and how many times nearer.
const steps = {
  ArrowLeft: [6, 0, 1], ArrowRight: [-6, 0, 1], ArrowUp: [0, -6, 1], ArrowDown: [0, 6, 1],
  "+": [0, 0, 1.1], "=": [0, 0, 1.1], "-": [0, 0, 1 / 1.1], "−": [0, 0, 1 / 1.1],
};
const buttons = [
  ["Turn left", "←", "ArrowLeft"], ["Turn right", "→", "ArrowRight"], ["Turn up", "↑", "ArrowUp"],
  ["Turn down", "↓", "ArrowDown"], ["Nearer", "+", "+"], ["Farther", "−", "-"],
];
// Degrees that a pixel of a drag turns.
const pixel = 0.4;

function steer(view, [across, up, nearer]) {
  for (const renderer of view.getRenderers()) {
    const camera = renderer.getActiveCamera();
    camera.azimuth(across);
    camera.elevation(up);
    camera.orthogonalizeViewUp();
    camera.dolly(nearer);
    renderer.resetCameraClippingRange();
    renderer.updateLightsGeometryToFollowCamera();
  }
  view.render();
}

// Drawing may be slow: what the hand does meanwhile is added up, and drawn at once. The viewer's own
// hands get none of it, for they lose what comes while it draws, and take the wheel from the page.
function take(stage, view) {
  let [across, up, nearer, due] = [0, 0, 1, false];
  const move = () => {
    if (due) return;
    due = true;
    setTimeout(() => {
      due = false;
      const all = [across, up, nearer];
      [across, up, nearer] = [0, 0, 1];
      steer(view, all);
    });
  };
  let [x, y] = [0, 0];
  const hands = {
    pointerdown: (event) => {
      stage.setPointerCapture(event.pointerId);
      [x, y] = [event.clientX, event.clientY];
    },
    pointermove: (event) => {
      if (!event.buttons) return;
      across -= pixel * (event.clientX - x);
      up += pixel * (event.clientY - y);
      [x, y] = [event.clientX, event.clientY];
      move();
    },
    wheel: (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      nearer *= event.deltaY < 0 ? 1.1 : 1 / 1.1;
      move();
    },
  };
  for (const kind of ["pointerdown", "pointermove", "pointerup", "wheel", "mousedown", "mousemove", "touchstart", "touchmove"]) {
    const act = (event) => (event.stopPropagation(), hands[kind]?.(event));
    stage.addEventListener(kind, act, { capture: true, passive: kind !== "wheel" });
  }
  stage.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !(event.key in steps)) return;
    steer(view, steps[event.key]);
    event.preventDefault();
  });
}

// The picture that a scene is of, where its cell has as many pictures as scenes.
function stillOf(box) {
  const [scenes, stills] = [".scene", "figure"].map((kind) => [...box.parentElement.querySelectorAll(kind)]);
  return scenes.length === stills.length ? stills[scenes.indexOf(box)] : null;
}

function show(box) {
  const stage = document.createElement("div");
  stage.className = "stage";
  stage.tabIndex = 0;
  stage.setAttribute("role", "application");
  stage.setAttribute("aria-label", `${box.dataset.said}. ${how}`);
  const told = document.createElement("p");
  told.textContent = how;
  const still = stillOf(box)?.querySelector("a, img");
  if (still) still.replaceWith(stage);
  const bar = document.createElement("p");
  box.replaceChildren(...(still ? [] : [stage]), bar, told);
  try {
    window.OfflineLocalView.load(stage, { base64Str: window.scenes[box.dataset.scene] });
  } catch (error) {
    if (still) stage.replaceWith(still);
    throw error;
  }
  // The viewer leaves its latest there.
  const view = window.renderWindow;
  for (const inner of stage.querySelectorAll("[tabindex]")) inner.tabIndex = -1;
  take(stage, view);
  for (const [name, sign, key] of buttons) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: sign });
    button.setAttribute("aria-label", `${name}: ${box.dataset.said}`);
    button.addEventListener("click", () => steer(view, steps[key]));
    bar.append(button, " ");
  }
  stage.focus({ preventScroll: true });
}

async function turn(event) {
  const button = event.target;
  const box = button.closest(".scene");
  const said = button.textContent;
  button.textContent = "Loading …";
  try {
    await load(`${root}scenes/${box.dataset.scene}.js`);
    // Last: a viewer that isn't given a scene at once covers the page and asks for a file.
    if (!window.OfflineLocalView) await load(root + "scenes/viewer.js");
    show(box);
  } catch {
    button.textContent = said;
    const told = document.createElement("p");
    told.setAttribute("role", "alert");
    told.textContent = "The scene can't be shown: its data didn't load, or the browser has no WebGL.";
    box.replaceChildren(button, told);
    button.focus();
  }
}
for (const button of document.querySelectorAll(".scene button")) button.addEventListener("click", turn);
