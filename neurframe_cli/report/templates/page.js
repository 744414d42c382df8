"use strict";
// Pictures in full size on a click, the numbers as a file, and tables that sort.
(() => {
  const dialog = document.createElement("dialog");
  const large = document.createElement("img");
  dialog.append(large);
  document.body.append(dialog);
  dialog.addEventListener("click", () => dialog.close());
  for (const picture of document.querySelectorAll("figure img")) {
    picture.addEventListener("click", () => { large.src = picture.src; large.alt = picture.alt; dialog.showModal(); });
  }

  const save = document.getElementById("save-json");
  save?.addEventListener("click", () => {
    const text = JSON.stringify(JSON.parse(document.getElementById("numbers").textContent), null, 1);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = save.dataset.name;
    link.click();
    URL.revokeObjectURL(link.href);
  });

  function key(cell) {
    const text = cell.dataset.value ?? cell.textContent.trim();
    const value = Number(text);
    return text !== "" && Number.isFinite(value) ? value : text;
  }
  function compare(a, b) {
    if (typeof a === "number" && typeof b === "number") return a - b;
    if (typeof a === typeof b) return a.localeCompare(b);
    return typeof a === "number" ? -1 : 1;
  }
  for (const head of document.querySelectorAll("th.sortable")) {
    const sort = () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      for (const other of head.parentElement.children) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const body = head.closest("table").tBodies[0];
      const rows = [...body.rows];
      rows.sort((a, b) => (up ? 1 : -1) * compare(key(a.cells[head.cellIndex]), key(b.cells[head.cellIndex])));
      body.append(...rows);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => { if (event.key === "Enter") sort(); });
  }
})();
