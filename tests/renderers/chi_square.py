"""Pearson's test of a .bsdf's sample() against its pdf(), by mitsuba.chi2.

usage: chi_square.py RGB.bsdf...     prints how many of the tests pass; status 1 if one does not

mitsuba.chi2.ChiSquareTest needs a variant with arrays: it runs in llvm_ad_*, where LLVM is there.
In the scalar variants the histogram and the integrals of the density are formed here, on the same
cells; pooling, statistic and probability are the ones that it uses (mitsuba.math_py).

The cells are polar about the mirror direction and narrow towards it. In those of Mitsuba's
SphericalDomain a narrow lobe at normal incidence lies in one row; and the density that the
measured plugin returns has an integrable pole where the half vector is the normal (it interpolates
the visible normals linearly there, and divides by theta^2), which a node of the cells would hit.
"""
import math
import os
import sys

import numpy

INCIDENCES_DEG = (0, 15, 30, 45, 60, 75, 85)
AZIMUTHS_DEG = (0, 70)
COUNT = len(INCIDENCES_DEG) * len(AZIMUTHS_DEG)
SIGNIFICANCE = 0.01  # of all tests of a run together
CELLS = (50, 101)    # around and away from the mirror direction: ChiSquareTest's defaults
POOL = 5             # samples that a cell has to expect
SAMPLES = {"scalar": 100_000, "llvm": 1_000_000}
# Of the density in a cell, per axis; scalar: empty cells, others, those of which only a sliver is lit.
NODES = {"scalar": (4, 16, 128), "llvm": 32}


def directions():
    for theta in INCIDENCES_DEG:
        for phi in AZIMUTHS_DEG:
            t, p = math.radians(theta), math.radians(phi)
            yield [math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)]


def level(tables):
    """Sidak's correction for the tests of so many tables."""
    return 1 - (1 - SIGNIFICANCE) ** (1 / (COUNT * tables))


# ---- scalar variants -----------------------------------------------------------------------------

class Cells:
    """Coordinates (azimuth, sqrt(angle / pi)) about the mirror direction of wi, in unit squares."""

    def __init__(self, wi):
        z = numpy.array([-wi[0], -wi[1], wi[2]])
        x = numpy.cross(z, [0, 1, 0] if abs(z[1]) < 0.9 else [1, 0, 0])
        x /= numpy.linalg.norm(x)
        self.frame = numpy.stack([x, numpy.cross(z, x), z])

    def place(self, w):
        x, y, z = self.frame @ w.T
        return (numpy.arctan2(y, x) / (2 * math.pi) + 0.5,
                numpy.sqrt(numpy.arctan2(numpy.hypot(x, y), z) / math.pi))

    def direction(self, u, v):
        """(w, its solid angle per area of the square)."""
        phi, theta = 2 * math.pi * (u - 0.5), math.pi * v * v
        sine = numpy.sin(theta)
        local = numpy.stack([sine * numpy.cos(phi), sine * numpy.sin(phi), numpy.cos(theta)], 1)
        return local @ self.frame, 4 * math.pi ** 2 * sine * v

    def integrals(self, density, cells, nodes):
        """Of density(w) over the cells (indices), by the midpoint rule; 0 below the horizon."""
        column, row = numpy.divmod(cells, CELLS[1])
        inner = (numpy.arange(nodes) + 0.5) / nodes
        u = (column[:, None, None] + inner[:, None] + 0 * inner) / CELLS[0]
        v = (row[:, None, None] + 0 * inner[:, None] + inner) / CELLS[1]
        w, angle = self.direction(u.ravel(), v.ravel())
        above, values = w[:, 2] > 0, numpy.zeros(len(w))
        values[above] = density(w[above]) * angle[above]
        return values.reshape(len(cells), nodes * nodes).mean(axis=1) / (CELLS[0] * CELLS[1])


