#!/usr/bin/env python3
"""Clumps of one mesh by other programs, and the CPU seconds of the fit alone.

usage: peers.py MESH.stl FOLDER COUNT [COUNT ...]

Writes FOLDER/METHOD-COUNT.csv (x,y,z,r in the frame of the mesh) and
FOLDER/seconds.csv. Ours are made with `riprap reproduce`, not here.
"""

import contextlib
import io
import os
import resource
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import trimesh
from CLUMP import (
    GenerateClump_Euclidean_3D,
    GenerateClump_Favier,
    GenerateClump_Ferellec_McDowell,
)
from multisphere import multisphere_from_mesh


def column(values):
    return np.asarray(values, dtype=float).reshape(-1, 1)


def rows(clump):
    return np.hstack((np.asarray(clump.positions, dtype=float), column(clump.radii)))


def favier(path, mesh, count):
    return rows(GenerateClump_Favier(inputGeom=path, N=count, chooseDistance="min")[1])


def euclidean(path, mesh, count):
    clump = GenerateClump_Euclidean_3D(inputGeom=path, N=count, rMin=0, div=50, overlap=0.6)[1]
    found = rows(clump)
    # The program moves the mesh to the centre of its box and does not move the spheres back.
    found[:, :3] += mesh.bounds.mean(axis=0)
    return found


def ferellec(path, mesh, count):
    """The finest distance between points of ten that needs at most `count` spheres; the search is charged."""
    size = (6.0 * abs(mesh.volume) / np.pi) ** (1.0 / 3.0)
    best = None
    for distance in size * np.geomspace(0.3, 0.004, 10):
        clump = GenerateClump_Ferellec_McDowell(
            inputGeom=path, dmin=distance, rmin=0.01 * size, rstep=0.005 * size, pmax=1.0, seed=5
        )[1]
        found = rows(clump)
        if len(found) > count:
            break
        best = found
    return best


def mss(path, mesh, count):
    pack = multisphere_from_mesh(trimesh.load_mesh(path), div=100, max_spheres=count)
    return np.hstack((np.asarray(pack.centers, dtype=float), column(pack.radii)))


METHODS = {
    "CLUMP-Favier": favier,
    "CLUMP-Euclidean": euclidean,
    "CLUMP-Ferellec": ferellec,
    "MSS": mss,
}


def cpu():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def main():
    path, folder, counts = sys.argv[1], sys.argv[2], [int(n) for n in sys.argv[3:]]
    os.makedirs(folder, exist_ok=True)
    mesh = trimesh.load_mesh(path)
    seconds = ["method,count,cpu_s,wall_s"]
    for name, method in METHODS.items():
        for count in counts:
            before, start = cpu(), time.time()
            try:
                with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                    found = method(path, mesh, count)
            except Exception as error:  # a peer that fails is a row that is missing
                print(f"{name} {count}: {type(error).__name__}: {error}", file=sys.stderr)
                continue
            used, wall = cpu() - before, time.time() - start
            if found is None or len(found) == 0:
                print(f"{name} {count}: no spheres", file=sys.stderr)
                continue
            # Spheres without a radius are no spheres.
            found = found[np.isfinite(found).all(axis=1) & (found[:, 3] > 0.0)]
            with open(os.path.join(folder, f"{name}-{count}.csv"), "w") as out:
                out.write("x,y,z,r\n")
                for row in found:
                    out.write(",".join(f"{value:.17e}" for value in row) + "\n")
            seconds.append(f"{name},{count},{used:.4f},{wall:.4f}")
    with open(os.path.join(folder, "seconds.csv"), "w") as out:
        out.write("\n".join(seconds) + "\n")


main()
