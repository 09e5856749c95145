// The planner: a job's text, a form over its lines, and the command line's own answer to it.
"use strict";
{
  const text = document.getElementById("job");
  const form = document.getElementById("form");
  const state = document.getElementById("state");
  const answer = document.getElementById("answer");
  let jobName = "job.toml";

  // A line that gives a value, perhaps left out: "# name = value  # what it is".
  const LINE = /^(# )?(\w+) = ("[^"]*"|[^\s#]+)\s*(?:# (.*))?$/;
  // Words that go on with those of the line before.
  const MORE = /#  +(.*)$/;
  const TABLE = /^(# )?\[([\w.]+)\]\s*(?:# (.*))?$/;

  // Each line of the form's: its table, name, value, and whether it is there.
  function linesOf(job) {
    let table = "";
    let tableLine;
    const found = [];
    job.split("\n").forEach((line, at) => {
      const head = TABLE.exec(line);
      if (head) [table, tableLine] = [head[2], { at, off: !!head[1] }];
      const given = LINE.exec(line);
      if (given && table) {
        const [, off, name, value, words = ""] = given;
        const about = { at, table, tableLine, off: !!off || tableLine.off, name, value, words };
        found.push({ ...about, hint: MORE.test(line) ? "" : words });
      }
      const more = MORE.exec(line);
      const owner = found.findLast(({ hint }) => hint);
      if (more && owner?.table === table) owner.hint += `; ${more[1]}`;
    });
    return found;
  }

  function field(about) {
    const label = document.createElement("label");
    const name = document.createElement("span");
    const input = document.createElement("input");
    const words = document.createElement("small");
    const quoted = about.value.startsWith('"');
    const plain = quoted ? about.value.slice(1, -1) : about.value;
    name.textContent = about.name;
    words.textContent = about.hint;
    Object.assign(input, { type: "text", spellcheck: false, name: `${about.table}.${about.name}` });
    if (about.off) input.placeholder = plain;
    else input.value = plain;
    input.addEventListener("change", () => put(about, input.value.trim(), quoted));
    label.append(name, input, words);
    return label;
  }

  // Write a value into its line of the text; an empty one leaves the line out.
  function put(about, value, quoted) {
    const lines = text.value.split("\n");
    const words = about.words && `  # ${about.words}`;
    const set = value ? (quoted ? `"${value}"` : value) : about.value;
    lines[about.at] = `${value ? "" : "# "}${about.name} = ${set}${words}`;
    if (value && about.tableLine.off) {
      lines[about.tableLine.at] = lines[about.tableLine.at].slice(2);
    }
    text.value = lines.join("\n");
    showForm();
  }

  function showForm() {
    const focused = document.activeElement?.name;
    const groups = new Map();
    for (const about of linesOf(text.value)) {
      if (!groups.has(about.table)) groups.set(about.table, []);
      groups.get(about.table).push(field(about));
    }
    form.replaceChildren(
      ...[...groups].map(([table, fields]) => {
        const group = document.createElement("fieldset");
        const legend = document.createElement("legend");
        legend.textContent = table;
        group.append(legend, ...fields);
        return group;
      }),
    );
    if (focused) form.querySelector(`[name="${focused}"]`)?.focus();
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
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    take(event.dataTransfer.files[0]);
  });
  text.addEventListener("input", showForm);

  // ---- the command's answer
  function element(name, content, about = {}) {
    return Object.assign(document.createElement(name), { textContent: content }, about);
  }

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
    answer.append(
      element("pre", printed, { id: "budget", className: "output", tabIndex: 0 }),
      picture(files, "plan.png", "Left: the circuit within the joint limits, its knots. Right: the feed along it."),
      picture(files, "wall.png", "The standing wall, unrolled, coloured by its over-break."),
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
  text.value = window.referenceJob;
  showForm();
}
