"""What the measured rows say: orders, claims that have to hold, the Pareto front, the cheapest settings.

Who calls it: error_time.py and page.py. Pure functions of rows (one dict per setting, error_time.FIELDS).
"""
import math

import numpy as np

from .scene import DEFAULT, INEXACT, LISTS

TOLERANCES = (1e-2, 1e-3, 1e-4)


def order(rows):
    """Slope of ln error over ln dt, or None: over the points that are resolved (error above three half widths)."""
    use = [r for r in rows if r["error"] and r["error"] > 3 * r["error_half_width"] and r["error"] < 0.3]
    if len({r["dt"] for r in use}) < 2:
        return None
    return float(np.polyfit(np.log([r["dt"] for r in use]), np.log([r["error"] for r in use]), 1)[0])


def claims(scene, settings, rows):
    """What has to hold; returns the sentences that do not, and what was found to hold."""
    wrong, held = [], []
    by_label = {r["label"]: r for r in rows}
    same = [(s, by_label[s.label], by_label[s.same_bits_as]) for s in settings if s.same_bits_as]
    for s, row, base in same:
        if row["stopped"] or row["state_hash"] != base["state_hash"] or row["error"] != base["error"]:
            wrong.append(f"{scene.name}, {s.label}: not the bits of {base['label']} ({row['state_hash']}, {base['state_hash']})")
    if same and not wrong:
        held.append(f"{len(same)} runs with other list policies, K and instruction sets: state hash {same[0][2]['state_hash']} "
                    "and error equal to the last bit")
    audited = [r for r in rows if r["missed_contacts"] is not None and r["code"] == "talus" and r["family"] != INEXACT]
    missed = sum(r["missed_contacts"] for r in audited)
    if missed:
        wrong.append(f"{scene.name}: {missed} missed contacts")
    held.append(f"{missed} missed contacts in {sum(r['audited_steps'] for r in audited)} steps of {len(audited)} Talus runs "
                "compared with brute force")
    if scene.kind == "exact":
        default = sorted((r for r in rows if r["family"] == DEFAULT), key=lambda r: -r["dt"])
        slope = order(default)
        if default[-1]["error"] > 1e-2 or slope is None or slope < 0.7:
            wrong.append(f"{scene.name}: no convergence to the closed form: error {default[-1]['error']:.2e} at the finest step, "
                         f"order {slope}")
        else:
            held.append(f"converges to the closed form: order {slope:.2f}, error {default[-1]['error']:.1e} at the finest step")
    return wrong, held


def pareto(rows):
    """Rows that no other row beats in both run time and error."""
    front, best = [], math.inf
    for r in sorted((r for r in rows if r["error"] is not None), key=lambda r: (r["wall_s"], r["error"])):
        if r["error"] < best:
            front.append(r)
            best = r["error"]
    return front


def advice(rows):
    """[(tolerance, cheapest row of all or None, cheapest Talus row or None)]; an error counts with its half width."""
    out = []
    for tolerance in TOLERANCES:
        # a list or an instruction set changes the time only: which one is fastest is said apart
        good = [r for r in rows if r["error"] is not None and r["family"] != LISTS
                and r["error"] + r["error_half_width"] <= tolerance]
        out.append((tolerance, cheapest(good), cheapest([r for r in good if r["code"] == "talus"])))
    return out


def summary(rows):
    """[(tolerance, {code: cheapest row or None})] of the codes that were run; an error counts with its half width."""
    codes = [c for c in ("talus", "lammps", "liggghts") if any(r["code"] == c for r in rows)]
    out = []
    for tolerance in TOLERANCES:
        good = [r for r in rows if r["error"] is not None and r["family"] != LISTS and r["error"] + r["error_half_width"] <= tolerance]
        out.append((tolerance, {c: cheapest([r for r in good if r["code"] == c]) for c in codes}))
    return out


def summary_table(results):
    """The summary of all scenes as Markdown: Talus, then the other codes with their run time over that of Talus."""
    def cell(best):
        ours, out = best.get("talus"), []
        for code, row in best.items():
            name = {"talus": "Talus", "lammps": "LAMMPS", "liggghts": "LIGGGHTS"}[code]
            if row is None:
                out.append(f"{name}: none")
            elif row is ours:
                out.append(f"{name}: {row['label']}, {row['wall_s']:.3g} s")
            else:
                ratio = f" ({row['wall_s'] / ours['wall_s']:.2g} x)" if ours else ""
                out.append(f"{name}: dt {row['steps_per_contact']:g}, {row['wall_s']:.3g} s{ratio}")
        return "; ".join(out)

    lines = ["| scene | " + " | ".join(f"{100 * t:g} %" for t in TOLERANCES) + " |", "|---" * (1 + len(TOLERANCES)) + "|"]
    for r in results:
        lines.append(f"| {r['title']} | " + " | ".join(cell(best) for _, best in summary(r["rows"])) + " |")
    return "\n".join(lines) + "\n"


def cheapest(rows):
    """The fastest row; but the default setting where the clock does not tell it from that one (ranges overlap)."""
    best = min(rows, key=lambda r: r["wall_s"], default=None)
    if best is None:
        return None
    alike = [r for r in rows if r["family"] == DEFAULT and r["wall_low_s"] <= best["wall_high_s"]]
    return min(alike, key=lambda r: r["wall_s"], default=best)


def statistics(rows, seeds):
    """For scenes judged by averages: what the seeds can tell. A sentence, or None without statistics."""
    measured = [r for r in rows if r["error"] is not None and r["family"] != LISTS and math.isfinite(r["error_half_width"])]
    if seeds < 2 or not measured:
        return None
    alike = cheapest([r for r in measured if r["error"] <= r["error_half_width"]])
    differ = [r["label"] for r in measured if r["error"] > r["error_half_width"]]
    typical = float(np.median([r["error_half_width"] for r in measured]))
    text = f"{seeds} seeds leave an interval of +/- {100 * typical:.2g} % (median over the settings)"
    if typical > TOLERANCES[0]:
        # the interval falls with the root of the number, the factor of Student's t with few seeds falls too and is left out
        text += f"; an interval of 1 % would take some {math.ceil(seeds * (typical / TOLERANCES[0]) ** 2)} seeds"
    text += f". Cheapest setting that they do not tell from the reference: {describe(alike)}"
    return text + (f". Told from it: {', '.join(differ)}." if differ else ". None is told from it.")


def describe(row):
    if row is None:
        return "none of these settings"
    half = f" +/- {100 * row['error_half_width']:.2g}" if row["error_half_width"] else ""
    return (f"{row['code']}, {row['label'] if row['code'] == 'talus' else 'dt ' + format(row['steps_per_contact'], 'g')} "
            f"({row['wall_s']:.3g} s, error {100 * row['error']:.2g}{half} %)")
