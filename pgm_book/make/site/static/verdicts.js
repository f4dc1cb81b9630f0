// Filter the table of verdicts. The address keeps the choice, so that it can be sent:
// verdicts.html?source=Muliawan+2013&verdict=corrected
"use strict";

const form = document.querySelector(".verdict-controls");
const status = document.querySelector(".verdict-number");
const rows = [...document.querySelectorAll("table.verdicts tbody tr")];
const texts = rows.map((row) => simple(row.textContent));
const CHOICES = ["source", "chapter", "verdict", "kind"];

function simple(text) {
  return text.toLowerCase().replace(/\s+/g, " ");
}

function chosen() {
  return Object.fromEntries([...new FormData(form)].filter(([, value]) => value.trim()));
}

/** Show the rows that have all that is chosen, and say how many they are. */
function filter() {
  const wanted = chosen();
  const words = simple(wanted.words ?? "").trim();
  let number = 0;
  rows.forEach((row, index) => {
    const shown =
      CHOICES.every((name) => !wanted[name] || row.dataset[name] === wanted[name]) &&
      // a phrase first, since "M 2.94" is one name; else all its words
      (texts[index].includes(words) ||
        words.split(" ").every((word) => texts[index].includes(word)));
    row.hidden = !shown;
    number += shown;
  });
  const all = number === rows.length ? "" : ` of ${rows.length}`;
  status.textContent = number
    ? `${number}${all} verdicts.`
    : "No verdict has all of that. Take one of the choices back, or write fewer words.";
}

function nothingChosen() {
  for (const field of form.elements) {
    if (field.name) field.value = "";
  }
}

/** Keep the choice in the address, without a new entry in the history. */
function remember() {
  const query = new URLSearchParams(chosen()).toString();
  history.replaceState(null, "", query ? `?${query}` : location.pathname);
}

/** Take the choice from the address. */
function recall() {
  nothingChosen();
  for (const [name, value] of new URLSearchParams(location.search)) {
    if (form.elements[name]) form.elements[name].value = value;
  }
  filter();
  const target = rows.find((row) => row.id === decodeURIComponent(location.hash.slice(1)));
  if (target?.hidden) {
    nothingChosen(); // a link to a row shows it, whatever was chosen
    filter();
  }
  target?.scrollIntoView();
}

form.addEventListener("input", () => { filter(); remember(); });
form.addEventListener("submit", (event) => event.preventDefault());
// The fields are empty only after the event.
form.addEventListener("reset", () => setTimeout(() => { filter(); remember(); }));
window.addEventListener("hashchange", recall);
window.addEventListener("popstate", recall);
form.hidden = false;
recall();
