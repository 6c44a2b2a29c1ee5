#!/usr/bin/env python3
"""Statistics of rough surfaces, asked for against measured: mean over the surfaces with its standard error.

usage: compare.py STATISTICS.csv

Exit code 1 where a mean is off by more than its tolerance and three standard errors together.
"""

import csv
import re
import sys

# Share of what was asked (skewness: absolute) by which a mean may be off: what is known of finite surfaces.
TOLERANCE = {"rms height": 0.03, "skewness": 0.1, "kurtosis": 0.06, "length": 0.15, "arc": 0.15, "fractal dimension": 0.06}


def main():
    rows = {}
    for row in csv.DictReader(open(sys.argv[1])):
        family = re.sub(r"-\d+$", "", row["name"])
        if row["measured"]:
            asked = float(row["asked"]) if row["asked"] else None
            rows.setdefault((family, row["quantity"]), []).append((asked, float(row["measured"])))
    bad = judged = 0
    print(f"{'surface':22} {'statistic':44} {'n':>3} {'asked':>8} {'mean':>8} {'± s.e.':>7}")
    for (family, quantity), pairs in rows.items():
        key = next((k for k in TOLERANCE if k in quantity), None)
        if key is None:
            continue
        values = [m for _, m in pairs]
        n, mean = len(values), sum(values) / len(values)
        error = (sum((v - mean) ** 2 for v in values) / max(n - 1, 1) / n) ** 0.5
        asked = pairs[0][0]
        off = ""
        if asked is not None:
            judged += 1
            allowed = TOLERANCE[key] * (1 if key == "skewness" else abs(asked)) + 3 * error
            off = "  OFF" if abs(mean - asked) > allowed else ""
            bad += bool(off)
        print(f"{family:22} {quantity:44} {n:3} {asked if asked is not None else '':>8} {mean:8.4f} {error:7.4f}{off}")
    print(f"{judged} means judged, {bad} off")
    return int(bad > 0 or judged < 30)


sys.exit(main())
