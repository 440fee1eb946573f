// Turns the drawings of a report into plots: each figure holds its drawing (SVG) and its numbers (JSON).
(function () {
  "use strict";

  function save(name, type, text) {
    var link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], {type: type}));
    link.download = name;
    link.click();
    setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
  }

  function field(text) {
    return /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
  }

  function nameOf(panel) { return [panel.title, panel.y_label].filter(Boolean).join(", "); }

  // The word of a value of x where the axis has words (the nearest: detectors are drawn side by side), else its number.
  function xText(panel, x) {
    var best = null;
    panel.x_words.forEach(function (entry) {
      if (best === null || Math.abs(entry[0] - x) < Math.abs(best[0] - x)) best = entry;
    });
    return best === null ? String(Number(x.toPrecision(6))) : best[1];
  }

  // One row per point and panel, as drawn.
  function csvOf(data) {
    var lines = ["panel,series," + field(data.x_label) + ",value"];
    data.panels.forEach(function (panel) {
      panel.series.forEach(function (series) {
        series.x.forEach(function (x, i) {
          if (series.y[i] !== null)
            lines.push([field(nameOf(panel)), field(series.title), field(xText(panel, x)), series.y[i]].join(","));
        });
      });
    });
    return lines.join("\n") + "\n";
  }

  function svgOf(figure) {
    var svg = figure.querySelector(".drawing svg").cloneNode(true);
    svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    return '<?xml version="1.0" encoding="utf-8"?>\n' + new XMLSerializer().serializeToString(svg);
  }

  // The drawing alone on a page of its own size. Returns what brings the report back.
  function layOutForPrint(figure) {
    var svg = figure.querySelector(".drawing svg");
    var box = svg.viewBox.baseVal;
    var place = svg.nextSibling, parent = svg.parentNode;
    var paper = document.createElement("div");
    var style = document.createElement("style");
    var size = box.width + "px " + box.height + "px";
    style.textContent = "@page { size: " + size + "; margin: 0 } " +
      "@media print { html, body { margin: 0; padding: 0 } body > * { display: none !important } " +
      "body > .paper { display: block !important; position: absolute; top: 0; left: 0; width: " + box.width +
      "px; height: " + box.height + "px; overflow: hidden } }";
    paper.className = "paper";
    paper.appendChild(svg);
    document.head.appendChild(style);
    document.body.appendChild(paper);
    return function () {
      parent.insertBefore(svg, place);
      paper.remove();
      style.remove();
    };
  }

  // The browser's print makes the file: vectors, with the drawing's own fonts. Its name is proposed from the title.
  function printFigure(figure, name) {
    var title = document.title;
    var bringBack = layOutForPrint(figure);
    document.title = name;
    window.addEventListener("afterprint", function () {
      document.title = title;
      bringBack();
    }, {once: true});
    window.print();
  }

  // Rows [x, value of each series]: series with the same x share rows. null: no point here; NaN: a gap.
  function rowsOf(panel) {
    var rows = [], groups = {};
    panel.series.forEach(function (series, column) {
      var key = series.x.join(" ");
      if (!groups[key]) {
        groups[key] = series.x.map(function (x) {
          var row = [x];
          panel.series.forEach(function () { row.push(null); });
          rows.push(row);
          return row;
        });
      }
      series.y.forEach(function (y, i) { groups[key][i][column + 1] = y === null ? NaN : y; });
    });
    rows.forEach(function (row, i) { row.order = i; });
    rows.sort(function (a, b) { return a[0] - b[0] || a.order - b.order; });
    return rows;
  }

  // The value of a series at the point nearest to x; null where its nearest point is a gap.
  function nearest(series, x) {
    var best = null, distance = Infinity;
    series.x.forEach(function (at, i) {
      if (Math.abs(at - x) < distance) { distance = Math.abs(at - x); best = i; }
    });
    return best === null ? null : series.y[best];
  }

  // A colour of the style sheet, which depends on the scheme.
  function colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

  // Black of a drawing on paper is the colour of text on the screen.
  function drawn(of) { return /^(#000000|black)$/.test(of) ? colour("--text") : of; }

  function plot(figure, data) {
    // A series from right to left: points of the same x change places, too.
    data.panels.forEach(function (panel) {
      panel.series.forEach(function (s) {
        if (s.x[0] > s.x[s.x.length - 1]) { s.x.reverse(); s.y.reverse(); }
      });
    });
    var drawing = figure.querySelector(".drawing");
    var holder = document.createElement("div");
    holder.className = "plots";
    var values = document.createElement("div");
    var choice = document.createElement("div");
    values.className = "values";
    choice.className = "series";
    drawing.parentNode.insertBefore(choice, drawing);
    drawing.parentNode.insertBefore(holder, drawing);
    drawing.parentNode.insertBefore(values, drawing);
    drawing.hidden = true;
    var hidden = {}, graphs = [], busy = false;

    function each(change) {
      if (busy) return;
      busy = true;
      graphs.forEach(change);
      busy = false;
    }

    data.panels.forEach(function (panel, p) {
      var last = p + 1 === data.panels.length;
      var box = document.createElement("div");
      box.className = "plot";
      box.style.height = (data.panels.length === 1 ? 360 : last ? 200 : 165) + "px";
      holder.appendChild(box);
      var options = {
        labels: [data.x_label].concat(panel.series.map(function (s, i) { return i + " " + s.title; })),
        colors: panel.series.map(function (s) { return drawn(s.colour); }),
        title: panel.title || undefined,
        titleHeight: 18,
        ylabel: panel.y_label,
        xlabel: last ? data.x_label : undefined,
        connectSeparatedPoints: true,
        legend: "never",
        yRangePad: 6,
        axisLineColor: colour("--faint"),
        gridLineColor: colour("--grid"),
        highlightCircleSize: 4,
        series: {},
        animatedZooms: false,
        highlightCallback: function (event, x) {
          values.textContent = data.x_label + " " + xText(panel, x) + ": " + data.panels.map(function (other) {
            return other.series.filter(function (s) { return s.in_key && !hidden[s.title]; }).map(function (s) {
              var y = nearest(s, x);
              return y === null || y === undefined ? null
                : s.title + (data.panels.length > 1 ? ", " + nameOf(other) : "") + " " + Number(y.toPrecision(4));
            }).filter(Boolean).join(" · ");
          }).filter(Boolean).join(" · ");
        },
        unhighlightCallback: function () { values.textContent = ""; },
        zoomCallback: function (from, to) {
          each(function (graph) { if (graph !== graphs[p]) graph.updateOptions({dateWindow: [from, to]}); });
        },
        underlayCallback: function (canvas, area, graph) {
          panel.bands.forEach(function (band) {
            var left = graph.toDomXCoord(band[0]), right = graph.toDomXCoord(band[1]);
            canvas.fillStyle = colour("--band");
            canvas.fillRect(left, area.y, Math.max(1, right - left), area.h);
          });
        },
        axes: {x: {axisLabelWidth: 60}, y: {axisLabelWidth: 60}}
      };
      if (panel.log_x) options.axes.x.logscale = true;
      if (panel.x_words.length) {
        options.axes.x.ticker = function () {
          return panel.x_words.map(function (entry) { return {v: entry[0], label: entry[1]}; });
        };
      }
      if (panel.y_range) options.valueRange = panel.y_range;
      if (panel.x_range) options.dateWindow = panel.x_range;
      panel.series.forEach(function (s, i) {
        options.series[i + " " + s.title] = {strokeWidth: s.lines ? s.width : 0,
          strokePattern: s.dashed ? [6, 4] : null, drawPoints: s.points,
          pointSize: s.lines ? 2.5 : s.x.length <= 3 || panel.x_words.length ? 5 : 1.6};
      });
      graphs.push(new Dygraph(box, rowsOf(panel), options));
    });

    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", function () {
      graphs.forEach(function (graph) {
        graph.updateOptions({axisLineColor: colour("--faint"), gridLineColor: colour("--grid")});
      });
    });

    // What the drawing's key names comes first.
    var seen = {};
    [true, false].forEach(function (named) {
      [].concat.apply([], data.panels.map(function (panel) { return panel.series; })).forEach(function (s) {
        if (s.in_key !== named || seen[s.title]) return;
        seen[s.title] = true;
        var label = document.createElement("label");
        var box = document.createElement("input");
        var dot = document.createElement("span");
        box.type = "checkbox";
        box.checked = true;
        dot.className = "dot";
        dot.style.background = drawn(s.colour);
        box.addEventListener("change", function () {
          hidden[s.title] = !box.checked;
          graphs.forEach(function (graph, p) {
            data.panels[p].series.forEach(function (other, i) {
              if (other.title === s.title) graph.setVisibility(i, box.checked);
            });
          });
        });
        label.append(box, " ", dot, s.title);
        choice.appendChild(label);
      });
    });
  }

  document.querySelectorAll("figure > script[type='application/json']").forEach(function (script) {
    var figure = script.parentNode;
    var data = JSON.parse(script.textContent);
    figure.querySelector("[data-save=svg]").addEventListener("click", function () {
      save(data.name + ".svg", "image/svg+xml", svgOf(figure));
    });
    figure.querySelector("[data-save=pdf]").addEventListener("click", function () { printFigure(figure, data.name); });
    figure.querySelector("[data-save=csv]").addEventListener("click", function () {
      save(data.name + ".csv", "text/csv", csvOf(data));
    });
    if (data.over_x && data.panels.some(function (panel) { return panel.series.length > 0; })) plot(figure, data);
  });

  // On paper no table is wider than the page between its margins, with A4 the narrower of the common sizes: headings wrap, then
  // also within words, and what is still too wide is drawn smaller. The plots give way to their drawings (CSS).
  var paperWidth = (210 - 2 * 12) / 25.4 * 96;
  var smallestReadable = 0.62;

  function shareOfPaper(table) {
    table.style.setProperty("--share", 1);
    table.style.width = "min-content";
    var narrowest = table.getBoundingClientRect().width;
    table.style.width = "";
    return Math.min(1, paperWidth / narrowest);
  }

  window.addEventListener("beforeprint", function () {
    document.body.classList.add("paged");
    document.querySelectorAll(".drawing svg").forEach(function (svg) {
      var box = svg.viewBox.baseVal;
      svg.parentNode.classList.toggle("tall", box.height > 0.65 * box.width);  // two such do not share a page
    });
    document.querySelectorAll(".wide > table").forEach(function (table) {
      table.classList.remove("tight");
      if (shareOfPaper(table) < smallestReadable) table.classList.add("tight");
      table.style.setProperty("--share", shareOfPaper(table));
    });
  });
  window.addEventListener("afterprint", function () { document.body.classList.remove("paged"); });

  // report.html#print=NAME: the page prints as that drawing alone, for `chromium --headless --print-to-pdf`.
  var asked = /^#print=(\w+)$/.exec(location.hash);
  var figure = asked && document.getElementById("figure_" + asked[1]);
  if (figure) layOutForPrint(figure);
})();
