// The planner: a job's text, a form over its lines, and the command line's own answer to it.
"use strict";
{
  const text = document.getElementById("job");
  const form = document.getElementById("form");
  const state = document.getElementById("state");
  const answer = document.getElementById("answer");
  let jobName = "job.toml";

  function element(name, content, about = {}) {
    return Object.assign(document.createElement(name), { textContent: content }, about);
  }

  // A table's head, and a line that gives a value; either may be left out: "# name = value  # words".
  const TABLE = /^(# |\s*)\[\s*([\w.]+)\s*\]\s*(?:#\s?(.*))?$/;
  const VALUE = /=\s*("[^"]*"|'[^']*'|[^\s#]+)/;
  const LINE = /^(# |\s*)"?(\w+)"?\s*=\s*("[^"]*"|'[^']*'|[^\s#]+)\s*(?:#\s?(.*))?$/;

  // The heads and the lines of a job. A line counts for the last head that does; one that is left
  // out would count for the last head of all.
  function parsed(job) {
    const [heads, lines] = [[], []];
    let latest, counting;
    job.split("\n").forEach((line, at) => {
      if (/^\s*\[\[/.test(line)) latest = counting = undefined; // of a list of tables
      const head = TABLE.exec(line);
      const given = LINE.exec(line);
      if (head) {
        latest = { at, off: head[1] === "# ", name: head[2], words: head[3] || "" };
        if (!latest.off) counting = latest;
        heads.push(latest);
      } else if (given) {
        const [, sign, name, value, words = ""] = given;
        const off = sign === "# ";
        const owner = off ? latest : counting;
        if (owner) lines.push({ at, off, owner, table: owner.name, name, value, words });
      }
    });
    return { heads, lines };
  }

  const bare = (name) => name.replace(/_deg$/, "");
  const headOf = ({ heads }, table) => heads.filter(({ name }) => name === table).sort((a, b) => a.off - b.off)[0];

  // The line of a job that gives a value, or else that would; an angle's has one of two names.
  function lineOf(job, { table, name }) {
    const head = headOf(job, table);
    const those = job.lines.filter((line) => line.owner === head && bare(line.name) === bare(name));
    return those.sort((a, b) => a.off - b.off)[0];
  }

  // Whether nothing but comments stands below a table's head.
  function isEmpty(lines, at) {
    const below = lines.slice(at + 1);
    const end = below.findIndex((line) => /^\s*\[/.test(line));
    return below.slice(0, end < 0 ? undefined : end).every((line) => /^\s*(#|$)/.test(line));
  }

  // Write a value into the text; an empty one leaves its line out, and a table without any.
  function put(known, value) {
    const job = parsed(text.value);
    const [line, head] = [lineOf(job, known), headOf(job, known.table)];
    const lines = text.value.split("\n");
    const set = known.value.startsWith('"') ? `"${value}"` : value;
    if (line) {
      const counts = lines[line.at].replace(/^# /, "");
      lines[line.at] = value ? counts.replace(VALUE, () => `= ${set}`) : `# ${counts.trimStart()}`;
    } else if (value) {
      const last = job.lines.filter(({ owner }) => owner === head).pop() || head;
      const added = `${known.name} = ${set}`;
      if (last) lines.splice(last.at + 1, 0, added);
      else lines.push(`[${known.table}]`, added, "");
    }
    if (value && head?.off) lines[head.at] = lines[head.at].slice(2);
    if (!value && line && isEmpty(lines, head.at)) lines[head.at] = `# ${lines[head.at].trimStart()}`;
    text.value = lines.join("\n");
    showForm();
  }

  // A number of a job, an angle in radians; NaN where it has none.
  function numberOf(job, table, name) {
    const line = lineOf(job, { table, name });
    if (!line || line.off) return NaN;
    return line.value * (line.name === name ? 1 : Math.PI / 180);
  }

  // ---- the form: a field for each line of the reference job, with that line's words
  const fields = [];
  const sketch = document.getElementById("sketch");
  const unit = /^([^,]{1,8}|whole number), /;

  function field(known) {
    const label = document.createElement("label");
    const name = document.createElement("span");
    const input = document.createElement("input");
    const words = document.createElement("small");
    const measure = document.createElement("i");
    const example = known.value.replaceAll('"', "");
    Object.assign(input, { type: "text", spellcheck: false, name: `${known.table}.${known.name}` });
    input.addEventListener("change", () => put(known, input.value.trim()));
    for (const kind of ["focus", "blur"]) input.addEventListener(kind, () => point(known, kind === "focus"));
    fields.push((job) => {
      const line = lineOf(job, known);
      const inRadians = line && line.name !== known.name;
      const called = inRadians ? known.words.replace(/^deg/, "rad") : known.words;
      const [, measured = ""] = (!known.value.startsWith('"') && unit.exec(called)) || [];
      name.textContent = bare(known.name).replace("theta", "θ").replace("phi", "φ").replaceAll("_", " ");
      words.textContent = measured ? called.slice(measured.length + 2) : called;
      measure.textContent = measured;
      input.placeholder = `e.g. ${inRadians ? +((+example * Math.PI) / 180).toPrecision(3) : example}`;
      input.value = line && !line.off ? line.value.replace(/^(["'])(.*)\1$/, "$2") : "";
    });
    label.append(name, input, measure, words);
    return label;
  }

  // Show in the drawing what a field is.
  function point({ table, name }, here) {
    for (const text of sketch.querySelectorAll("text")) {
      text.classList.toggle("here", here && [bare(name), `${table}.${name}`].includes(text.dataset.name));
    }
  }

  function drawForm(job) {
    const numbers = SIZES.map((name) => [name, numberOf(job, "machine", name)]);
    const shape = lineOf(job, { table: "section", name: "shape" })?.value.slice(1, -1);
    const size = { egg: "a", circle: "radius" }[shape];
    drawMachine(sketch, { ...Object.fromEntries(numbers), [size]: numberOf(job, "section", size) });
  }

  // A table that a job may lack is shut until the job has it.
  function group(head, known) {
    const box = document.createElement("fieldset");
    const within = document.createElement(head.off ? "details" : "div");
    if (head.words || head.off) within.append(element(head.off ? "summary" : "p", head.words));
    if (head.off) fields.push((job) => (within.open ||= headOf(job, head.name)?.off === false));
    within.append(...known.map(field));
    box.append(element("legend", head.name), within);
    return box;
  }

  function buildForm() {
    const { heads, lines } = parsed(window.referenceJob);
    form.append(...heads.map((head) => group(head, lines.filter(({ owner }) => owner === head))));
  }

  function showForm() {
    const job = parsed(text.value);
    for (const show of fields) show(job);
    drawForm(job);
  }

  // ---- a job from a file: chosen, or dropped on the page
  async function take(file) {
    if (!file) return;
    jobName = file.name;
    text.value = await file.text();
    document.getElementById("name").textContent = jobName;
    showForm();
  }
  document.getElementById("file").addEventListener("change", (event) => take(event.target.files[0]));
  for (const kind of ["dragover", "drop"]) {
    addEventListener(kind, (event) => {
      if (!event.dataTransfer.types.includes("Files")) return; // letters, moved within the text
      event.preventDefault();
      if (kind === "drop") take(event.dataTransfer.files[0]);
    });
  }
  text.addEventListener("input", showForm);

  // ---- the command's answer
  function download(name, content) {
    const type = name.endsWith(".png") ? "image/png" : "application/octet-stream";
    const href = URL.createObjectURL(new Blob([content], { type }));
    const size = content.length > 1e6 ? `${(content.length / 1e6).toFixed(1)} MB` : `${Math.ceil(content.length / 1e3)} kB`;
    const item = document.createElement("li");
    item.append(element("a", name, { href, download: name }), ` ${size}`);
    return item;
  }

  function picture(files, name, alt) {
    const src = URL.createObjectURL(new Blob([files[name]], { type: "image/png" }));
    const figure = document.createElement("figure");
    figure.append(Object.assign(document.createElement("img"), { src, alt }));
    return figure;
  }

  // The rows of budget.csv, with lengths in mm.
  function budgetTable(csv) {
    const [names, ...rows] = csv.trim().split("\n").map((line) => line.split(","));
    const rounded = (text, at) => +(text * (names[at].endsWith("_m") ? 1e3 : 1)).toFixed(4);
    const said = (text, at) => (text && !isNaN(text) ? rounded(text, at) : text || "-");
    const table = document.createElement("table");
    const heads = names.map((name) => element("th", name.replace(/_m$/, " / mm").replace("_", " "), { scope: "col" }));
    table.createCaption().textContent = "Each source alone";
    table.createTHead().insertRow().append(...heads);
    const body = table.createTBody();
    for (const row of rows) body.insertRow().append(...row.map((text, at) => element("td", said(text, at))));
    return table;
  }

  function show({ code, printed, files }, said) {
    const [how] = { 0: ["Planned and simulated"], 1: ["Refused"], 2: ["Not understood"] }[code];
    answer.replaceChildren(element("h2", how));
    for (const line of said.filter((line) => /^(warning|refused|wrong): /.test(line))) {
      answer.append(element("p", line, { className: "said" }));
    }
    if (code) return;
    const list = document.createElement("ul");
    list.append(...Object.entries(files).map(([name, content]) => download(name, content)));
    list.append(download(jobName, new TextEncoder().encode(text.value)));
    const budget = element("div", "", { id: "budget" });
    const [before, after] = printed.split(/each alone, in mm.*\n(?: .*\n)+/);
    const [above, below] = [before, after].map((part) => element("pre", part, { className: "output" }));
    budget.append(above, budgetTable(new TextDecoder().decode(files["budget.csv"])), below);
    for (const part of budget.children) wide.observe(part);
    answer.append(
      budget,
      picture(files, "plan.png", "Left: the circuit within the joint limits, its knots. Right: the feed along it."),
      picture(files, "wall.png", "The standing wall, unrolled, coloured by its overbreak."),
      picture(files, "laps.png", "Overbreak along the section: of the first lap, and of the last if there are more."),
      element("h2", "Files"),
      list,
    );
  }

  async function plan() {
    const said = [];
    answer.replaceChildren();
    await whenReady(state, async (told) => {
      await ask("planner");
      const hear = (line) => {
        said.push(line);
        told(null, line);
      };
      show(await ask("cut", { text: text.value, name: jobName }, hear), said);
      state.replaceChildren();
    });
  }
  document.getElementById("plan").addEventListener("click", plan);
  buildForm();
  text.value = window.referenceJob;
  showForm();
}
