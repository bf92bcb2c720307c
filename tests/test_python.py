#!/usr/bin/python3
"""The Python package against 40-digit values, the program's own numbers, and bad input.

usage: test_python.py BUILD        from the repository's root"""
import csv
import io
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zipfile

BUILD = os.path.abspath(sys.argv.pop() if len(sys.argv) > 1 else "build")
os.environ["HETAB_LIBRARY"] = os.path.join(BUILD, "libhetab.so")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../src/python"))

import numpy

import hetab
from hetab import _library

GOLDEN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "golden")


def golden(name):
    return numpy.genfromtxt(os.path.join(GOLDEN, name), delimiter=",", names=True, dtype=None,
                            encoding="utf-8")


def directions(count, seed):
    random = numpy.random.default_rng(seed)
    z, phi = random.uniform(0.1, 1, count), random.uniform(0, 2 * numpy.pi, count)
    r = numpy.sqrt(1 - z * z)
    return numpy.stack([r * numpy.cos(phi), r * numpy.sin(phi), z], axis=1).astype("f4")


class Model(unittest.TestCase):
    def test_points_against_40_digits(self):
        rows = golden("he_torrance.csv")
        points = numpy.zeros(len(rows), hetab.POINT)
        for name in ("lambda_um", "sigma0_um", "tau_um", "n", "k"):
            points[name] = rows[name]
        for name in ("theta_i", "theta_r", "phi"):
            points[name] = rows[name + "_rad"]
        bright = rows["f_dd_per_sr"] >= 1e-9
        for options, bound in (({}, 1e-12), ({"precision": "float"}, 1e-5),
                               ({"literal": True}, 1e-8)):
            values = hetab.evaluate(points, **options)
            self.assertEqual(values.shape, points.shape)
            error = numpy.abs(values["dd"] / rows["f_dd_per_sr"] - 1)[bright]
            self.assertLess(error.max(), bound, options)

    def test_surface_points_are_those_of_the_program(self):
        surface = hetab.Surface("NGGAL")
        theta_r = numpy.linspace(0, 1.5, 7)
        values = hetab.evaluate(surface.points(0.4, theta_r, [[3.0], [3.1]], 0.55))
        self.assertEqual(values.shape, (2, 7))
        rows = [f"0.55,{i:.17g},{r:.17g},{phi:.17g}\n" for i, r, phi in numpy.degrees(
            [[0.4, r, 3.1] for r in theta_r])]
        text = "lambda_um,theta_i_deg,theta_r_deg,phi_deg\n" + "".join(rows)
        answer = subprocess.run([os.path.join(BUILD, "hetab"), "eval", "NGGAL"], input=text,
                                text=True, stdout=subprocess.PIPE, check=True).stdout
        total = [float(row["total"]) for row in csv.DictReader(io.StringIO(answer))]
        numpy.testing.assert_allclose(values["total"][1], total, rtol=1e-5)
        whole = hetab.evaluate(surface.points(0.4, theta_r, 3.1))["total"]
        self.assertEqual(whole.shape, (31, 7))
        numpy.testing.assert_allclose(whole[15], values["total"][1], rtol=1e-12)

    def test_reflectance_against_40_digits(self):
        rows = golden("reflectance.csv")
        rows = rows[(rows["case"] == "BBQAL1") & (rows["theta_i_deg"] < 89)]
        case = {name: float(rows[name][0]) for name in ("sigma0_um", "tau_um", "n", "k")}
        surface = hetab.Surface(sigma0_um=case["sigma0_um"], tau_um=case["tau_um"],
                                index={"n": case["n"], "k": case["k"]}, wavelengths_nm=[550])
        found = hetab.reflectance(surface, numpy.radians(rows["theta_i_deg"]))
        numpy.testing.assert_allclose(found["dd"]["value"][0], rows["rho_dd"], rtol=1e-7)
        numpy.testing.assert_allclose(found["specular"][0], rows["rho_s"], rtol=1e-9)
        self.assertEqual(found.shape, (1, len(rows)))

    def test_table_in_memory(self):
        surface = hetab.Surface("BBQAL2")
        surface.wavelengths_um = [0.45, 0.55, 0.65]
        table = hetab.tabulate(surface, "0:80:5", numpy.linspace(0, 85, 18), "cells:12")
        self.assertEqual(table.brdf.shape, (3, 5, 18, 12))
        axes = (table.theta_i_deg, table.theta_r_deg, table.phi_deg)
        i, r, phi = numpy.meshgrid(*map(numpy.radians, axes), indexing="ij")
        exact = hetab.evaluate(surface.points(i, r, phi))
        numpy.testing.assert_allclose(table.brdf, exact["total"], rtol=2e-5, atol=1e-14)
        numpy.testing.assert_allclose(table.specular, exact["specular"][..., 0, 0], rtol=1e-9)
        self.assertLess(table.report.error.max_rel, 1e-5)

    def test_surface_from_keys_and_back(self):
        surface = hetab.Surface(sigma0_um=0.3, tau_um=3, index={"n": 1.5, "k": 0.1},
                                diffuse_reflectance=0.2, wavelengths_nm=numpy.array([500, 600]))
        with tempfile.NamedTemporaryFile("w", suffix=".yml") as file:
            file.write(surface.yaml())
            file.flush()
            again = hetab.Surface(file.name)
        for one in (surface, again):
            self.assertEqual((one.sigma0_um, one.tau_um), (0.3, 3))
            numpy.testing.assert_allclose(one.bands["n"], [1.5, 1.5])
            numpy.testing.assert_allclose(one.bands["diffuse_brdf"], 0.2 / numpy.pi)
        preset = hetab.Surface("BBQAL2")
        self.assertEqual(preset.at(0.55), preset.bands[15])
        self.assertEqual(preset.at([[0.4], [0.7]]).shape, (2, 1))


