// Zoom and values of the plots: hover reads values off, a drag zooms, a double click goes back. The image below is the
// whole plot, so that the page is complete without this script.
"use strict";
for (const figure of document.querySelectorAll("figure.plot")) {
  const p = JSON.parse(figure.dataset.numbers), [left, top, right, bottom] = p.box;
  const canvas = document.createElement("canvas"), tip = document.createElement("div"), pen = canvas.getContext("2d");
  tip.className = "values";
  figure.append(canvas, tip);
  let view = { x: p.x, y: p.y }, zoomed = false, start = null, now = null;
  let w = 1, h = 1;
  const text = v => v === null ? "–" : String(+v.toPrecision(5));
  const px = x => w * (left + (right - left) * (x - view.x[0]) / (view.x[1] - view.x[0]));
  const py = y => h * (bottom - (bottom - top) * (y - view.y[0]) / (view.y[1] - view.y[0]));
  const ux = u => view.x[0] + (view.x[1] - view.x[0]) * (u / w - left) / (right - left);
  const uy = v => view.y[0] + (view.y[1] - view.y[0]) * (bottom - v / h) / (bottom - top);

  function ticks(low, high) {
    const raw = (high - low) / 5, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find(f => f * power >= raw);
    const list = [];
    for (let k = Math.ceil(low / step); k * step <= high; ++k) list.push(k * step);
    return list;
  }
  function axes() {  // of the zoomed plot, over the image
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, w, h);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = "#5d6b7c";
    pen.strokeStyle = "#e9edf2";
    pen.textAlign = "center";
    pen.textBaseline = "top";
    const line = (...at) => { pen.beginPath(); pen.moveTo(at[0], at[1]); pen.lineTo(at[2], at[3]); pen.stroke(); };
    for (const t of ticks(...view.x)) { line(px(t), top * h, px(t), bottom * h); pen.fillText(text(t), px(t), bottom * h + 5); }
    pen.fillText(p.xlabel, w * (left + right) / 2, bottom * h + 19);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const t of ticks(...view.y)) { line(left * w, py(t), right * w, py(t)); pen.fillText(text(t), left * w - 5, py(t)); }
    pen.strokeStyle = "#8793a3";
    line(left * w, top * h, left * w, bottom * h);
    line(left * w, bottom * h, right * w, bottom * h);
    pen.textAlign = "left";
    pen.textBaseline = "bottom";
    pen.fillText(p.ylabel + " – double click: the whole plot", left * w, top * h - 3);
  }
  function curves() {
    pen.save();
    pen.beginPath();
    pen.rect(left * w, top * h, (right - left) * w, (bottom - top) * h);
    pen.clip();
    pen.lineWidth = 1.6;
    for (const c of p.curves) {
      pen.strokeStyle = c.colour;
      pen.beginPath();
      let before = null;
      c.values.forEach((v, k) => {
        if (v === null) { before = null; return; }
        if (before === null) pen.moveTo(px(p.at[k]), py(v));
        else { if (p.step) pen.lineTo(px(p.at[k - 1]), py(v)); pen.lineTo(px(p.at[k]), py(v)); }
        before = v;
      });
      pen.stroke();
    }
    pen.restore();
  }
  function nearest(x) {
    let best = 0;
    p.at.forEach((a, k) => { if (Math.abs(a - x) < Math.abs(p.at[best] - x)) best = k; });
    return best;
  }
  function values(k) {
    pen.strokeStyle = "#8793a3";
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(px(p.at[k]), top * h);
    pen.lineTo(px(p.at[k]), bottom * h);
    pen.stroke();
    for (const c of p.curves) {
      const v = c.values[k];
      if (v === null || v < view.y[0] || v > view.y[1]) continue;
      pen.fillStyle = c.colour;
      pen.beginPath();
      pen.arc(px(p.at[k]), py(v), 3.5, 0, 7);
      pen.fill();
    }
    tip.textContent = `${p.xlabel}: ${text(p.at[k])}\n` + p.curves.map(c => `${c.label}: ${text(c.values[k])}`).join("\n");
    tip.style.display = "block";
    const to_left = px(p.at[k]) > w / 2;
    tip.style.left = to_left ? "" : px(p.at[k]) + 10 + "px";
    tip.style.right = to_left ? w - px(p.at[k]) + 10 + "px" : "";
    tip.style.top = top * h + 6 + "px";
  }
  function draw() {
    const scale = window.devicePixelRatio || 1;
    w = canvas.clientWidth;
    h = canvas.clientHeight;
    canvas.width = Math.round(w * scale);
    canvas.height = Math.round(h * scale);
    pen.scale(scale, scale);
    if (zoomed) { axes(); curves(); }
    tip.style.display = "none";
    if (start && now) {
      pen.fillStyle = "#1f6f8b22";
      pen.fillRect(start[0], top * h, now[0] - start[0], (bottom - top) * h);
    } else if (now && now[0] >= left * w - 2 && now[0] <= right * w + 2) {
      values(nearest(ux(now[0])));
    }
    figure.dataset.range = view.x.concat(view.y).map(text).join(" ");
  }
  function fit(x0, x1) {  // y follows what lies between
    const seen = p.curves.flatMap(c => c.values.filter((v, k) => v !== null && p.at[k] >= x0 && p.at[k] <= x1));
    if (seen.length < 2) return;
    const low = Math.min(...seen), high = Math.max(...seen), margin = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1;
    view = { x: [x0, x1], y: [low - margin, high + margin] };
    zoomed = true;
  }
  const at = e => { const r = canvas.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
  canvas.addEventListener("pointermove", e => { now = at(e); draw(); });
  canvas.addEventListener("pointerleave", () => { now = null; if (!start) draw(); });
  canvas.addEventListener("pointerdown", e => { start = now = at(e); canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointerup", e => {
    now = at(e);
    if (start && Math.abs(now[0] - start[0]) > 8) fit(...[ux(start[0]), ux(now[0])].sort((a, b) => a - b));
    start = null;
    draw();
  });
  canvas.addEventListener("dblclick", () => { view = { x: p.x, y: p.y }; zoomed = false; draw(); });
}
