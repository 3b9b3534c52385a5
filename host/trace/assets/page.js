"use strict";
// Draws the panels of the page; the data is in the element "data".
const data = JSON.parse(document.getElementById("data").textContent);
const LEFT = 90, RIGHT = 20, TOP = 22, FOOT = 22, TALL = 180, LOW = 80;
let [from, to] = [data.from, data.to];
let cursor = null;
const canvases = data.panels.map((panel) => {
  const canvas = document.createElement("canvas");
  canvas.style.height = (panel.lines ? TALL : LOW) + "px";
  document.getElementById("panels").appendChild(canvas);
  return canvas;
});

// The place of the last time in a flat list of pairs that is not after t, or -1.
function last(list, t) {
  let low = 0, high = list.length / 2;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[2 * middle] <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
}

// The value of a line at t; null outside it.
function at(list, t) {
  const k = last(list, t);
  if (k < 0 || (2 * k + 2 >= list.length && t > list[2 * k])) return null;
  const [a, b] = [list[2 * k], list[2 * k + 2]];
  return b > a ? list[2 * k + 1] + (list[2 * k + 3] - list[2 * k + 1]) * (t - a) / (b - a) : list[2 * k + 1];
}

// Least and greatest value of what is shown, with some air.
function range(panel) {
  let [low, high] = panel.zero ? [0, 0] : [Infinity, -Infinity];
  const take = (value) => { if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); } };
  for (const line of panel.lines) {
    take(at(line, from)); take(at(line, to));
    for (let k = Math.max(0, last(line, from)); 2 * k < line.length && line[2 * k] <= to; k++) {
      if (line[2 * k] >= from) take(line[2 * k + 1]);
    }
  }
  if (!(low <= high)) return [-1, 1];
  const air = high > low ? (high - low) * 0.08 : Math.max(1, Math.abs(low)) * 0.5;
  return [low - air, high + air];
}

// 1, 2 or 5 times a power of ten, about an eighth of the length.
function step(length, count) {
  const ten = 10 ** Math.floor(Math.log10(length / count));
  return ten * [1, 2, 5, 10].find((n) => n * ten * count >= length);
}

function label(value, by) {
  return value.toFixed(Math.max(0, Math.min(9, Math.ceil(-Math.log10(by) - 1e-9))));
}

function draw(panel, canvas) {
  const scale = window.devicePixelRatio || 1;
  const [wide, tall] = [canvas.clientWidth, canvas.clientHeight];
  [canvas.width, canvas.height] = [wide * scale, tall * scale];
  const c = canvas.getContext("2d");
  c.scale(scale, scale);
  c.font = "12px sans-serif";
  const [low, high] = panel.lines ? range(panel) : [-5, 105];
  const x = (t) => LEFT + (t - from) / (to - from) * (wide - LEFT - RIGHT);
  const y = (v) => tall - FOOT - (v - low) / (high - low) * (tall - TOP - FOOT);
  c.strokeStyle = "#e4e8ec"; c.fillStyle = "#6e7781";
  const across = step(to - from, 10), up = step(high - low, panel.lines ? 5 : 2);
  c.textAlign = "center";
  for (let t = Math.ceil(from / across) * across; t <= to; t += across) {
    c.beginPath(); c.moveTo(x(t), TOP); c.lineTo(x(t), tall - FOOT); c.stroke();
    c.fillText(label(t, across), x(t), tall - 8);
  }
  c.textAlign = "right";
  c.fillText("ms", wide - 2, tall - 8);
  for (let v = Math.ceil(low / up) * up; v <= high; v += up) {
    c.beginPath(); c.moveTo(LEFT, y(v)); c.lineTo(wide - RIGHT, y(v)); c.stroke();
    c.fillText(label(v, up), LEFT - 6, y(v) + 4);
  }
  c.textAlign = "left"; c.fillStyle = panel.colour; c.strokeStyle = panel.colour;
  let shown = panel.caption;
  c.save(); c.beginPath(); c.rect(LEFT, 0, wide - LEFT - RIGHT, tall); c.clip();
  if (panel.lines) {
    for (const line of panel.lines) curve(c, line, x, y);
    const values = cursor === null ? [] : panel.lines.map((line) => at(line, cursor)).filter((v) => v !== null);
    if (values.length) shown += " = " + Number(values[0].toPrecision(9));
  } else if (panel.highs) {
    for (let k = Math.max(0, last(panel.highs, from)); 2 * k < panel.highs.length && panel.highs[2 * k] <= to; k++) {
      const [a, b] = [x(Math.max(from, panel.highs[2 * k])), x(Math.min(to, panel.highs[2 * k + 1]))];
      if (b >= a) c.fillRect(a, y(100), Math.max(0.5, b - a), y(0) - y(100));
    }
  } else {
    shown += ", share of time";
    const width = (data.to - data.from) / panel.shares.length;
    panel.shares.forEach((share, k) => {
      const a = data.from + width * k;
      if (share > 0 && a + width >= from && a <= to) c.fillRect(x(a), y(share), x(a + width) - x(a) + 0.5, y(0) - y(share));
    });
  }
  if (cursor !== null) {
    c.strokeStyle = "#6e7781"; c.beginPath(); c.moveTo(x(cursor), TOP); c.lineTo(x(cursor), tall - FOOT); c.stroke();
  }
  c.restore();
  c.fillText(shown, LEFT, 14);
  c.fillStyle = "#6e7781"; c.textAlign = "right";
  if (cursor !== null) c.fillText("t = " + label(cursor, (to - from) / 2000) + " ms", wide - RIGHT, 14);
}

