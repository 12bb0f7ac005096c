"use strict";

const dialog = document.querySelector("dialog");

function show(content) {
  dialog.querySelector("div").replaceChildren(content);
  dialog.showModal();
}

for (const button of document.querySelectorAll(".picture")) {
  button.addEventListener("click", () => show(button.firstElementChild.cloneNode()));
}

// The parameters of a case: those that are its own, then those that all cases share.
function parametersOf(known, place) {
  const own = known.own.map(([name, unit], i) => [name, known.values[place][i], unit]);
  const table = document.createElement("table");
  for (const row of [...own, ...known.fixed]) {
    const line = table.insertRow();
    for (const text of row) line.insertCell().textContent = text;
  }
  return table;
}

// A bound such as "> 10" or "< -5 %" holds for numbers; anything else is a word to be found.
function passes(cell, wanted) {
  const bound = wanted.match(/^(<=|>=|<|>|=)\s*([^\s%]+)\s*%?$/);
  if (!bound) return cell.textContent.toLowerCase().includes(wanted.toLowerCase());
  if (cell.dataset.value === undefined) return false;
  const [value, limit] = [Number(cell.dataset.value), Number(bound[2])];
  switch (bound[1]) {
    case "<": return value < limit;
    case ">": return value > limit;
    case "<=": return value <= limit;
    case ">=": return value >= limit;
    default: return value === limit;
  }
}

// Numbers by their value, texts by the alphabet; what is missing comes last.
function compare(a, b, direction) {
  const [x, y] = [a.dataset.value, b.dataset.value];
  if (x !== undefined && y !== undefined) return direction * (Number(x) - Number(y));
  if (x !== undefined || y !== undefined) return x === undefined ? 1 : -1;
  return direction * a.textContent.localeCompare(b.textContent);
}

for (const table of document.querySelectorAll("table.cases")) {
  const section = table.closest("section");
  const body = table.tBodies[0];
  const rows = [...body.rows];
  const inputs = [...table.querySelectorAll(".filters input")];
  const headings = [...table.tHead.rows[0].cells];
  const known = JSON.parse(section.querySelector(".parameters").textContent);

  headings.forEach((heading, column) => heading.querySelector("button")?.addEventListener("click", () => {
    const direction = heading.ariaSort === "ascending" ? -1 : 1;
    for (const other of headings) other.removeAttribute("aria-sort");
    heading.ariaSort = direction === 1 ? "ascending" : "descending";
    rows.sort((a, b) => compare(a.cells[column], b.cells[column], direction));
    body.append(...rows);
  }));

  function filter() {
    for (const row of rows) {
      row.hidden = !inputs.every((input, i) => {
        const wanted = input.value.trim();
        return wanted === "" || passes(row.cells[i + 1], wanted);
      });
    }
    const shown = rows.filter((row) => !row.hidden).length;
    section.querySelector("output").textContent = shown < rows.length ? `${shown} of ${rows.length} cases` : "";
  }
  for (const input of inputs) input.addEventListener("input", filter);

  for (const button of table.querySelectorAll(".more")) {
    button.addEventListener("click", () => show(parametersOf(known, button.dataset.case)));
  }
}
