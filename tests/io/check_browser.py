"""Opens a report page in a headless Chromium, uses it, and says what it then shows. usage: check_browser.py FILE [TEXT ...]

Texts are looked for in what the page says afterwards. Exit 77 where there is no Chromium. --screenshot FILE.png WIDTH HEIGHT
first: a picture of the page instead.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

USE = """<script>
window.addEventListener("error", e => { document.body.dataset.error = e.message; });
setTimeout(() => {
  const fire = (node, kind, x, y, more) => {
    const r = node.getBoundingClientRect();
    node.dispatchEvent(new PointerEvent(kind, { clientX: r.left + x * r.width, clientY: r.top + y * r.height, pointerId: 1, pointerType: "mouse", bubbles: true, ...more }));
  };
  HTMLCanvasElement.prototype.setPointerCapture = () => {};
  const said = [];
  for (const plot of document.querySelectorAll("figure.plot")) {
    const canvas = plot.querySelector("canvas"), tip = plot.querySelector(".values");
    fire(canvas, "pointermove", 0.5, 0.5);
    said.push("value " + tip.textContent.replaceAll("\\n", "; "));
    const before = plot.dataset.range;
    for (const [kind, x] of [["pointerdown", 0.3], ["pointermove", 0.5], ["pointerup", 0.7]]) fire(canvas, kind, x, 0.5);
    said.push(before !== plot.dataset.range ? "zoomed" : "not zoomed");
    canvas.dispatchEvent(new MouseEvent("dblclick"));
    said.push(before === plot.dataset.range ? "back" : "not back");
  }
  for (const view of document.querySelectorAll(".view")) {
    const canvas = view.querySelector("canvas"), choice = view.querySelector("select");
    const colours = () => {
      const gl = canvas.getContext("webgl2"), w = canvas.width, h = canvas.height, all = new Uint8Array(4 * w * h), seen = new Set();
      gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
      let drawn = 0;
      for (let k = 0; k < all.length; k += 4) if (all[k] + all[k + 1] + all[k + 2] < 700) { ++drawn; seen.add(all[k] << 16 | all[k + 1] << 8 | all[k + 2]); }
      return [drawn, seen.size];
    };
    said.push("view " + view.dataset.drawn);
    const [drawn, shades] = colours();
    said.push(drawn > 500 && shades > 20 ? "spheres are drawn" : `only ${drawn} pixels of ${shades} shades`);
    choice.selectedIndex = 1;
    choice.dispatchEvent(new Event("change"));
    said.push("view " + view.dataset.drawn);
    for (const [kind, x] of [["pointerdown", 0.4], ["pointermove", 0.6], ["pointerup", 0.6]]) fire(canvas, kind, x, 0.5, { buttons: 1 });
  }
  document.body.dataset.said = said.join(" | ");
}, 300);
</script>"""


def browser(*words):
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        sys.exit(77)
    with tempfile.TemporaryDirectory() as home:
        command = [program, "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                   "--disable-extensions", "--no-first-run", f"--user-data-dir={home}", "--virtual-time-budget=5000", *words]
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=280, check=True,
                              env={**os.environ, "HOME": home}).stdout


def main():
    words = sys.argv[1:]
    if words[0] == "--screenshot":
        page, target, width, height = words[4], words[1], words[2], words[3]
        browser(f"--window-size={width},{height}", f"--screenshot={os.path.abspath(target)}", "file://" + os.path.abspath(page))
        return
    with open(words[0], encoding="utf-8") as f:
        text = f.read()
    with tempfile.NamedTemporaryFile("w", suffix=".html", encoding="utf-8") as f:
        f.write(text.replace("</body>", USE + "</body>"))
        f.flush()
        after = browser("--window-size=1200,900", "--dump-dom", "file://" + f.name)
    error, said = re.search(r'data-error="([^"]*)"', after), re.search(r'data-said="([^"]*)"', after)
    print(said.group(1) if said else "the page was not used")
    assert error is None, error.group(1)
    assert said and "not zoomed" not in said.group(1) and "not back" not in said.group(1)
    for wanted in words[1:]:
        assert wanted in said.group(1), wanted


main()
