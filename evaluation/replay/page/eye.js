// The image of an eye: events of the last milliseconds, circles, gaze. Zoom and pan by wheel, drag and two fingers.

function rgbOf(hex) { return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)); }

class EyeView {
  // `parts`: {events, truth, detections: [{name, colour, threshold, table, on()}], target (table with target_px_*), principal};
  // `shown(name)`: whether truth, target ... are drawn.
  constructor(canvas, size, colours, parts, shown) {
    this.canvas = canvas;
    this.size = size;
    this.colours = colours;
    this.parts = parts;
    this.shown = shown;
    this.pixels = document.createElement("canvas");
    this.pixels.width = size[0];
    this.pixels.height = size[1];
    this.image = this.pixels.getContext("2d").createImageData(size[0], size[1]);
    this.on = rgbOf(colours.on);
    this.off = rgbOf(colours.off);
    this.zoom = 1;
    this.centre = [size[0] / 2, size[1] / 2];
    this.changed = true;
    this.listen();
  }

  // Pixels of the canvas per pixel of the sensor.
  scale() { return Math.min(this.canvas.width / this.size[0], this.canvas.height / this.size[1]) * this.zoom; }

  // Where a place of the page is in the image, in pixels from the outer corner.
  imageAt(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / box.width, scale = this.scale();
    return [((x - box.left) * ratio - this.canvas.width / 2) / scale + this.centre[0],
      ((y - box.top) * ratio - this.canvas.height / 2) / scale + this.centre[1]];
  }

  zoomBy(factor, x, y) {
    const before = this.imageAt(x, y);
    this.zoom = Math.min(16, Math.max(1, this.zoom * factor));
    const after = this.imageAt(x, y);
    this.move(before[0] - after[0], before[1] - after[1]);
  }

  move(dx, dy) {
    this.centre[0] += dx;
    this.centre[1] += dy;
    for (let i = 0; i < 2; ++i) {
      const half = this.size[i] / 2, room = half * (1 - 1 / this.zoom);
      this.centre[i] = Math.min(half + room, Math.max(half - room, this.centre[i]));
    }
    this.changed = true;
  }

  listen() {
    const canvas = this.canvas, pointers = new Map();
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.002)), event.clientX, event.clientY);
    }, {passive: false});
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const other = [...pointers].filter((entry) => entry[0] !== event.pointerId).map((entry) => entry[1])[0];
      if (other) {
        const was = Math.hypot(before[0] - other[0], before[1] - other[1]);
        const is = Math.hypot(event.clientX - other[0], event.clientY - other[1]);
        if (was > 0 && is > 0) this.zoomBy(is / was, (event.clientX + other[0]) / 2, (event.clientY + other[1]) / 2);
      } else {
        const from = this.imageAt(before[0], before[1]), to = this.imageAt(event.clientX, event.clientY);
        this.move(from[0] - to[0], from[1] - to[1]);
      }
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("dblclick", () => {
      this.zoom = 1;
      this.move(0, 0);
    });
  }

  drawEvents(t, span) {
    const data = this.image.data, width = this.size[0], height = this.size[1];
    for (let i = 0; i < data.length; i += 4) {
      data[i] = 16;
      data[i + 1] = 17;
      data[i + 2] = 20;
      data[i + 3] = 255;
    }
    const events = this.parts.events;
    this.count = 0;
    if (!events) return;
    const end = rowsUntil(events, t), begin = rowsUntil(events, t - span);
    this.count = end - begin;
    for (let i = begin; i < end; ++i) {
      const x = events.x[i], y = events.y[i];
      if (x >= width || y >= height) continue;
      const colour = events.on[i] ? this.on : this.off;
      const share = 1 - 0.65 * (t - events.t[i]) / span;  // older ones are darker
      const at = 4 * (y * width + x);
      data[at] = 16 + (colour[0] - 16) * share;
      data[at + 1] = 17 + (colour[1] - 17) * share;
      data[at + 2] = 20 + (colour[2] - 20) * share;
    }
  }

  draw(t, span) {
    fit(this.canvas);
    this.changed = false;
    this.drawEvents(t, span);
    this.pixels.getContext("2d").putImageData(this.image, 0, 0);
    const context = this.canvas.getContext("2d"), scale = this.scale();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#000";
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    context.imageSmoothingEnabled = false;
    // Pixel (0, 0) is the centre of the top left one.
    context.setTransform(scale, 0, 0, scale, this.canvas.width / 2 - this.centre[0] * scale,
      this.canvas.height / 2 - this.centre[1] * scale);
    context.drawImage(this.pixels, 0, 0);
    context.translate(0.5, 0.5);
    this.line = 2 * (window.devicePixelRatio > 1.5 ? 2 : 1) / scale;
    this.drawOverlay(context, t);
  }

  circle(context, x, y, r, colour, dashed) {
    if (!(r > 0)) return;
    context.strokeStyle = colour;
    context.lineWidth = this.line;
    context.setLineDash(dashed ? [3 * this.line, 2 * this.line] : []);
    context.beginPath();
    context.arc(x, y, r, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
  }

  cross(context, x, y, arm, colour) {
    context.strokeStyle = colour;
    context.lineWidth = this.line;
    context.beginPath();
    context.moveTo(x - arm, y);
    context.lineTo(x + arm, y);
    context.moveTo(x, y - arm);
    context.lineTo(x, y + arm);
    context.stroke();
  }

  drawOverlay(context, t) {
    const parts = this.parts;
    const arm = 0.02 * this.size[0] / this.zoom + 1;
    if (parts.truth && this.shown("truth")) {
      const row = rowAt(parts.truth, t, parts.truth_age || 2e3);
      if (row >= 0 && parts.truth.visible[row] > 0)
        this.circle(context, parts.truth.x[row], parts.truth.y[row], parts.truth.r[row], this.colours.truth, false);
    }
    for (const detector of parts.detections) {
      if (!detector.table || !this.shown("detector " + detector.name)) continue;
      const row = rowAt(detector.table, t, parts.detection_age || 2e3);
      if (row < 0 || detector.table.score[row] < detector.threshold) continue;
      this.circle(context, detector.table.x[row], detector.table.y[row], detector.table.r[row], detector.colour,
        detector.table.held[row] > 0);
    }
    if (parts.principal && this.shown("gaze"))
      this.cross(context, parts.principal[0], parts.principal[1], arm, this.colours.gaze);
    if (parts.gaze && this.shown("target")) {
      const row = rowAt(parts.gaze, t, 2e3);
      const x = row < 0 ? NaN : parts.gaze.target_px_x[row], y = row < 0 ? NaN : parts.gaze.target_px_y[row];
      if (x === x) {
        context.strokeStyle = this.colours.target;
        context.lineWidth = this.line;
        context.strokeRect(x - arm / 2, y - arm / 2, arm, arm);
      }
    }
  }
}
