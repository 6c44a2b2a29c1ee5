#!/usr/bin/env python3
"""One table and one chart of all clumps; exit code 1 where a peer is nearer than `fitted`.

usage: table.py RIPRAP PEERS_FOLDER OUT_FOLDER SOLID.stl ...

All clumps are measured by riprap. CPU seconds of peers are of the fit alone; those of
riprap are of the whole process: reading, repairing, fitting, measuring, writing.
"""

import csv
import json
import os
import resource
import subprocess
import sys

COUNTS = [10, 20, 50, 100, 200]
# For the CPU that ours needs to be as near as a peer: counts in between, of `fitted` only.
BETWEEN = [14, 28, 36, 70, 140]
OURS = ["fitted", "normals"]
HEAD = ["solid", "method", "asked", "spheres", "rms_percent", "mean_percent", "largest_percent",
        "volume_percent", "centroid_percent", "inertia_percent", "cpu_s"]


def children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def call(*arguments):
    before = children()
    done = subprocess.run(arguments, capture_output=True, text=True)
    seconds = children() - before
    if done.returncode != 0:
        return None, seconds, done.stderr.strip()
    return json.loads(done.stdout), seconds, ""


def errors(fidelity):
    d = fidelity["equivalent_diameter"]
    return [100.0 * value for value in (
        fidelity["rms_distance"] / d, fidelity["mean_distance"] / d, fidelity["largest_distance"] / d,
        fidelity["volume_error"], fidelity["centroid_error"] / d, fidelity["inertia_error"])]


def main():
    riprap, peers, out, solids = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
    rows = []
    for solid in solids:
        name = os.path.splitext(os.path.basename(solid))[0]
        for method in OURS:
            for count in sorted(COUNTS + (BETWEEN if method == "fitted" else [])):
                target = os.path.join(out, f"{name}-{method}-{count}.csv")
                found, seconds, wrong = call(riprap, "--json", "reproduce", solid, "--method", method,
                                             "--spheres", str(count), "-o", target)
                if found is None:
                    print(f"{name} {method} {count}: {wrong}")
                    continue
                clump = found["clump"]
                rows.append([name, method, count, clump["spheres"], *errors(clump["fidelity"]), seconds])
        times = os.path.join(peers, name, "seconds.csv")
        if not os.path.exists(times):
            continue
        for row in csv.DictReader(open(times)):
            path = os.path.join(peers, name, f"{row['method']}-{row['count']}.csv")
            found, _, wrong = call(riprap, "--json", "measure", path, "--against", solid)
            if found is None:
                print(f"{path}: {wrong}")
                continue
            spheres = sum(1 for _ in open(path)) - 1
            rows.append([name, row["method"], int(row["count"]), spheres,
                         *errors(found["files"][0]["measures"]), float(row["cpu_s"])])
    with open(os.path.join(out, "peers.csv"), "w") as table:
        table.write(",".join(HEAD) + "\n")
        for row in rows:
            table.write(",".join(f"{v:.5g}" if isinstance(v, float) else str(v) for v in row) + "\n")
    chart(rows, out)
    cost(rows)
    sys.exit(verdict(rows))


def cost(rows):
    """CPU of the best peer at each count over the least CPU of `fitted` that is as near with no more spheres."""
    ratios = []
    for solid in dict.fromkeys(row[0] for row in rows):
        for count in COUNTS:
            others = [r for r in rows if r[0] == solid and r[1] not in OURS and r[3] <= count]
            if not others:
                continue
            best = min(others, key=lambda row: row[4])
            ours = [r for r in rows if r[0] == solid and r[1] == "fitted" and r[3] <= count and r[4] <= best[4]]
            if not ours:
                print(f"{solid} {count}: none is as near as {best[1]}")
                continue
            least = min(ours, key=lambda row: row[10])
            ratios.append((best[10] / least[10], solid, count, best[1], best[10], least[2], least[10]))
    ratios.sort()
    for ratio, solid, count, peer, theirs, spheres, seconds in ratios:
        if ratio < 10.0:
            print(f"{solid} {count}: {peer} {theirs:.2f} s, fitted with {spheres} spheres {seconds:.3f} s: {ratio:.1f} times")
    tenfold = sum(ratio >= 10.0 for ratio, *_ in ratios)
    print(f"as near as the best peer: {ratios[0][0]:.1f} to {ratios[-1][0]:.0f} times less CPU, "
          f"{ratios[len(ratios) // 2][0]:.0f} in the median, 10 or more in {tenfold} of {len(ratios)}")


def verdict(rows):
    """1 if some peer with no more spheres is nearer than `fitted` in both distances' root mean square."""
    worse = 0
    print(f"{'solid':24} {'asked':>5} {'fitted':>8} {'best peer':>9}  peer")
    for solid in dict.fromkeys(row[0] for row in rows):
        for count in COUNTS:
            ours = [r for r in rows if r[0] == solid and r[1] == "fitted" and r[2] == count]
            others = [r for r in rows if r[0] == solid and r[1] not in OURS and r[3] <= count]
            if not ours or not others:
                continue
            best = min(others, key=lambda row: row[4])
            nearest = min(others, key=lambda row: row[6])
            is_worse = ours[0][4] > best[4] or ours[0][6] > nearest[6]
            worse |= is_worse
            print(f"{solid:24} {count:5} {ours[0][4]:8.3f} {best[4]:9.3f}  {best[1]}; largest "
                  f"{ours[0][6]:.2f} against {nearest[6]:.2f} of {nearest[1]}{'  WORSE' if is_worse else ''}")
    return int(worse)


def chart(rows, out):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    solids = list(dict.fromkeys(row[0] for row in rows))
    columns = 4
    lines = -(-len(solids) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(13, 3.3 * lines), squeeze=False)
    methods = list(dict.fromkeys(row[1] for row in rows))
    for index, solid in enumerate(solids):
        axis = axes[index // columns][index % columns]
        for place, method in enumerate(methods):
            points = sorted({(r[3], r[4]) for r in rows if r[0] == solid and r[1] == method})
            if points:
                axis.loglog(*zip(*points), marker="o", markersize=3, color=f"C{place}",
                            linewidth=2.5 if method == "fitted" else 1.0, label=method)
        axis.set_title(solid, fontsize=9)
        axis.set_xlabel("spheres", fontsize=8)
        axis.set_ylabel("rms distance, % of diameter", fontsize=8)
        axis.grid(True, which="both", alpha=0.2)
    for index in range(len(solids), lines * columns):
        axes[index // columns][index % columns].axis("off")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), fontsize=8)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(os.path.join(out, "peers.svg"))
    figure.savefig(os.path.join(out, "peers.png"), dpi=110)


main()
