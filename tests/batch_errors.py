#!/usr/bin/python3
"""What a batch says of its tables, against the model at directions of this file's own: relative L1 error over
all of the surface's wavelengths, between which a reader is linear, as it is between the nodes of HDF5 tables.

usage: batch_errors.py BUILD FOLDER ASKED SURFACE...    fails where an error is above what was asked for"""
import itertools
import json
import os
import sys

build, folder, asked, *names = sys.argv[1:]
os.environ["HETAB_LIBRARY"] = os.path.join(build, "libhetab.so")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../src/python"))

import h5py
import numpy

import hetab

NM = numpy.arange(400.0, 701.0, 10.0)
COUNT = 1500  # directions


def model(surface, theta_i, wo):
    theta_r = numpy.arccos(numpy.clip(wo[:, 2], 0, 1))
    phi = numpy.arctan2(wo[:, 1], wo[:, 0])
    return hetab.evaluate(surface.points(theta_i, theta_r, phi))["total"]  # [band, direction]


def linear(path):
    """read(wi, wo) of an HDF5 table: linear between its nodes, [direction, wavelength]."""
    with h5py.File(path) as file:
        brdf = file["brdf"][:].astype("f8")
        axes = [numpy.radians(file["brdf"].dims[k][0][:]) for k in (1, 2, 3)]

    def read(wi, wo):
        phi = numpy.arctan2(wo[:, 1], wo[:, 0]) - numpy.arctan2(wi[:, 1], wi[:, 0])
        at = [numpy.arccos(wi[:, 2]), numpy.arccos(wo[:, 2]), abs((phi + numpy.pi) % (2 * numpy.pi) - numpy.pi)]
        low = [numpy.clip(numpy.searchsorted(a, x) - 1, 0, len(a) - 2) for a, x in zip(axes, at)]
        part = [(x - a[k]) / (a[k + 1] - a[k]) for a, x, k in zip(axes, at, low)]
        value = 0
        for corner in itertools.product((0, 1), repeat=3):
            weight = numpy.prod([p if c else 1 - p for c, p in zip(corner, part)], axis=0)
            value = value + weight[:, None] * brdf[(slice(None), *(k + c for k, c in zip(low, corner)))].T
        return value
    return read


def error(table, read_at, surface, theta_i, random):
    wi = numpy.tile(numpy.float32([numpy.sin(theta_i), 0, numpy.cos(theta_i)]), (COUNT, 1))
    drawn, _ = table.sample(wi, random.random(COUNT, dtype="f4"), random.random((COUNT, 2), dtype="f4"))
    wo, keep = drawn["wo"], (drawn["lobe"] > 0) & (drawn["lobe"] < 3)  # without the delta
    read = read_at(wi[keep], wo[keep])  # [direction, channel]
    nm = 1e3 * numpy.asarray(table.wavelengths_um)
    read = numpy.stack([numpy.interp(NM, nm, row) for row in read])
    true = model(surface, theta_i, wo[keep].astype("f8")).T
    weight = (wo[keep, 2] / table.eval(wi[keep], wo[keep])[1])[:, None]
    return (weight * abs(read - true)).sum() / (weight * true).sum()


worst = 0
for name in names:
    with open(os.path.join(folder, name + ".json")) as file:
        record = json.load(file)
    path = os.path.join(folder, record["table_of"] + (".h5" if record["consumer"] == "hdf5" else ".bsdf"))
    table, surface = hetab.open_table(path), hetab.Surface(name)
    read_at = linear(path) if path.endswith(".h5") else lambda wi, wo: table.eval(wi, wo)[0]
    random = numpy.random.default_rng(7)
    found = max(error(table, read_at, surface, numpy.radians(deg), random) for deg in (0.3, 25.0, 50.0, 70.0, 74.6))
    print(f"{name}: {100 * found:.2f} % found, {100 * record['error_l1']:.2f} % recorded, "
          f"{len(table.wavelengths_um)} wavelengths")
    worst = max(worst, found)
sys.exit(bool(worst > float(asked)))
