#!/usr/bin/env python3
"""Asked against measured descriptors of grains made to measure; exit code 1 where a family is off.

usage: compare.py FOLDER   (with made/shapes/statistics.csv, scans.out/shapes/shapes.csv, scene.toml)

D is the Kolmogorov-Smirnov distance of two samples, measured values and the targets that were drawn for
them: what the search adds. Its 95 % bound for n and n values is 1.358 sqrt(2/n). Beside it D of measured values and of
targets against the wanted normal distribution, bound 1.358/sqrt(n), or against the folder's m grains, bound
1.358 sqrt((n + m)/(n m)): what chance does to few grains is in both.
"""

import csv
import math
import re
import sys
import tomllib

NAMES = ["elongation", "flatness", "sphericity", "roundness", "convexity"]
LIMITS = {"elongation": (0.2, 1), "flatness": (0.2, 1), "sphericity": (0.4, 1), "roundness": (0.1, 1), "convexity": (0.5, 1)}
# Largest median miss of a grain that is right: two tolerances of the search.
MISS = {"elongation": 0.02, "flatness": 0.02, "sphericity": 0.015, "roundness": 0.04, "convexity": 0.015}


def one_sample(values, mean, deviation, limits):
    def wanted(x):
        return 1.0 if x >= limits[1] else 0.5 * (1 + math.erf((x - mean) / deviation / math.sqrt(2)))
    values, n = sorted(values), len(values)
    return max(max(abs((i + 1) / n - wanted(v)), abs(i / n - wanted(v))) for i, v in enumerate(values)), 1.358 / math.sqrt(n)


def two_samples(a, b):
    share = lambda values, x: sum(v <= x for v in values) / len(values)
    d = max(abs(share(a, x) - share(b, x)) for x in a + b)
    return d, 1.358 * math.sqrt((len(a) + len(b)) / (len(a) * len(b)))


def main():
    folder = sys.argv[1]
    scene = tomllib.load(open(f"{folder}/scene.toml", "rb"))
    wanted = {g["name"]: g["shape"]["tailored"] for g in scene["grains"]}
    rows = {}
    for row in csv.DictReader(open(f"{folder}/made/shapes/statistics.csv")):
        family = re.sub(r"-\d+$", "", row["name"])
        asked = float(row["asked"]) if row["asked"] else None
        rows.setdefault((family, row["quantity"]), []).append((asked, float(row["measured"])))
    scans = list(csv.DictReader(open(f"{folder}/scans.out/shapes/shapes.csv")))
    column = lambda name: next(k for k in scans[0] if k.split(" ")[0] in (name, f"wadell_{name}"))
    bad = 0
    print(f"{'family':12} {'descriptor':12} {'n':>4} {'asked':>7} {'is':>7} {'median miss':>11} {'D':>6} {'95 %':>6} {'D wanted':>9} {'of targets':>10} {'95 %':>6}")
    for family in wanted:
        for name in NAMES:
            pairs = [p for p in rows.get((family, name), []) if p[0] is not None]
            if not pairs:
                continue
            asked, measured = [a for a, _ in pairs], [m for _, m in pairs]
            misses = sorted(abs(m - a) for a, m in pairs)
            miss = misses[len(misses) // 2]
            if name in wanted[family]:
                against = lambda values: one_sample(values, *wanted[family][name], LIMITS[name])
            else:
                against = lambda values: two_samples(values, [float(r[column(name)]) for r in scans])
            d, bound = two_samples(measured, asked)
            whole, limit = against(measured)
            off = miss > MISS[name] or d > bound
            bad += off
            mean = lambda values: sum(values) / len(values)
            print(f"{family:12} {name:12} {len(pairs):4} {mean(asked):7.3f} {mean(measured):7.3f} {miss:11.4f} {d:6.3f} "
                  f"{bound:6.3f} {whole:9.3f} {against(asked)[0]:10.3f} {limit:6.3f}{'  OFF' if off else ''}")
    asked = sum(1 for family in wanted for _ in (NAMES if "like" in wanted[family] else wanted[family]))
    print(f"{asked} distributions asked for, {bad} off")
    return int(bad > 0 or asked != 15)


sys.exit(main())