// A line; where many points share a pixel, from the least to the greatest of them.
function curve(c, line, x, y) {
  c.lineWidth = 1.5; c.beginPath();
  let column = null, least = 0, most = 0, end = 0;
  const flush = () => { if (column !== null) { c.lineTo(column, y(least)); c.lineTo(column, y(most)); c.lineTo(column, y(end)); } };
  for (let k = Math.max(0, last(line, from)); 2 * k < line.length; k++) {
    const [t, v] = [line[2 * k], line[2 * k + 1]], here = Math.round(x(t) * 2) / 2;
    if (here === column) { least = Math.min(least, v); most = Math.max(most, v); end = v; continue; }
    flush();
    [column, least, most, end] = [here, v, v, v];
    if (t > to) break;
  }
  flush();
  c.stroke(); c.lineWidth = 1;
}

function all() { data.panels.forEach((panel, k) => draw(panel, canvases[k])); }

function show(a, b) {
  const whole = data.to - data.from, least = whole * 1e-9;
  const length = Math.min(whole, Math.max(least, b - a));
  from = Math.min(Math.max(a, data.from), data.to - length); to = from + length;
  all();
}

function zoom(t, by) { show(t - (t - from) * by, t + (to - t) * by); }

for (const canvas of canvases) {
  const time = (event) => from + (event.offsetX - LEFT) / (canvas.clientWidth - LEFT - RIGHT) * (to - from);
  let held = null;
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(time(event), event.deltaY > 0 ? 1.25 : 0.8); });
  canvas.addEventListener("pointerdown", (event) => { held = time(event); canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { held = null; });
  canvas.addEventListener("pointermove", (event) => {
    cursor = Math.min(to, Math.max(from, time(event)));
    if (held !== null) { const by = held - time(event); show(from + by, to + by); } else all();
  });
  canvas.addEventListener("pointerleave", () => { cursor = null; all(); });
  canvas.addEventListener("dblclick", () => show(data.from, data.to));
}
window.addEventListener("keydown", (event) => {
  const middle = (from + to) / 2, part = (to - from) / 10;
  const does = { "+": () => zoom(middle, 0.5), "-": () => zoom(middle, 2), "0": () => show(data.from, data.to),
    ArrowLeft: () => show(from - part, to - part), ArrowRight: () => show(from + part, to + part) }[event.key];
  if (does) { event.preventDefault(); does(); }
});
window.addEventListener("resize", all);
const svg = document.querySelector("#path svg");
if (svg) {
  let box = [0, 0, Number(svg.getAttribute("width")), Number(svg.getAttribute("height"))];
  const whole = box.slice();
  const put = () => svg.setAttribute("viewBox", box.join(" "));
  put();
  svg.addEventListener("wheel", (event) => {
    if (!event.shiftKey) return;
    event.preventDefault();
    const area = svg.getBoundingClientRect(), by = (event.deltaY || event.deltaX) > 0 ? 1.25 : 0.8;
    const [px, py] = [(event.clientX - area.left) / area.width, (event.clientY - area.top) / area.height];
    box = [box[0] + box[2] * px * (1 - by), box[1] + box[3] * py * (1 - by), box[2] * by, box[3] * by];
    put();
  });
  svg.addEventListener("dblclick", () => { box = whole.slice(); put(); });
}
all();
