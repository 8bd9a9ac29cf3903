// The 3-D view: every grain a quad with the sphere drawn into it, depth included, so that spheres cut each other and the
// walls as they should. Orthographic, as the pictures are. Data: base64 of little-endian arrays, made by view.py.
"use strict";
for (const box of document.querySelectorAll(".view")) {
  const data = JSON.parse(box.querySelector("script[type='application/json']").textContent);
  const canvas = box.querySelector("canvas"), tip = box.querySelector(".values"), choice = box.querySelector("select");
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { box.querySelector(".none").hidden = false; canvas.hidden = true; continue; }
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
  const packed = new Uint16Array(bytes(data.grains)), lines = new Float32Array(bytes(data.lines)), n = data.count;
  const ids = new Uint32Array(bytes(data.ids)), columns = data.columns.map(c => new Uint16Array(bytes(c.values)));

  const grains = Float32Array.from(packed, (v, k) => k % 4 === 3 ? v / 65535 * data.largest : (v / 65535 * 2 - 1) * data.span);
  let level = Infinity;  // grains beyond it along data.cut are cut away

  function program(vertex, fragment) {
    const p = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const s = gl.createShader(kind);
      gl.shaderSource(s, "#version 300 es\nprecision highp float;\n" + text);
      gl.compileShader(s);
      if (!gl.getShaderParameter(s, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(s));
      gl.attachShader(p, s);
    }
    gl.linkProgram(p);
    return new Proxy({ p }, { get: (t, name) => name === "p" ? p : gl.getUniformLocation(p, name) });
  }
  // `turn` takes positions to the view (right, up, towards the viewer); `half`: half the width and height that are seen.
  const spheres = program(`
    layout(location=0) in vec2 corner; layout(location=1) in vec4 grain; layout(location=2) in float value; layout(location=3) in vec3 given;
    uniform mat3 turn; uniform vec2 half_size, shift; uniform float reach; uniform sampler2D scale; uniform vec4 cut; uniform float gain;
    out vec2 at; out vec3 colour; out float depth, radius; out float gone; out vec3 facing;
    void main() {
      vec3 p = turn * grain.xyz;
      at = corner; radius = grain.w; depth = p.z; facing = turn * given;
      colour = texture(scale, vec2(min(value * gain, 1.0), 0.5)).rgb;
      gone = dot(cut.xyz, grain.xyz) > cut.w ? 1.0 : 0.0;
      gl_Position = vec4((p.xy + shift + 1.02 * radius * corner) / half_size, 0.0, 1.0);
    }`, `
    in vec2 at; in vec3 colour; in float depth, radius, gone; in vec3 facing; uniform float reach; out vec4 pixel;
    void main() {
      float rim = 1.0 - dot(at, at) * 1.0404;
      if (rim <= 0.0 || gone > 0.5) discard;
      vec3 normal = vec3(1.02 * at, sqrt(rim));
      gl_FragDepth = 0.5 - 0.5 * (depth + radius * normal.z) / reach;
      if (dot(facing, facing) > 0.25) {  // a piece of a superquadric's surface; none of its far side
        normal = normalize(facing);
        if (normal.z < -0.1) discard;
      }
      float light = max(dot(normal, normalize(vec3(-0.35, 0.55, 0.76))), 0.0);
      pixel = vec4(colour * (0.42 + 0.62 * light) * (0.72 + 0.28 * smoothstep(0.0, 0.55, abs(normal.z))), 1.0);
    }`);
  const edges = program(`
    layout(location=0) in vec3 at; uniform mat3 turn; uniform vec2 half_size, shift; uniform float reach;
    void main() { vec3 p = turn * at; gl_Position = vec4((p.xy + shift) / half_size, -p.z / reach, 1.0); }`, `
    out vec4 pixel; void main() { pixel = vec4(0.2, 0.28, 0.37, 0.55); }`);

  function buffer(array) {
    const b = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, b);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    return b;
  }
  function attribute(at, b, size, type, normalised, each) {
    gl.bindBuffer(gl.ARRAY_BUFFER, b);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, type, normalised, 0, 0);
    gl.vertexAttribDivisor(at, each);
  }
  const quads = gl.createVertexArray(), wires = gl.createVertexArray(), values = columns.map(buffer);
  gl.bindVertexArray(quads);
  attribute(0, buffer(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1])), 2, gl.FLOAT, false, 0);
  attribute(1, buffer(grains), 4, gl.FLOAT, false, 1);
  if (data.normals) attribute(3, buffer(new Int8Array(bytes(data.normals))), 3, gl.BYTE, true, 1);
  gl.bindVertexArray(wires);
  attribute(0, buffer(lines), 3, gl.FLOAT, false, 0);
  const colours = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, colours);
  for (const [key, to] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
    [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, to);

  const first = { azimuth: data.azimuth, elevation: data.elevation, zoom: 1, shift: [0, 0] };
  let eye = structuredClone(first), chosen = 0, turn = [], half = [1, 1];
  function paint() {
    const scale = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = Math.round(w * scale);
    canvas.height = Math.round(h * scale);
    const a = eye.azimuth * Math.PI / 180, e = eye.elevation * Math.PI / 180;
    const right = [Math.cos(a), Math.sin(a), 0], out = [Math.sin(a) * Math.cos(e), -Math.cos(a) * Math.cos(e), Math.sin(e)];
    const up = [out[1] * right[2] - out[2] * right[1], out[2] * right[0] - out[0] * right[2], out[0] * right[1] - out[1] * right[0]];
    turn = [right, up, out];
    const unit = Math.max(data.fit[1], data.fit[0] * h / w) / eye.zoom;  // all is seen at zoom 1
    half = [unit * w / h, unit];
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const set = p => {
      gl.useProgram(p.p);
      gl.uniformMatrix3fv(p.turn, false, [0, 1, 2].flatMap(k => turn.map(row => row[k])));
      gl.uniform2f(p.half_size, ...half);
      gl.uniform2f(p.shift, ...eye.shift);
      gl.uniform1f(p.reach, data.reach);
    };
    gl.disable(gl.BLEND);
    gl.bindVertexArray(quads);
    attribute(2, values[chosen], 1, gl.UNSIGNED_SHORT, true, 1);
    set(spheres);
    const depth = box.querySelector(".cut").value / 1000;  // 1: nothing is cut away
    level = depth < 1 ? data.near[0] + (data.near[1] - data.near[0]) * depth : 1e30;
    gl.uniform4f(spheres.cut, ...data.cut, level);
    gl.uniform1f(spheres.gain, data.columns[chosen].gain);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, n);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(wires);
    set(edges);
    gl.drawArrays(gl.LINES, 0, lines.length / 3);
    box.dataset.drawn = `${n} grains, ${lines.length / 6} lines, by ${data.columns[chosen].name}, error ${gl.getError()}`;
  }
  function show(k) {
    chosen = k;
    const c = data.columns[k], map = new Uint8Array(bytes(c.colours));
    gl.bindTexture(gl.TEXTURE_2D, colours);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, map.length / 3, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, map);
    const stops = [];
    for (let i = 0; i < map.length; i += 3) stops.push(`rgb(${map[i]},${map[i + 1]},${map[i + 2]})`);
    box.querySelector(".scale").style.background = c.names ? "none" : `linear-gradient(90deg, ${stops.join(",")})`;
    box.querySelector(".low").textContent = c.names ? "" : +c.low.toPrecision(4);
    box.querySelector(".high").textContent = c.names ? c.names.join(", ") : +c.top.toPrecision(4) + (c.unit ? " " + c.unit : "");
    paint();
  }
  function shown(c, k, i) {
    if (c.names) return c.names[Math.round(columns[k][i] / 65535 * 255)] ?? "?";
    return +(c.low + (c.high - c.low) * columns[k][i] / 65535).toPrecision(4) + (c.unit ? " " + c.unit : "");
  }
  function under(e) {  // the foremost grain below the pointer
    const r = canvas.getBoundingClientRect();
    const x = (2 * (e.clientX - r.left) / r.width - 1) * half[0] - eye.shift[0], y = (1 - 2 * (e.clientY - r.top) / r.height) * half[1] - eye.shift[1];
    let best = -1, depth = -Infinity;
    for (let i = 0; i < n; ++i) {
      const [gx, gy, gz, gr] = grains.subarray(4 * i, 4 * i + 4);
      if (data.cut[0] * gx + data.cut[1] * gy + data.cut[2] * gz > level) continue;
      const p = turn.map(t => t[0] * gx + t[1] * gy + t[2] * gz);
      const rim = gr * gr - (p[0] - x) ** 2 - (p[1] - y) ** 2;
      if (rim > 0 && p[2] + Math.sqrt(rim) > depth) { depth = p[2] + Math.sqrt(rim); best = i; }
    }
    tip.style.display = best < 0 ? "none" : "block";
    if (best < 0) return;
    tip.textContent = [`grain ${ids[best]}`, ...data.columns.map((c, k) => `${c.name}: ${shown(c, k, best)}`)].join("\n");
    tip.style.left = e.clientX - r.left + 14 + "px";
    tip.style.top = e.clientY - r.top + 10 + "px";
  }
  const pointers = new Map();
  canvas.addEventListener("contextmenu", e => e.preventDefault());
  canvas.addEventListener("pointerdown", e => { pointers.set(e.pointerId, e); canvas.setPointerCapture(e.pointerId); tip.style.display = "none"; });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, e => pointers.delete(e.pointerId));
  canvas.addEventListener("pointerleave", () => { tip.style.display = "none"; });
  canvas.addEventListener("pointermove", e => {
    const before = pointers.get(e.pointerId);
    if (!before) { if (e.pointerType === "mouse") requestAnimationFrame(() => under(e)); return; }
    const dx = e.clientX - before.clientX, dy = e.clientY - before.clientY;
    if (pointers.size === 2) {  // two fingers: their distance is the zoom
      const other = [...pointers.values()].find(q => q.pointerId !== e.pointerId), apart = q => Math.hypot(q.clientX - other.clientX, q.clientY - other.clientY);
      eye.zoom *= apart(e) / Math.max(apart(before), 1);
    } else if (e.shiftKey || e.buttons & 6) {
      eye.shift[0] += 2 * dx / canvas.clientWidth * half[0];
      eye.shift[1] -= 2 * dy / canvas.clientHeight * half[1];
    } else {
      eye.azimuth -= 0.4 * dx;
      eye.elevation = Math.max(-90, Math.min(90, eye.elevation + 0.4 * dy));
    }
    pointers.set(e.pointerId, e);
    requestAnimationFrame(paint);
  });
  canvas.addEventListener("wheel", e => { e.preventDefault(); eye.zoom = Math.min(200, Math.max(0.2, eye.zoom * 2 ** (-e.deltaY / 400))); requestAnimationFrame(paint); }, { passive: false });
  canvas.addEventListener("dblclick", () => { eye = structuredClone(first); paint(); });
  choice.addEventListener("change", () => show(choice.selectedIndex));
  box.querySelector(".cut").addEventListener("input", () => requestAnimationFrame(paint));
  new ResizeObserver(() => requestAnimationFrame(paint)).observe(canvas);
  show(0);
}
