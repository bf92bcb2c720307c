"""Pearson's test of a .bsdf's sample() against its pdf(), by mitsuba.chi2.

mitsuba.chi2.ChiSquareTest needs a variant with arrays: it runs in llvm_ad_*, where LLVM is there. In
the scalar variants the histogram and the integrals of the density are formed here, on the same
cells; pooling, statistic and probability are Mitsuba's own (mitsuba.math_py), from the same module.
"""
import math

import numpy

INCIDENCES_DEG = (0, 15, 30, 45, 60, 75, 85)
AZIMUTHS_DEG = (0, 70)
COUNT = len(INCIDENCES_DEG) * len(AZIMUTHS_DEG)
SIGNIFICANCE = 0.01  # of all tests of a surface together
CELLS = (50, 101)    # azimuths and cosines, those of ChiSquareTest's defaults
POOL = 5             # samples that a cell has to expect
SAMPLES = {"scalar": 128_000, "llvm": 1_000_000}
NODES = {"scalar": 16, "llvm": 64}  # of the density in a cell, per axis: lobes are as narrow as it


def directions():
    for theta in INCIDENCES_DEG:
        for phi in AZIMUTHS_DEG:
            t, p = math.radians(theta), math.radians(phi)
            yield [math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)]


def level():
    """Sidak's correction."""
    return 1 - (1 - SIGNIFICANCE) ** (1 / COUNT)


def histogram(material, wi, seed):
    uniform = numpy.random.default_rng(seed).random((SAMPLES["scalar"], 2), dtype="f4")
    wo = material.sample(wi, uniform)
    phi, cosine = numpy.arctan2(wo[:, 1], wo[:, 0]), wo[:, 2]
    return numpy.histogram2d(phi, cosine, CELLS, ((-math.pi, math.pi), (-1, 1)))[0]


def expectation(material, wi):
    """The density over each cell, by the midpoint rule, in samples."""
    nodes = NODES["scalar"]
    phi = midpoints(-math.pi, math.pi, CELLS[0] * nodes)
    cosine = midpoints(-1, 1, CELLS[1] * nodes)
    above = cosine > 0
    p, c = (a.ravel() for a in numpy.meshgrid(phi, cosine[above], indexing="ij"))
    sine = numpy.sqrt(1 - c * c)
    density = numpy.zeros((len(phi), len(cosine)))
    density[:, above] = material.pdf(
        wi, numpy.stack([sine * numpy.cos(p), sine * numpy.sin(p), c], axis=1)).reshape(len(phi), -1)
    cells = density.reshape(CELLS[0], nodes, CELLS[1], nodes).mean(axis=(1, 3))
    return cells * SAMPLES["scalar"] * 4 * math.pi / (CELLS[0] * CELLS[1])


def midpoints(first, last, count):
    return first + (last - first) * (numpy.arange(count) + 0.5) / count


def scalar_test(mi, material, wi, seed):
    """Probability of a statistic at least as large; 0 if samples fall where the density is 0."""
    expected, observed = expectation(material, wi).ravel(), histogram(material, wi, seed).ravel()
    if numpy.any((expected == 0) & (observed != 0)) or not numpy.isfinite(expected).all():
        return 0.0
    order = numpy.argsort(expected)
    statistic, freedom, _, _ = mi.math_py.chi2(observed[order], expected[order], POOL)
    return 1 - mi.math_py.rlgamma(freedom / 2, statistic / 2) if freedom > 0 else 0.0


def scalar_tests(mi, material):
    return [scalar_test(mi, material, wi, seed) for seed, wi in enumerate(directions())]


def llvm_tests(path):
    # Its names are those of the variant that is set.
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain
    probabilities = []
    for wi in directions():
        sample, pdf = BSDFAdapter("measured", {"type": "measured", "filename": path}, wi=wi)
        test = ChiSquareTest(SphericalDomain(), sample, pdf, 3, SAMPLES["llvm"], ires=NODES["llvm"])
        test.run(SIGNIFICANCE, COUNT, quiet=True)
        probabilities.append(0.0 if test.fail else float(test.p_value))
    return probabilities


def passes(probabilities):
    return sum(p >= level() for p in probabilities)
