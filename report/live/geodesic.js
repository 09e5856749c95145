// The calculator: a form's numbers in, the library's out, with all their digits.
"use strict";
{
  const asked = document.getElementById("asked");
  const state = document.getElementById("state");
  const answer = document.getElementById("answer");
  const known = () => asked.elements.known.value;

  asked.addEventListener("change", () => {
    for (const id of ["end", "way"]) document.getElementById(id).hidden = known() !== id;
  });

  function numbers() {
    const fields = [...asked.querySelectorAll("fieldset:not([hidden]) input:not([type=radio])")];
    for (const { name, value } of fields) {
      if (!value.trim() || !Number.isFinite(+value)) throw new Error(`${name}: must be a number; got ${value || "nothing"}.`);
    }
    return Object.fromEntries(fields.map(({ name, value }) => [name, +value]));
  }

  function show([found, paths]) {
    const table = document.createElement("table");
    for (const [name, value] of Object.entries(found)) {
      const row = table.insertRow();
      const head = document.createElement("th");
      head.scope = "row";
      head.textContent = name;
      row.append(head);
      row.insertCell().append(Object.assign(document.createElement("code"), { textContent: value }));
    }
    answer.replaceChildren(table);
    drawPaths(answer, paths);
  }

  function refuse(error) {
    answer.replaceChildren(Object.assign(document.createElement("p"), { textContent: error.message, className: "said" }));
  }

  asked.addEventListener("submit", (event) => {
    event.preventDefault();
    whenReady(state, async () => {
      try {
        const given = numbers();
        await ask("planner");
        show(await ask("geodesic", { asked: given }, () => {}));
      } catch (error) {
        refuse(error);
      }
      state.replaceChildren();
    });
  });
}