class Sources(unittest.TestCase):
    """What `hetab shader` writes, in Python and in C, where h is above 1e-6 of its peak."""

    C = """
#include "he_torrance.h"
void brdf(int count, const ht_surface *s, const float (*w)[6], float *f) {
  for (int k = 0; k < count; k++)
    f[k] = ht_brdf(s[k], w[k][0], w[k][1], w[k][2], w[k][3], w[k][4], w[k][5]);
}
/* The mean of f cos / density. */
void means(int count, ht_surface s, float x, float z, const float (*u)[3], double *mean) {
  ht_lobes lobes = ht_lobes_of(s, x, 0.0f, z);
  for (int k = 0; k < count; k++) {
    ht_four o = ht_sample(lobes, u[k][0], u[k][1], u[k][2]);
    if (o.w > 0.0f)
      *mean += ht_brdf(s, x, 0.0f, z, o.x, o.y, o.z) * o.z / o.w / count;
  }
}
"""

    @classmethod
    def setUpClass(cls):
        cls.model = {}
        exec(hetab.shader("python", hetab.Surface("NGGAL")), cls.model)
        cls.folder = tempfile.TemporaryDirectory()
        for name, text in (("he_torrance.h", hetab.shader("c")), ("model.c", cls.C)):
            with open(os.path.join(cls.folder.name, name), "w", encoding="utf-8") as file:
                file.write(text)
        library = os.path.join(cls.folder.name, "model.so")
        subprocess.run(["cc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror",
                        "-Wno-unused-function", "-O2", "-shared", "-fPIC", "-o", library,
                        os.path.join(cls.folder.name, "model.c"), "-lm"], check=True)
        ffi = _library.cffi.FFI()
        ffi.cdef("typedef struct { float v[6]; } surface;"
                 "void brdf(int, const void *, const void *, float *);"
                 "void means(int, surface, float, float, const void *, double *);")
        cls.ffi, cls.c = ffi, ffi.dlopen(library)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def golden(self):
        """Rows, and directions that are single floats with what the printed equations say there."""
        rows = golden("he_torrance.csv")
        points = numpy.zeros(len(rows), hetab.POINT)
        for name in ("lambda_um", "sigma0_um", "tau_um", "n", "k"):
            points[name] = rows[name].astype("f4")
        i, r, phi = (rows[name + "_rad"] for name in ("theta_i", "theta_r", "phi"))
        w = numpy.stack([numpy.sin(i), 0 * i, numpy.cos(i), numpy.sin(r) * numpy.cos(phi),
                         numpy.sin(r) * numpy.sin(phi), numpy.cos(r)], axis=1).astype("f4")
        exact = w.astype("f8")
        points["theta_i"] = numpy.arctan2(exact[:, 0], exact[:, 2])
        points["theta_r"] = numpy.arctan2(numpy.hypot(exact[:, 3], exact[:, 4]), exact[:, 5])
        points["phi"] = numpy.arctan2(exact[:, 4], exact[:, 3])
        values = hetab.evaluate(points, literal=True)
        ln_h = [self.model["ln_h"](self.model["Numpy"], values["g"], x)
                for x in (values["x"], 0 * values["x"])]
        shown = (ln_h[0] - ln_h[1] > numpy.log(1e-6)) & (values["dd"] > 1e-9) & (
            numpy.minimum(exact[:, 2], exact[:, 5]) > numpy.cos(numpy.radians(89.5)))
        shown &= points["tau_um"] < 110 * points["lambda_um"]  # single floats are no unit vectors
        return points[shown], w[shown], values["dd"][shown]

    def test_values(self):
        points, w, dd = self.golden()
        self.assertGreater(len(dd), 200)
        parameters = [points[name] for name in ("sigma0_um", "tau_um", "lambda_um", "n", "k")]
        python = self.model["brdf"](w[:, :3].T.astype("f8"), w[:, 3:].T.astype("f8"), *parameters)
        surfaces = numpy.stack(parameters + [0 * dd], axis=1).astype("f4")
        c = numpy.empty(len(dd), "f4")
        self.c.brdf(len(dd), *(self.ffi.cast("void *", self.ffi.from_buffer(a))
                               for a in (surfaces, w)),
                    self.ffi.cast("float *", self.ffi.from_buffer(c)))
        for found in (python, c):
            self.assertLess(numpy.abs(found / dd - 1).max(), 5e-5)

    def test_samples_in_c_have_the_reflectance(self):
        u = numpy.random.default_rng(5).random((200_000, 3), dtype="f4")
        for sigma0, tau in ((0.54, 6.5), (0.17, 5.0), (0.02, 3.0)):
            surface = hetab.Surface(sigma0_um=sigma0, tau_um=tau, index={"n": 1.4, "k": 6},
                                    wavelengths_nm=[550])
            for theta in (0.0, 0.8, 1.3):
                mean = self.ffi.new("double *")
                self.c.means(len(u), {"v": [sigma0, tau, 0.55, 1.4, 6.0, 0.0]}, numpy.sin(theta),
                             numpy.cos(theta), self.ffi.from_buffer(u), mean)
                truth = hetab.reflectance(surface, theta)["dd"]["value"][0]
                self.assertLess(abs(mean[0] / truth - 1), 0.01)

    def test_surface(self):
        surface = hetab.Surface("NGGAL")
        self.assertEqual(self.model["SURFACE"]["sigma0_um"], surface.sigma0_um)
        numpy.testing.assert_allclose(self.model["SURFACE"]["n"], surface.bands["n"], rtol=1e-8)
        self.assertIn(f'"sigma0_um": {surface.sigma0_um:g}', hetab.shader("glsl", surface))


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        path = os.path.join(cls.folder.name, "table.binary")
        hetab.tabulate_to(hetab.Surface("GGAL240"), path)
        cls.table = hetab.open_table(path)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_look_ups_one_and_many(self):
        table, wi, wo = self.table, directions(500, 1), directions(500, 2)
        uc, u = numpy.random.default_rng(3).random(500), numpy.random.default_rng(4).random((500, 2))
        self.assertIsNone(table.wavelengths_um)
        values, density = table.eval(wi, wo)
        drawn, weight = table.sample(wi, uc, u)
        self.assertEqual((values.shape, density.shape, drawn["wo"].shape, weight.shape),
                         ((500, 3), (500,), (500, 3), (500, 3)))
        for i in (0, 17, 499):
            numpy.testing.assert_array_equal(table.eval(wi[i], wo[i])[0], values[i])
            numpy.testing.assert_array_equal(table.eval(wi[i], wo[i])[1], density[i])
        numpy.testing.assert_array_equal(table.eval(wi[0], wo)[0],
                                         table.eval(wi[:1].repeat(500, 0), wo)[0])
        kept = (drawn["lobe"] == 1) | (drawn["lobe"] == 2)
        self.assertTrue(kept.sum() > 400)
        again, pdf = table.eval(wi, drawn["wo"])
        numpy.testing.assert_allclose(pdf[kept], drawn["pdf"][kept], rtol=1e-3)
        numpy.testing.assert_allclose(
            weight[kept], (again * (drawn["wo"][:, 2:] / drawn["pdf"][:, None]))[kept], rtol=1e-5)
        with self.assertRaises(ValueError):
            table.eval(wi[:, :2], wo)
        with self.assertRaises(ValueError):
            table.eval(wi, wo, lambda_um=[0.55])

    def test_reflectance_of_the_model(self):
        """Albedo and delta of the table against the model's own integrals, in linear sRGB green."""
        wi = numpy.array([[numpy.sin(t), 0, numpy.cos(t)] for t in (0.2, 0.8, 1.2)])
        surface = hetab.Surface("GGAL240")
        surface.wavelengths_um = [0.55]
        model = hetab.reflectance(surface, [0.2, 0.8, 1.2])[0]
        albedo, specular = self.table.albedo(wi)
        self.assertEqual(albedo.shape, (3, 3))
        numpy.testing.assert_allclose(albedo[:, 1], model["dh"] - model["specular"], rtol=0.02)
        numpy.testing.assert_allclose(specular[:, 1], model["specular"], atol=0.01)

    def test_wavelengths_of_paths(self):
        path = os.path.join(self.folder.name, "table.h5")
        subprocess.run([os.path.join(BUILD, "hetab"), "tabulate", "NGGAL", "-o", path, "--quiet",
                        "--wavelengths", "450,550,650", "--theta-i", "0:90:31", "--theta-r",
                        "0:90:31", "--phi", "0:180:31"], check=True)
        table, wi, wo = hetab.open_table(path), directions(50, 1), directions(50, 2)
        own = table.eval(wi, wo, lambda_um=table.wavelengths_um[1:])[0]
        numpy.testing.assert_allclose(own, table.eval(wi, wo)[0][:, 1:], rtol=1e-5)
        for one in (0.55, numpy.float64(0.55)):
            numpy.testing.assert_array_equal(table.eval(wi, wo, one)[0],
                                             table.eval(wi, wo, [0.55])[0])
        self.assertEqual(table.albedo(wi[0], 0.55)[0].shape, (1,))
        with self.assertRaisesRegex(ValueError, "lambda_um is empty"):
            table.eval(wi, wo, [])
        paths = numpy.linspace(0.45, 0.65, 100).reshape(50, 2)
        self.assertEqual(table.sample(wi, 0.5, directions(50, 3)[:, :2] % 1, paths)[1].shape, (50, 2))
        albedo, specular = table.albedo(wi, paths)
        self.assertTrue(((albedo + specular > 0.5) & (albedo + specular < 1.1)).all())

    def test_a_file_is_not_lost(self):
        path, steps = os.path.join(self.folder.name, "once.h5"), []
        surface = hetab.Surface(sigma0_um=0.3, tau_um=3, index="Al", wavelengths_nm=[550])
        for overwrite in (False, True):
            hetab.tabulate_to(surface, path, overwrite=overwrite,
                              progress=lambda done, total: steps.append(done / total))
        self.assertEqual(steps[-1], 1.0)
        self.assertEqual(hetab.open_table(path).channels, 1)
        with self.assertRaisesRegex(hetab.Error, "once.h5"):
            hetab.tabulate_to(surface, path)

    def test_an_atlas(self):
        path = os.path.join(self.folder.name, "atlas.exr")
        hetab.tabulate_to(hetab.Surface("GGAL240"), path, exr={"parts": "atlas", "element": "half"})
        with open(path, "rb") as file:
            self.assertIn(b"tiles_across", file.read(4096))
        with self.assertRaisesRegex(ValueError, "atlas"):
            hetab.tabulate_to(hetab.Surface("GGAL240"), path, exr={"parts": "tiles"})

    def test_what_is_no_table(self):
        with self.assertRaises(hetab.Error) as raised:
            hetab.open_table("/nowhere/table.h5")
        self.assertIn("/nowhere/table.h5", str(raised.exception))
        with self.assertRaises(ValueError):
            hetab.open_table("/nowhere/table.h5", rule="guess")


