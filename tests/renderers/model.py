"""What the tables are compared with: the model through `hetab eval` and `hetab reflectance`, and
its colours through Mitsuba's own tables of the CIE observer and D65."""
import csv
import io
import subprocess

import numpy

WAVELENGTHS_NM = numpy.arange(400, 701, 10)


class Model:
    """One surface, by the program at `hetab`."""

    def __init__(self, hetab, surface):
        self.hetab, self.surface = hetab, surface

    def run(self, *arguments, text=None):
        done = subprocess.run([self.hetab, *arguments], input=text, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if done.returncode:
            raise RuntimeError(f"hetab {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout

    def brdf(self, wi, wo):
        """[wavelength][pair], 1/sr: dd + ud, between unit vectors."""
        pairs = [f"{i:.15g},{r:.15g},{phi:.15g}\n" for i, r, phi in zip(*angles_deg(wi, wo))]
        return numpy.array([self.band(nm, pairs) for nm in WAVELENGTHS_NM])

    def band(self, nm, pairs):
        prefix = f"{1e-3 * nm:.2f},"
        text = "lambda_um,theta_i_deg,theta_r_deg,phi_deg\n" + prefix + prefix.join(pairs)
        answer = self.run("eval", self.surface, text=text)
        total = answer.split("\n", 1)[0].split(",").index("total")
        return numpy.loadtxt(io.StringIO(answer), delimiter=",", skiprows=1, usecols=total)

    def reflectance(self, theta_deg, column):
        """[wavelength][theta] of a column of `hetab reflectance`."""
        answer = self.run("reflectance", "--quiet", "--theta-i",
                          ",".join(f"{t:g}" for t in theta_deg), self.surface)
        rows = [float(row[column]) for row in csv.DictReader(io.StringIO(answer))]
        return numpy.array(rows).reshape(len(WAVELENGTHS_NM), len(theta_deg))


def angles_deg(wi, wo):
    """theta_i, theta_r and phi; the polar angles from both components, exact near 0 and 90."""
    polar = [numpy.degrees(numpy.arctan2(numpy.hypot(w[:, 0], w[:, 1]), w[:, 2])) for w in (wi, wo)]
    phi = numpy.degrees(numpy.arctan2(wo[:, 1], wo[:, 0]) - numpy.arctan2(wi[:, 1], wi[:, 0]))
    return (*(numpy.minimum(p, 90.0).tolist() for p in polar), phi.tolist())


def srgb_weights(mi):
    """[3][wavelength] to linear sRGB under D65, such that the perfect white is (1, 1, 1)."""
    xyz = numpy.array([numpy.array(mi.cie1931_xyz(float(nm))).ravel() * mi.cie_d65(float(nm))
                       for nm in WAVELENGTHS_NM])
    rows = [mi.xyz_to_srgb(mi.Color3f(*axis)) for axis in numpy.eye(3).tolist()]
    matrix = numpy.array([list(row) for row in rows]).T
    white = numpy.linalg.solve(matrix, numpy.ones(3))
    return matrix @ (xyz * white / xyz.sum(axis=0)).T
