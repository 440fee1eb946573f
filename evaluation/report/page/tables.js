// Tables of the class `sort`: a click on a heading sorts, and above those of many rows stands a filter.
(function () {
  "use strict";

  // What a cell counts as: its number, else its text.
  function valueOf(cell) {
    if (!cell) return "";
    var value = cell.dataset.value === undefined ? cell.textContent.trim() : cell.dataset.value;
    var number = Number(value);
    return value === "" || value === "–" ? null : Number.isNaN(number) ? value : number;
  }

  // Numbers before words, both before what has no value, in either direction.
  function compare(a, b, sign) {
    if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1;
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;
    return sign * (typeof a === "number" ? a - b : a.localeCompare(b, "en", {numeric: true}));
  }

  function sortBy(table, column, heading) {
    var ascending = heading.getAttribute("aria-sort") !== "ascending";
    table.querySelectorAll("thead th").forEach(function (other) { other.removeAttribute("aria-sort"); });
    heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    var body = table.tBodies[0];
    Array.from(body.rows).map(function (row) { return {row: row, value: valueOf(row.cells[column])}; })
      .sort(function (a, b) { return compare(a.value, b.value, ascending ? 1 : -1); })
      .forEach(function (entry) { body.appendChild(entry.row); });
  }

  // A word that a row contains, or NAME<VALUE, NAME>VALUE, NAME=VALUE of a column whose heading ends with NAME.
  function conditionOf(word, headings) {
    var parts = /^(.+?)(<=|>=|<|>|=)(.+)$/.exec(word);
    if (!parts) {
      return function (row) { return row.textContent.toLowerCase().indexOf(word.toLowerCase()) >= 0; };
    }
    var column = headings.findIndex(function (text) { return text === parts[1]; });
    if (column < 0) column = headings.findIndex(function (text) { return text.endsWith(parts[1]); });
    if (column < 0) return null;
    var wanted = Number.isNaN(Number(parts[3])) ? parts[3] : Number(parts[3]);
    return function (row) {
      var value = valueOf(row.cells[column]);
      if (value === null) return false;
      switch (parts[2]) {
        case "<": return value < wanted;
        case ">": return value > wanted;
        case "<=": return value <= wanted;
        case ">=": return value >= wanted;
        default: return String(value) === String(wanted);
      }
    };
  }

  function addFilter(table, headings) {
    var holder = document.createElement("div");
    var label = document.createElement("label");
    var input = document.createElement("input");
    var count = document.createElement("output");
    holder.className = "filter";
    input.type = "search";
    var numbers = headings.filter(function (heading, column) {
      return typeof valueOf(table.tBodies[0].rows[0].cells[column]) === "number";
    });
    input.placeholder = "words" + (numbers.length ? ", " + numbers[numbers.length - 1] + "<0.5" : "");
    label.append("Rows with ", input);
    holder.append(label, count);
    var wide = table.closest(".wide") || table;
    wide.parentNode.insertBefore(holder, wide);
    function apply() {
      var words = input.value.split(/\s+/).filter(Boolean);
      var conditions = words.map(function (word) { return conditionOf(word, headings); });
      var unknown = words.filter(function (word, i) { return conditions[i] === null; });
      var shown = 0;
      Array.from(table.tBodies[0].rows).forEach(function (row) {
        row.hidden = !conditions.every(function (condition) { return condition === null || condition(row); });
        if (!row.hidden) ++shown;
      });
      count.textContent = unknown.length ? "no column of " + unknown.join(", ") : shown + " of " + table.tBodies[0].rows.length;
    }
    input.addEventListener("input", apply);
    apply();
  }

  var enoughToFilter = 8;
  document.querySelectorAll("table.sort").forEach(function (table) {
    var heads = Array.from(table.querySelectorAll("thead th"));
    heads.forEach(function (heading, column) {
      heading.tabIndex = 0;
      heading.addEventListener("click", function () { sortBy(table, column, heading); });
      heading.addEventListener("keydown", function (event) {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        sortBy(table, column, heading);
      });
    });
    if (table.tBodies[0].rows.length >= enoughToFilter)
      addFilter(table, heads.map(function (heading) { return heading.innerText.replace(/\s+/g, "_").trim(); }));
  });
})();
