// Curves over the time that all panels share: {from, to, now, end} in us. Each canvas is drawn once per range and size, and the
// cursor over it.

function css(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

// Fits a canvas to its place. True where its size has changed.
function fit(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return false;
  canvas.width = width;
  canvas.height = height;
  return true;
}

// 1, 2 or 5 times a power of ten: about `count` of them in the span.
function tickStep(span, count) {
  const raw = span / Math.max(1, count);
  const power = Math.pow(10, Math.floor(Math.log10(raw)));
  const first = raw / power;
  return power * (first <= 1 ? 1 : first <= 2 ? 2 : first <= 5 ? 5 : 10);
}

function digitsOf(step) { return Math.max(0, -Math.floor(Math.log10(step) + 1e-9)); }

// What the pointer does over a canvas with a time axis: drag moves the instant, with shift it pans; wheel and two fingers zoom.
function followPointer(canvas, time, axis) {
  const pointers = new Map();
  let pinch = null, moved = false;
  const timeAt = (x) => {
    const box = canvas.getBoundingClientRect();
    const left = axis.left(), right = axis.right();
    return time.from + (time.to - time.from) * (x - box.left - left) / Math.max(1, box.width - left - right);
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 1) return;
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, event.clientX);
    moved = false;
    if (pointers.size === 1 && !event.shiftKey && event.button === 0) time.seek(timeAt(event.clientX));
    if (pointers.size === 2) {
      const x = [...pointers.values()];
      pinch = {a: timeAt(x[0]), b: timeAt(x[1])};
    }
    event.preventDefault();
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = pointers.get(event.pointerId);
    pointers.set(event.pointerId, event.clientX);
    if (pinch && pointers.size === 2) {
      const box = canvas.getBoundingClientRect();
      const width = Math.max(1, box.width - axis.left() - axis.right());
      const share = [...pointers.values()].map((x) => (x - box.left - axis.left()) / width);
      if (Math.abs(share[1] - share[0]) < 0.02) return;
      const span = Math.abs((pinch.b - pinch.a) / (share[1] - share[0]));
      time.show(pinch.a - share[0] * span, pinch.a + (1 - share[0]) * span);
    } else if (event.shiftKey || event.buttons === 4) {
      const shift = timeAt(before) - timeAt(event.clientX);
      time.show(time.from + shift, time.to + shift);
    } else if (!pinch) {
      time.seek(timeAt(event.clientX));
    }
  });
  const end = (event) => {
    pointers.delete(event.pointerId);
    if (pointers.size === 0) pinch = null;
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    time.zoom(Math.exp(event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.002)), timeAt(event.clientX));
  }, {passive: false});
}

class Plot {
  // `series`: {name, colour, table, value: array of the table, dots, shown()}; `range`: [low, high] or null, then of the values.
  constructor(title, unit, series, options) {
    this.title = title;
    this.unit = unit;
    this.series = series;
    this.options = options || {};
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    this.drawn = document.createElement("canvas");
    this.key = "";
  }

  left() { return 44; }
  right() { return 8; }

  valueRange(time) {
    if (this.options.range) return this.options.range;
    let low = Infinity, high = -Infinity;
    for (const s of this.series) {
      if (s.shown && !s.shown()) continue;
      const begin = Math.max(0, rowsUntil(s.table, time.from) - 1), end = Math.min(s.table.rows, rowsUntil(s.table, time.to) + 1);
      const values = s.value(s.table);
      for (let i = begin; i < end; ++i) {
        const v = values[i];
        if (v < low) low = v;
        if (v > high) high = v;
      }
    }
    if (low > high) return [0, 1];
    if (this.options.zero) low = Math.min(low, 0);
    const pad = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
    return [this.options.zero && low === 0 ? 0 : low - pad, high + pad];
  }

