// Python in a Worker: the page stays free to move. It runs as a blob, with Pyodide's own loader after it.
// The page sends files in base64, since neither may fetch one where pages are opened as files.
"use strict";
let python;
let planner; // planner.py, which most pages don't need
const opened = new Map();
const types = { wasm: "application/wasm", json: "application/json" };

function bytes(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const found = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) found[i] = letters.charCodeAt(i);
  return found;
}

// Pyodide asks for its files by address: it gets what the page sent.
function answerFrom(files) {
  self.fetch = async (asked) => {
    const name = String(asked.url || asked).split("/").pop().split("?")[0];
    if (!(name in files)) throw new TypeError(`not here: ${name}`);
    const type = types[name.split(".").pop()] || "application/octet-stream";
    const body = bytes(files[name]);
    delete files[name];
    return new Response(body, { headers: { "content-type": type } });
  };
}

// What Python has translated, as a function: a script, run at once. Firefox wants its type.
const runNow = self.importScripts.bind(self);
self.compiled = (script) => {
  const text = `self.latest = (() => {\n"use strict";\n${script}})();`;
  const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  runNow(address);
  URL.revokeObjectURL(address);
  return self.latest;
};

// Rows of a table that lies in one piece.
self.rowsOf = (flat, width) =>
  Array.from({ length: flat.length / width }, (_, row) => flat.subarray(row * width, (row + 1) * width));

// Pyodide takes a Worker for a module's, as it wants it, where this fails; it has nothing to load.
self.importScripts = () => {
  throw new TypeError("nothing is loaded here");
};

async function start({ files, lock, said }) {
  answerFrom(files);
  said("Starting Python");
  const core = new Blob([bytes(files["pyodide.asm.mjs"])], { type: "text/javascript" });
  const module = await import(URL.createObjectURL(core));
  const here = "https://local.invalid/"; // never asked: fetch answers from memory
  python = await loadPyodide({
    createPyodideModule: module.default, indexURL: here, packageBaseUrl: here, lockFileContents: lock,
  });
  const { _sin: sin, _cos: cos, _tanh: tanh } = python._module;
  self.libm = { sin, cos, tanh }; // for what Python has translated
  said("Unpacking numpy, scipy and matplotlib");
  await python.loadPackage(Object.keys(JSON.parse(lock).packages), { messageCallback() {} });
  python.unpackArchive(bytes(files["study.zip"]).buffer, "zip", { extractDir: "/study" });
  said("Importing them");
  planner = new TextDecoder().decode(bytes(files["planner.py"]));
  python.runPython(new TextDecoder().decode(bytes(files["worker.py"])));
}

// What a function of planner.py returns; its progress is told line by line.
function planned(name, said, ...values) {
  python.setStderr({ batched: said });
  const found = python.globals.get(name)(...values.map((value) => python.toPy(value)));
  return found?.toJs ? found.toJs({ dict_converter: Object.fromEntries }) : found;
}

const tasks = {
  start,
  open({ name, program }) {
    const drawing = python.globals.get("Drawing")(program);
    opened.set(name, drawing);
    return drawing.controls().toJs({ dict_converter: Object.fromEntries });
  },
  draw({ name, values }) {
    const [picture, alt] = opened.get(name).drawn(python.toPy(values)).toJs();
    return { picture, alt };
  },
  exercise({ name, notebook, cell }) {
    const exercise = python.globals.get("Exercise")(notebook, cell);
    opened.set(name, exercise);
    return exercise.source;
  },
  run: ({ name, text }) => opened.get(name).printed(text),
  planner: () => void python.runPython(planner),
  cut({ text, name, said }) {
    const [code, printed, files] = planned("cut", said, text, name);
    return { code, printed, files };
  },
  geodesic: ({ asked, said }) => planned("geodesic_of", said, asked),
};

// One task after the other, in the order they came.
let last = Promise.resolve();
onmessage = ({ data }) => {
  last = last.then(async () => {
    try {
      const said = (text) => postMessage({ id: data.id, said: text });
      postMessage({ id: data.id, answer: await tasks[data.task]({ ...data, said }) });
    } catch (error) {
      const lines = String(error.message || error).trim().split("\n");
      postMessage({ id: data.id, failed: lines[lines.length - 1] });
    }
  });
};
