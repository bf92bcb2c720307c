#!/usr/bin/python3
"""The Python package's calls over the C calls beneath them, on the same arrays: medians of runs that
take turns. usage: python_speed.py BUILD        from the repository's root"""
import os
import sys
import tempfile
import time

BUILD = os.path.abspath(sys.argv[1])
os.environ["HETAB_LIBRARY"] = os.path.join(BUILD, "libhetab.so")
sys.path.insert(0, "src/python")

import numpy

import hetab
from hetab import _library, _model
from hetab._library import NULL, address, call, lib

COUNT, RUNS = 10**6, 11


def compare(what, python, c):
    seconds = numpy.zeros((RUNS + 1, 2))
    for row in seconds:
        for k, function in enumerate((python, c)):
            start = time.perf_counter()
            function()
            row[k] = time.perf_counter() - start
    a, b = numpy.median(seconds[1:], axis=0)
    print(f"{what}, 10^6: {1e3 * a:.0f} ms, the C call {1e3 * b:.0f} ms, ratio "
          f"{numpy.median(seconds[1:, 0] / seconds[1:, 1]):.2f}")


def directions(random):
    z, phi = random.uniform(0.1, 1, COUNT), random.uniform(0, 2 * numpy.pi, COUNT)
    r = numpy.sqrt(1 - z * z)
    return numpy.stack([r * numpy.cos(phi), r * numpy.sin(phi), z], axis=1).astype("f4")


def main():
    random, surface = numpy.random.default_rng(1), hetab.Surface("BBQAL2")
    points = surface.points(*random.uniform(0, 1.5, (2, COUNT)), random.uniform(0, 3.1, COUNT), 0.55)
    values = numpy.empty(COUNT, hetab.VALUE)
    for precision in ("float", "double"):
        engine = _model.engine(precision)
        compare(f"evaluate, {precision}", lambda: hetab.evaluate(points, precision=precision),
                lambda: call(lib.hetab_evaluate, engine, address(points), COUNT, address(values)))
    with tempfile.TemporaryDirectory() as folder:
        for name in ("table.h5", "table.binary", "table.bsdf"):
            path = os.path.join(folder, name)
            hetab.tabulate_to(surface, path)
            table, wi, wo = hetab.open_table(path), directions(random), directions(random)
            value, density = numpy.empty((COUNT, table.channels), "f4"), numpy.empty(COUNT, "f4")
            compare(f"look-up, {name}", lambda: table.eval(wi, wo),
                    lambda: lib.hetab_lookup_eval(table._handle, NULL, COUNT, *map(
                        address, (wi, wo, value, density))))


main()