class Laboratory(unittest.TestCase):
    def test_roughness_of_a_synthetic_scan(self):
        random, tau, spacing = numpy.random.default_rng(1), 3.0, 0.1
        lag = numpy.arange(-150, 151) * spacing
        kernel = numpy.exp(-2 * (lag / tau) ** 2)  # its autocorrelation is exp(-(lag / tau)^2)
        z = numpy.array([numpy.convolve(random.standard_normal(20300), kernel, "valid")
                         for _ in range(3)])
        z *= 0.3 / (kernel @ kernel) ** 0.5
        found = hetab.roughness(z, spacing_um=spacing)
        for average, truth in ((found.raw.sigma_um, 0.3), (found.raw.tau_um, tau)):
            self.assertEqual(average.count, 3)
            self.assertLess(abs(average.mean - truth), 3 * average.error)
            self.assertLess(average.error, 0.1 * truth)
        self.assertEqual(found.raw.scans["sigma_um"]["value"].shape, (3,))
        with self.assertRaisesRegex(hetab.Error, "spacing"):
            hetab.roughness(z)

    def test_fit_finds_what_was_put_in(self):
        truth = hetab.Surface(sigma0_um=0.3, tau_um=3, index={"n": 1.5, "k": 0},
                              diffuse_reflectance=0.2, wavelengths_nm=[500, 600])
        i, r = (a.ravel() for a in numpy.meshgrid(numpy.radians([20, 45, 60]),
                                                  numpy.linspace(0, 1.4, 30), indexing="ij"))
        values = hetab.evaluate(truth.points(i, r, numpy.pi))["total"].T
        measured = hetab.measurements([0.5, 0.6], i, r, numpy.pi, values)
        found = hetab.fit(measured, 1.5, slope=(0.02, 0.5), tau_um=3)
        self.assertAlmostEqual(found.slope, 0.1, 6)
        numpy.testing.assert_allclose(found.diffuse, 0.2, atol=1e-6)
        self.assertEqual((found.stop, found.estimates[0].quantity), ("tolerance", "slope"))
        self.assertEqual(found.model.shape, (90, 2))
        self.assertAlmostEqual(found.surface.sigma0_um, 0.3, 6)
        with self.assertRaisesRegex(TypeError, "no option 'wieghts'"):
            hetab.fit(measured, 1.5, slope="free", tau_um=3, wieghts="log")

    def test_audit(self):
        surface = hetab.Surface("BBQAL2")
        surface.wavelengths_um = [0.55]
        found = hetab.audit(surface)
        self.assertEqual(found.verdict, "pass")
        self.assertEqual(found.energy.shape, (1, len(found.theta_i)))
        self.assertLessEqual({c.verdict for c in found.checks}, {"pass"})
        self.assertLess(found.energy["dh"].max(), 1)


