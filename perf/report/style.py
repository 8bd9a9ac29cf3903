"""How pages and plots look, and how numbers are written."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

INK, MUTED, LINE, ACCENT = "#1c2430", "#5d6b7c", "#d9dfe7", "#1f6f8b"
PALETTE = ["#1f6f8b", "#d1792a", "#5a8f3d", "#a8436b", "#6a5aa8", "#8a6d3b", "#3c9d9b", "#7b8794"]
plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9, "axes.edgecolor": "#8793a3", "axes.labelcolor": INK,
    "axes.titlesize": 10, "axes.titleweight": "bold", "axes.titlelocation": "left", "axes.titlepad": 8,
    "text.color": INK, "xtick.color": MUTED, "ytick.color": MUTED, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.color": "#e9edf2", "grid.linewidth": 0.8,
    "axes.axisbelow": True, "lines.linewidth": 1.5, "legend.frameon": False, "legend.fontsize": 8,
    "axes.prop_cycle": matplotlib.cycler(color=PALETTE), "svg.hashsalt": "talus", "figure.dpi": 100,
    "axes.formatter.limits": (-3, 6),
})

STYLE = f"""
:root {{ color-scheme: light; }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: #fff; color: {INK}; font: 15px/1.55 system-ui, "Segoe UI", "Helvetica Neue", "DejaVu Sans", sans-serif; }}
main {{ max-width: 1180px; margin: 0 auto; padding: 40px 28px 64px; }}
h1 {{ font-size: 30px; line-height: 1.2; margin: 0 0 6px; letter-spacing: -0.01em; }}
h2 {{ font-size: 19px; margin: 44px 0 14px; padding-top: 14px; border-top: 1px solid {LINE}; }}
p.lead {{ color: {MUTED}; margin: 0 0 24px; }}
.cards {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(165px, 1fr)); gap: 1px; border: 1px solid {LINE}; border-radius: 6px; overflow: hidden; }}
.cards div {{ box-shadow: 0 0 0 1px {LINE}; padding: 12px 14px; }}
.cards dt {{ color: {MUTED}; font-size: 12px; }}
.cards dd {{ margin: 1px 0 0; font-size: 18px; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }}
.cards dd.small {{ font-size: 14px; line-height: 1.45; padding-top: 3px; }}
.grid {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(430px, 1fr)); gap: 22px 26px; align-items: start; }}
.pictures {{ display: grid; grid-template-columns: repeat(3, 1fr); gap: 18px; align-items: end; margin-top: 18px; }}
figure {{ margin: 0; }}
img {{ max-width: 100%; height: auto; display: block; }}
.grid img, img.wide {{ width: 100%; }}
figcaption {{ color: {MUTED}; font-size: 13px; margin-top: 6px; text-align: center; }}
.pictures img {{ margin: 0 auto; }}
.bar {{ margin: 18px auto 0; max-width: 420px; }}
.note {{ background: #fdf6e7; border-left: 3px solid #d9a441; padding: 8px 14px; margin: 0 0 18px; font-size: 14px; }}
.bad {{ background: #fcebea; border-color: #c0392b; }}
.hint {{ color: {MUTED}; font-size: 13px; margin: -6px 0 14px; }}
.warnings ul {{ margin: 4px 0 0; padding-left: 20px; }}
.often {{ color: {MUTED}; }}
details {{ margin: 22px 0 0; }}
.scroll {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 14px; }}
td, th {{ text-align: left; padding: 5px 22px 5px 0; border-bottom: 1px solid {LINE}; vertical-align: top; }}
td.number, th.number {{ text-align: right; font-variant-numeric: tabular-nums; }}
pre {{ background: #f6f8fa; border: 1px solid {LINE}; border-radius: 6px; padding: 14px 16px; overflow-x: auto; font: 12.5px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }}
summary {{ cursor: pointer; color: {ACCENT}; }}
.plot {{ position: relative; }}
.plot canvas {{ position: absolute; inset: 0; width: 100%; height: 100%; cursor: crosshair; touch-action: pan-y; }}
.plot .values, .view .values {{ position: absolute; display: none; pointer-events: none; z-index: 2; background: #fffffff2; border: 1px solid {LINE};
  border-radius: 4px; padding: 4px 8px; font-size: 12px; line-height: 1.4; white-space: pre; font-variant-numeric: tabular-nums; }}
.view {{ position: relative; border: 1px solid {LINE}; border-radius: 6px; overflow: hidden; }}
.view canvas {{ display: block; width: 100%; height: 560px; cursor: grab; touch-action: none; }}
.view .controls {{ display: flex; gap: 18px; flex-wrap: wrap; align-items: center; padding: 8px 14px; border-top: 1px solid {LINE}; font-size: 13px; color: {MUTED}; }}
.view .scale {{ display: inline-block; width: 150px; height: 10px; vertical-align: middle; }}
@media print {{ main {{ padding: 0; }} figure {{ break-inside: avoid; }} }}
"""


def grouped(n):
    return f"{n:,}".replace(",", "\u202f")


def seconds(s):
    if s < 120:
        return f"{s:.3g} s"
    minutes, rest = divmod(int(round(s)), 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min {rest:02d} s"


def size_text(n):
    for unit in ("B", "KiB", "MiB", "GiB"):
        if n < 1024 or unit == "GiB":
            return f"{n:.0f} {unit}" if unit == "B" else f"{n:.1f} {unit}"
        n /= 1024
    return ""