  draw(time, version) {
    this.canvas.style.height = (this.options.height || 96) + 16 * this.headingLines(this.canvas.width / Math.max(1, this.canvas.clientWidth)) + "px";
    fit(this.canvas);
    const width = this.canvas.width, height = this.canvas.height;
    const ratio = width / Math.max(1, this.canvas.clientWidth);
    const key = [width, height, time.from, time.to, version].join();
    if (key !== this.key) {
      if (width !== this.drawn.width) this.usedLines = 1;
      this.key = key;
      this.drawn.width = width;
      this.drawn.height = height;
      this.drawStatic(this.drawn.getContext("2d"), time, ratio);
    }
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, width, height);
    context.drawImage(this.drawn, 0, 0);
    this.drawCursor(context, time, ratio);
  }

  // Lines of the heading: the values of all curves.
  headingLines(ratio) { return Math.max(this.usedLines || 1, Math.ceil((this.series.length + 1) * 104 * ratio / this.canvas.width)); }

  box(ratio) {
    const top = 4 + 16 * this.headingLines(ratio);
    return {x: this.left() * ratio, y: top * ratio, w: this.drawn.width - (this.left() + this.right()) * ratio,
      h: this.drawn.height - (top + 16) * ratio};
  }

  drawStatic(context, time, ratio) {
    const box = this.box(ratio);
    const range = this.valueRange(time);
    const toX = (t) => box.x + box.w * (t - time.from) / (time.to - time.from);
    const toY = (v) => box.y + box.h * (range[1] - v) / (range[1] - range[0]);
    context.font = 11 * ratio + "px system-ui, sans-serif";
    context.lineWidth = ratio;
    context.strokeStyle = css("--grid");
    context.fillStyle = css("--soft");
    context.textAlign = "right";
    context.textBaseline = "middle";
    const stepY = tickStep(range[1] - range[0], box.h / (26 * ratio));
    for (let v = Math.ceil(range[0] / stepY) * stepY; v <= range[1]; v += stepY) {
      const y = toY(v);
      context.beginPath();
      context.moveTo(box.x, y);
      context.lineTo(box.x + box.w, y);
      context.stroke();
      context.fillText(v.toFixed(digitsOf(stepY)), box.x - 5 * ratio, y);
    }
    context.textAlign = "center";
    context.textBaseline = "top";
    const span = (time.to - time.from) * 1e-6;
    const stepX = tickStep(span, box.w / (85 * ratio));
    for (let t = Math.ceil(time.from * 1e-6 / stepX) * stepX; t <= time.to * 1e-6; t += stepX) {
      const x = toX(t * 1e6);
      context.beginPath();
      context.moveTo(x, box.y);
      context.lineTo(x, box.y + box.h);
      context.stroke();
      context.fillText(t.toFixed(digitsOf(stepX)) + " s", Math.min(x, this.drawn.width - 18 * ratio), box.y + box.h + 4 * ratio);
    }
    context.save();
    context.beginPath();
    context.rect(box.x, box.y, box.w, box.h);
    context.clip();
    for (const s of this.series) {
      if (!s.shown || s.shown()) this.drawSeries(context, s, time, box, toX, toY, ratio);
    }
    context.restore();
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.fillStyle = css("--text");
    context.font = "600 " + context.font;
    context.fillText(this.title + (this.unit ? " [" + this.unit + "]" : ""), 6 * ratio, 10 * ratio);
    this.titleWidth = context.measureText(this.title + (this.unit ? " [" + this.unit + "]" : "")).width + 18 * ratio;
  }

  // Per column of pixels the least and the greatest value; a gap of more than `gap` us, or a value that is none, ends a line.
  drawSeries(context, s, time, box, toX, toY, ratio) {
    const table = s.table, values = s.value(table);
    const begin = Math.max(0, rowsUntil(table, time.from) - 1), end = Math.min(table.rows, rowsUntil(table, time.to) + 1);
    context.strokeStyle = context.fillStyle = s.colour;
    context.lineWidth = 1.4 * ratio;
    const gap = s.gap || Infinity;
    if (s.dots) {
      const size = 2 * ratio;
      let lastX = -1, lastY = -1;
      for (let i = begin; i < end; ++i) {
        const v = values[i];
        if (v !== v) continue;
        const x = Math.round(toX(table.t[i])), y = Math.round(toY(v));
        if (x === lastX && y === lastY) continue;
        lastX = x;
        lastY = y;
        context.fillRect(x - size / 2, y - size / 2, size, size);
      }
      return;
    }
    // A bar for each column; a line between columns that are not neighbours. Bars are drawn much faster than lines.
    context.beginPath();
    const width = context.lineWidth;
    let column = NaN, top = 0, bottom = 0, last = 0, lastT = -Infinity;
    const flush = () => {
      if (column === column) context.fillRect(column - width / 2, top - width / 2, width, bottom - top + width);
    };
    for (let i = begin; i < end; ++i) {
      const v = values[i], t = table.t[i];
      if (v !== v || t - lastT > gap) {
        flush();
        column = NaN;
        if (v !== v) continue;
      }
      lastT = t;
      const x = Math.round(toX(t)), y = toY(v);
      if (x !== column) {
        flush();
        if (x > column + 1) {
          context.moveTo(column, last);
          context.lineTo(x, y);
        }
        top = bottom = x === column + 1 ? last : y;
        column = x;
      }
      if (y < top) top = y;
      if (y > bottom) bottom = y;
      last = y;
    }
    flush();
    context.stroke();
  }

  drawCursor(context, time, ratio) {
    const box = this.box(ratio);
    const x = box.x + box.w * (time.now - time.from) / (time.to - time.from);
    if (x >= box.x && x <= box.x + box.w) {
      context.strokeStyle = css("--text");
      context.lineWidth = ratio;
      context.beginPath();
      context.moveTo(x, box.y);
      context.lineTo(x, box.y + box.h);
      context.stroke();
    }
    // The values at the cursor, in the colours of their curves.
    let at = this.titleWidth || 90 * ratio, line = 10 * ratio;
    context.font = 11 * ratio + "px system-ui, sans-serif";
    context.textAlign = "left";
    context.textBaseline = "middle";
    for (const s of this.series) {
      if (s.shown && !s.shown()) continue;
      const row = rowAt(s.table, time.now, s.age || 20e3);
      const value = row < 0 ? NaN : s.value(s.table)[row];
      const text = s.name + " " + (value === value ? value.toFixed(Math.abs(value) >= 100 || s.whole ? 0 : 2) : "–");
      const wide = context.measureText(text).width + 22 * ratio;
      if (at + wide > context.canvas.width) {
        at = 6 * ratio;
        line += 16 * ratio;
      }
      context.fillStyle = s.colour;
      context.beginPath();
      context.arc(at + 4 * ratio, line, 4 * ratio, 0, 7);
      context.fill();
      context.fillStyle = css("--soft");
      context.fillText(text, at + 11 * ratio, line);
      at += wide;
    }
    // The next time there is room for them.
    this.usedLines = Math.max(this.usedLines || 1, 1 + Math.round((line - 10 * ratio) / (16 * ratio)));
  }
}