class Example(unittest.TestCase):
    def test_it_draws(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "src/python/example.py", folder], check=True,
                           env={**os.environ, "PYTHONPATH": "src/python"},
                           stdout=subprocess.DEVNULL)
            self.assertGreater(os.path.getsize(os.path.join(folder, "python.png")), 50_000)


class Wheel(unittest.TestCase):
    def test_it_stands_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["make", "-s", "wheel", f"BUILD={BUILD}", f"OUT={folder}"], check=True,
                           stdout=subprocess.DEVNULL)
            wheel, = (name for name in os.listdir(folder) if name.endswith(".whl"))
            with zipfile.ZipFile(os.path.join(folder, wheel)) as archive:
                archive.extractall(folder)
            environment = {k: v for k, v in os.environ.items() if k != "HETAB_LIBRARY"}
            program = "import hetab; print(hetab.__file__, hetab.Surface('NGGAL'))"
            said = subprocess.run(
                [sys.executable, "-c", program],
                env={**environment, "PYTHONPATH": folder}, cwd=folder, text=True, check=True,
                stdout=subprocess.PIPE).stdout
        self.assertIn("NGGAL", said)
        self.assertTrue(said.startswith(folder), said)


class Calls(unittest.TestCase):
    def test_failures_carry_the_library_s_message(self):
        for make, words in (
                (lambda: hetab.Surface("nope"), "no preset 'nope'"),
                (lambda: hetab.Surface(sigma0_um=-1, tau_um=3, index="Al"),
                 "^Surface: key sigma0_um"),
                (lambda: hetab.evaluate(hetab.Surface("BBQAL2").points(30, 0, 0)), "radians"),
                (lambda: hetab.Surface("BBQAL2").at(1e5), "extrapolate_index"),
                (lambda: hetab.evaluate(numpy.zeros(2, hetab.POINT)), "lambda")):
            with self.assertRaisesRegex(hetab.Error, words):
                make()
        with self.assertRaises(TypeError):
            hetab.Surface()

    def test_progress_and_stopping(self):
        surface, steps = hetab.Surface("BBQAL2"), []
        hetab.reflectance(surface, [0.1, 0.2],
                          progress=lambda done, total: steps.append(done / total))
        self.assertEqual((steps, steps[-1]), (sorted(steps), 1.0))
        with self.assertRaises(hetab.Error) as raised:
            hetab.tabulate(surface, progress=lambda done, total: True)
        self.assertEqual(raised.exception.status, "cancelled")
        with self.assertRaises(ZeroDivisionError):
            hetab.tabulate(surface, progress=lambda done, total: 1 / 0)
        self.assertEqual(len(hetab.reflectance(surface, [0.1])), 31)

    def test_interrupted(self):
        signal.signal(signal.SIGINT, signal.default_int_handler)  # which shells let background jobs ignore
        with self.assertRaises(KeyboardInterrupt):
            hetab.tabulate(hetab.Surface("BBQAL2"),
                           progress=lambda done, total: signal.raise_signal(signal.SIGINT))

    def test_the_interpreter_is_free_while_the_library_works(self):
        points = hetab.Surface("BBQAL2").points(0.3, numpy.linspace(0, 1.5, 20_000), 3.0)
        done, beats = threading.Event(), []
        worker = threading.Thread(target=lambda: (hetab.evaluate(points), done.set()))
        worker.start()
        while not done.wait(0.002):
            beats.append(time.monotonic())
        worker.join()
        self.assertGreater(len(beats), 5)

    def test_threads_at_once(self):
        points = hetab.Surface("BBQAL2").points(0.3, numpy.linspace(0, 1.5, 500), 3.0)
        expected, found = hetab.evaluate(points), [None] * 4
        threads = [threading.Thread(target=lambda i=i: found.__setitem__(i, hetab.evaluate(points)))
                   for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for values in found:
            numpy.testing.assert_array_equal(values, expected)

    def test_structures_are_those_of_the_headers(self):
        ffi = _library.ffi
        for dtype, name in ((hetab.POINT, "hetab_point"), (hetab.VALUE, "hetab_value"),
                            (hetab.REFLECTANCE, "hetab_reflectance"), (hetab.BAND, "hetab_band")):
            self.assertEqual(dtype.itemsize, ffi.sizeof(name))
        self.assertEqual(_library.words(ffi.typeof("hetab_verdict")),
                         {"pass": 0, "warn": 1, "fail": 2})


if __name__ == "__main__":
    result = unittest.main(exit=False, verbosity=0).result
    bad = len(result.failures) + len(result.errors)
    print(f"{result.testsRun - bad} passed, {bad} failed, 0 skipped")
    sys.exit(bad > 0)