def expectation(cells, density, observed):
    few, many, at_horizon = NODES["scalar"]
    expected = cells.integrals(density, numpy.arange(len(observed)), few)
    occupied = numpy.flatnonzero((expected * SAMPLES["scalar"] > 0.02) | (observed > 0))
    expected[occupied] = cells.integrals(density, occupied, many)
    missed = numpy.flatnonzero((expected == 0) & (observed > 0))  # cells that the horizon nearly covers
    expected[missed] = cells.integrals(density, missed, at_horizon)
    return expected * SAMPLES["scalar"]


def scalar_test(mi, material, wi, seed):
    """Probability of a statistic at least as large; 0 if samples fall where the density is 0."""
    cells = Cells(wi)
    uniform = numpy.random.default_rng(seed).random((SAMPLES["scalar"], 2), dtype="f4")
    u, v = cells.place(material.sample(wi, uniform))
    observed = numpy.histogram2d(u, v, CELLS, ((0, 1), (0, 1)))[0].ravel()
    expected = expectation(cells, lambda w: material.pdf(wi, w), observed)
    if numpy.any((expected == 0) & (observed != 0)) or not numpy.isfinite(expected).all():
        return 0.0
    order = numpy.argsort(expected)
    statistic, freedom, _, _ = mi.math_py.chi2(observed[order], expected[order], POOL)
    return 1 - mi.math_py.rlgamma(freedom / 2, statistic / 2) if freedom > 0 else 0.0


def scalar_tests(mi, material):
    return [scalar_test(mi, material, wi, seed) for seed, wi in enumerate(directions())]


# ---- LLVM variants -------------------------------------------------------------------------------

class MirrorDomain:
    """Cells as a domain of mitsuba.chi2, for the variant that is set."""

    def __init__(self, mi, dr, wi):
        self.mi, self.dr = mi, dr
        self.frame = mi.Frame3f(mi.Vector3f(-wi[0], -wi[1], wi[2]))

    def bounds(self):
        return self.mi.ScalarBoundingBox2f([-math.pi, 0], [math.pi, 1])

    def aspect(self):
        return CELLS[1] / CELLS[0]

    def map_forward(self, p):
        sin_phi, cos_phi = self.dr.sincos(p.x)
        sine, cosine = self.dr.sincos(math.pi * p.y * p.y)
        return self.frame.to_world(self.mi.Vector3f(cos_phi * sine, sin_phi * sine, cosine))

    def map_backward(self, w):
        p = self.frame.to_local(w)
        theta = self.dr.atan2(self.dr.hypot(p.x, p.y), p.z)
        return self.mi.Vector2f(self.dr.atan2(p.y, p.x), self.dr.sqrt(theta / math.pi))

    def solid_angle(self, w):
        """Per area of the domain."""
        v = self.map_backward(w).y
        return 2 * math.pi * v * self.dr.sin(math.pi * v * v)


def llvm_test(mi, path, wi):
    import drjit as dr
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest
    domain = MirrorDomain(mi, dr, wi)
    sample, pdf = BSDFAdapter("measured", {"type": "measured", "filename": path}, wi=wi)
    test = ChiSquareTest(domain, sample, lambda w: pdf(w) * domain.solid_angle(w), 3,
                         SAMPLES["llvm"], ires=NODES["llvm"])
    test.run(quiet=True)
    return 0.0 if test.fail else float(test.p_value)


def llvm_tests(mi, path):
    return [llvm_test(mi, path, wi) for wi in directions()]


def passes(probabilities, tables):
    return sum(p >= level(tables) for p in probabilities)


def main():
    import mitsuba as mi
    from material import Material
    failed, tables = False, sys.argv[1:]
    for path in tables:
        mi.set_variant("scalar_rgb")
        found = {"scalar": scalar_tests(mi, Material(mi, path))}
        if "DRJIT_LIBLLVM_PATH" in os.environ:
            mi.set_variant("llvm_ad_rgb")
            found["LLVM"] = llvm_tests(mi, path)
        passed = {kind: passes(p, len(tables)) for kind, p in found.items()}
        failed |= any(count < COUNT for count in passed.values())
        print(os.path.basename(path), "chi2", {kind: f"{n}/{COUNT}" for kind, n in passed.items()})
    sys.exit(failed)


if __name__ == "__main__":
    main()
