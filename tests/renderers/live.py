"""Checks the material he_torrance in Mitsuba 3, the model itself; see scripts/test_renderers.

usage: live.py HETAB         with the plugin in share/hetab/mitsuba beside it

eval against the printed equations, mitsuba.chi2, the reflectance of samples (a white furnace),
gradients of points against differences of the printed equations and of a rendering with a delta,
the scalar variants, and bad parameters. Prints what was measured and the speed beside
roughconductor's; exits with 1 if a bound is missed. Needs the LLVM variants."""
import math
import os
import sys
import time

import mitsuba as mi
import drjit as dr
import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/python"))
import hetab
from chi_square import SIGNIFICANCE, MirrorDomain

HETAB = os.path.abspath(sys.argv[1])
PLUGIN = os.path.join(os.path.dirname(HETAB), "share/hetab/mitsuba")
sys.path.insert(0, PLUGIN)

SURFACES = {"BBQAL1": (0.72, 5.6), "BBQAL2": (0.54, 6.5), "GGAL120": (0.42, 1.9),
            "NGGAL": (0.17, 5.0), "needle": (0.05, 60.0), "mirror": (0.02, 3.0),
            "rough": (5.0, 20.0), "steep": (1.0, 1.0), "small": (0.02, 0.2)}
CHI2_SURFACES = ("BBQAL1", "BBQAL2", "GGAL120", "NGGAL", "mirror", "steep")
CHI2_DEG, FURNACE_DEG = (0, 30, 60, 80), (0, 30, 60, 75, 85)
BOUNDS = {"eval": 5e-5, "furnace": 3e-3, "gradient": 1e-3, "model": 1e-4,
          "table": 2e-3}
N, K, UM = 1.44, 0.6, 0.55
missed = []


def judge(what, value, bound):
    print(f"{what}: {value:.2g}, bound {bound:g}")
    if not value <= bound:
        missed.append(what)


def material(name, **other):
    sigma0, tau = SURFACES[name]
    return {"type": "he_torrance", "sigma0": sigma0, "tau": tau, "n": N, "k": K, **other}


def interactions(wi, lambda_nm=1e3 * UM):
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wi))
    si.wi = wi
    if mi.is_spectral:
        si.wavelengths = mi.UnpolarizedSpectrum(lambda_nm)
    return si


def vectors(theta, phi):
    return numpy.stack([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi),
                        numpy.cos(theta)]).astype("f4")


def pairs(sigma0, tau, count, seed):
    """(wi, wo), most of them about the lobe, to 89.5 degrees, and the points that single floats
    make of them."""
    random, most = numpy.random.default_rng(seed), math.radians(89.5)
    theta_i = random.uniform(0, most, count)
    width = min(1.0, 2 * sigma0 / tau + UM / tau)
    near = random.random(count) < 0.7
    theta_r = numpy.where(near, theta_i + width * random.standard_normal(count),
                          random.uniform(0, most, count))
    theta_r = numpy.clip(theta_r, 0.0, most)
    phi = numpy.where(near, math.pi + width * random.standard_normal(count),
                      random.uniform(0, 2 * math.pi, count))
    wi, wo = vectors(theta_i, 0 * phi), vectors(theta_r, phi)
    points = numpy.zeros(count, hetab.POINT)
    exact = [w.astype("f8") for w in (wi, wo)]
    polar = [numpy.arctan2(numpy.hypot(w[0], w[1]), w[2]) for w in exact]
    points["theta_i"], points["theta_r"] = polar
    azimuth = [numpy.arctan2(w[1], w[0]) for w in exact]
    points["phi"] = azimuth[1] - azimuth[0]
    for field, value in (("lambda_um", UM), ("sigma0_um", sigma0), ("tau_um", tau), ("n", N),
                         ("k", K)):
        points[field] = value
    return wi, wo, points


def visible(points, values, part):
    """Where h is above a part of its peak."""
    import he_torrance as model
    h = [numpy.asarray(model.ln_h(model.Numpy, values["g"], x)) for x in (values["x"], 0.0)]
    return (h[0] - h[1] > math.log(part)) & (values["dd"] > 1e-12)


def evaluate():
    worst, compared = 0.0, 0
    for seed, (name, roughness) in enumerate(SURFACES.items()):
        wi, wo, points = pairs(*roughness, 4000, seed)
        exact = hetab.evaluate(points, literal=True)
        bsdf = mi.load_dict(material(name))
        found = numpy.array(bsdf.eval(mi.BSDFContext(), interactions(mi.Vector3f(wi)),
                                      mi.Vector3f(wo)))[0] / wo[2]
        shown = visible(points, exact, 1e-6)
        error = numpy.abs(found / numpy.maximum(exact["dd"], 1e-300) - 1)[shown].max()
        print(f"eval {name}: {error:.2g} worst of {shown.sum()}")
        worst, compared = max(worst, error), compared + int(shown.sum())
        if not (numpy.isfinite(found).all() and (found >= 0).all()):
            missed.append(f"eval {name}: NaN or negative")
    judge(f"eval, {compared} pairs on {len(SURFACES)} surfaces", worst, BOUNDS["eval"])


# ---- sampling --------------------------------------------------------------------------------

def chi2_test(bsdf, context, theta_deg, seed):
    from mitsuba.chi2 import ChiSquareTest
    theta = math.radians(theta_deg)
    wi = [math.sin(theta), 0.0, math.cos(theta)]
    domain = MirrorDomain(mi, dr, wi)

    def sample(uniform):
        si = interactions(dr.repeat(mi.Vector3f(wi), dr.width(uniform)))
        drawn, _ = bsdf.sample(context, si, uniform[0], mi.Point2f(uniform[1], uniform[2]))
        lobe = (drawn.sampled_type & mi.UInt32(int(mi.BSDFFlags.Delta))) == 0
        return drawn.wo, dr.select(lobe & (drawn.pdf > 0.0), 1.0, 0.0)

    def density(w):
        si = interactions(dr.repeat(mi.Vector3f(wi), dr.width(w)))
        return bsdf.pdf(context, si, w) * domain.solid_angle(w)

    test = ChiSquareTest(domain, sample, density, 3, 1_000_000, ires=32, seed=seed)
    test.run(quiet=True)
    return 0.0 if test.fail else float(test.p_value)


def chi2():
    """With the delta among the components, its samples left out, and without."""
    alone = mi.BSDFContext()
    alone.component = 0
    runs = [(name, theta, context, diffuse) for name in CHI2_SURFACES for theta in CHI2_DEG
            for context, diffuse in ((mi.BSDFContext(), 0.2), (alone, 0.0))]
    level = 1 - (1 - SIGNIFICANCE) ** (1 / len(runs))
    passed = 0
    for seed, (name, theta, context, diffuse) in enumerate(runs):
        bsdf = mi.load_dict(material(name, diffuse_reflectance=diffuse))
        p = chi2_test(bsdf, context, theta, seed)
        passed += p >= level
        if p < level:
            missed.append(f"chi2 {name} at {theta} degrees: p = {p:.2g}")
    print(f"chi2: {passed} of {len(runs)} pass")


def furnace():
    """The mean weight of samples, delta and diffuse part included, against rho_dh."""
    worst, count, lambdas = 0.0, 1 << 21, [0.45, 0.55, 0.65, 0.7]
    for name in CHI2_SURFACES:
        sigma0, tau = SURFACES[name]
        bsdf = mi.load_dict(material(name, diffuse_reflectance=0.1))
        surface = hetab.Surface(sigma0_um=sigma0, tau_um=tau, index={"n": N, "k": K},
                                diffuse_reflectance=0.1, wavelengths_nm=[450, 550, 650, 700])
        expected = [surface_reflectance(surface, math.radians(t)) for t in FURNACE_DEG]
        for theta_deg, truth in zip(FURNACE_DEG, expected):
            t, random = math.radians(theta_deg), mi.PCG32(count)
            si = interactions(dr.repeat(mi.Vector3f(math.sin(t), 0, math.cos(t)), count))
            si.wavelengths = mi.UnpolarizedSpectrum([1e3 * w for w in lambdas])
            u = [random.next_float32() for _ in range(3)]
            _, weight = bsdf.sample(mi.BSDFContext(), si, u[0], mi.Point2f(u[1], u[2]))
            found = numpy.array(dr.mean(weight, axis=1)).ravel()
            worst = max(worst, float(numpy.abs(found / truth - 1).max()))
    judge("furnace to 85 degrees, relative to rho_dh", worst, BOUNDS["furnace"])


def surface_reflectance(surface, theta):
    """rho_dh of each band from the printed equations, polar about the mirror point. (On the host:
    the devices' compiler is another LLVM than Mitsuba's.)"""
    nodes, weights = numpy.polynomial.legendre.leggauss(400)
    psi = (numpy.arange(720) + 0.5) * math.pi / 720
    centre = -math.sin(theta)
    reach = -centre * numpy.cos(psi) + numpy.sqrt(1 - (centre * numpy.sin(psi)) ** 2)
    t = 0.5 * (nodes + 1)
    rim, slope = 1 - (1 - t ** 2) ** 2, 4 * t * (1 - t ** 2)  # crowds at both ends of a ray
    r, w = rim * reach[:, None], 0.5 * weights * slope * reach[:, None]
    x, y = centre + r * numpy.cos(psi)[:, None], r * numpy.sin(psi)[:, None]
    theta_r = numpy.arcsin(numpy.minimum(numpy.hypot(x, y), 1.0))
    values = hetab.evaluate(surface.points(theta, theta_r, numpy.arctan2(y, x)), literal=True)
    dd = (values["total"] * (r * w)).sum(axis=(1, 2)) * 2 * math.pi / 720
    return dd + values["specular"][:, 0, 0]


# ---- gradients -------------------------------------------------------------------------------

def gradients():
    """Of eval at points, against central differences of the printed equations, relative to the
    largest of each parameter's over the lobe where it passes through 0."""
    worst = 0.0
    for name in ("BBQAL2", "NGGAL", "GGAL120"):
        wi, wo, points = pairs(*SURFACES[name], 3000, 11)
        points["diffuse_brdf"] = 0.1 / math.pi
        exact = hetab.evaluate(points, literal=True)
        shown = visible(points, exact, 1e-3)
        bsdf = mi.load_dict(material(name, diffuse_reflectance=0.1))
        parameters = mi.traverse(bsdf)
        for key, field, step in (("sigma0.value", "sigma0_um", 1e-4), ("tau.value", "tau_um", 1e-4),
                                 ("n", "n", 1e-4), ("k", "k", 1e-4),
                                 ("diffuse_reflectance.value", "diffuse_brdf", 1e-3)):
            dr.enable_grad(parameters[key])
            parameters.update()
            value = bsdf.eval(mi.BSDFContext(), interactions(mi.Vector3f(wi)), mi.Vector3f(wo))[0]
            dr.forward(parameters[key])
            found = numpy.array(dr.grad(value)) / wo[2]
            dr.disable_grad(parameters[key])
            sides, scale = [], math.pi if field == "diffuse_brdf" else 1.0
            for sign in (1, -1):
                moved = points.copy()
                moved[field] *= 1 + sign * step
                sides.append(hetab.evaluate(moved, literal=True)["total"])
            truth = (sides[0] - sides[1]) / (2 * step * points[field] * scale)
            size = numpy.maximum(numpy.abs(truth), exact["total"] / (points[field] * scale))
            error = (numpy.abs(found - truth) / size)[shown].max()
            print(f"gradient {name} by {field}: {error:.2g}")
            worst = max(worst, float(error))
    judge("gradients of points", worst, BOUNDS["gradient"])


def mirror_scene():
    """A plate that shows a lamp by its delta, to the whole picture."""
    look = mi.ScalarTransform4f().look_at
    return mi.load_dict({
        "type": "scene",
        "sensor": {"type": "perspective", "fov": 20,
                   "to_world": look([0, -3, 3], [0, 0, 0], [0, 0, 1]),
                   "film": {"type": "hdrfilm", "width": 16, "height": 16}},
        "lamp": {"type": "rectangle", "to_world": look([0, 3, 3], [0, 0, 0], [0, 0, 1]).scale(0.8),
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 2.0}}},
        "plate": {"type": "rectangle", "bsdf": {"type": "he_torrance", "sigma0": 0.06, "tau": 1.5,
                                                "material": "Al"}}})


def rendering():
    import he_torrance
    scene = mirror_scene()
    for name, right in (("path", True), ("prb", False)):
        print(f"{name}:")
        report = he_torrance.check(scene, mi.load_dict({"type": name, "max_depth": 3}), spp=256)
        if len(report) != 2 or any(row[-1] != right for row in report):
            missed.append(f"gradients of a rendering with a delta: {name}")


# ---- the rest --------------------------------------------------------------------------------

def scalar(bsdf, wi, wo):
    """eval, pdf and one sample of a scalar variant at pairs."""
    values, si = [], mi.SurfaceInteraction3f()
    if mi.is_spectral:
        si.wavelengths = [1e3 * UM] * 4
    for a, b in zip(wi.T.tolist(), wo.T.tolist()):
        si.wi = a
        w = mi.Vector3f(b)
        drawn, weight = bsdf.sample(mi.BSDFContext(), si, 0.3, [0.4, 0.6])
        values.append([bsdf.eval(mi.BSDFContext(), si, w)[0], bsdf.pdf(mi.BSDFContext(), si, w),
                       weight[0], drawn.pdf, drawn.wo.x])
    return numpy.array(values)


def arrays(bsdf, wi, wo):
    si, w, count = interactions(mi.Vector3f(wi)), mi.Vector3f(wo), wi.shape[1]
    drawn, weight = bsdf.sample(mi.BSDFContext(), si, dr.full(mi.Float, 0.3, count),
                                mi.Point2f(0.4, 0.6))
    columns = (bsdf.eval(mi.BSDFContext(), si, w)[0], bsdf.pdf(mi.BSDFContext(), si, w), weight[0],
               drawn.pdf, drawn.wo.x)
    return numpy.stack([numpy.array(c) for c in columns], axis=1)


def variants():
    """The scalar variants give what the arrays do."""
    wi, wo, _ = pairs(*SURFACES["BBQAL2"], 60, 5)
    for kind in ("rgb", "spectral"):
        found, table = {}, os.path.join(os.path.dirname(HETAB), f"mitsuba-tables/NGGAL-{kind}.bsdf")
        for mode, call in (("llvm_ad", arrays), ("scalar", scalar)):
            mi.set_variant(f"{mode}_{kind}")
            for what, properties in (("model", material("BBQAL2", diffuse_reflectance=0.1)),
                                     ("table", {"type": "he_torrance", "filename": table})):
                found[what, mode] = call(mi.load_dict(properties), wi, wo)
        for what in ("model", "table"):
            a, b = found[what, "llvm_ad"], found[what, "scalar"]
            error = (numpy.abs(a - b) / numpy.maximum(numpy.abs(b), 1e-4)).max()
            judge(f"scalar_{kind} against llvm_ad_{kind}, {what}", float(error), BOUNDS[what])


def refusals():
    for wrong, word in (({"sigma0": 0.5}, "tau"), ({"sigma0": 0.5, "tau": 3.0}, "material"),
                        ({"sigma0": 0.5, "tau": 3.0, "material": "Unobtainium"}, "Unobtainium"),
                        ({"sigma0": 0.5, "tau": 3.0, "material": "Al", "nodes": 7}, "nodes"),
                        ({"sigma0": -1, "tau": 3.0, "material": "Al"}, "sigma0 = -1"),
                        ({"sigma0": 0.5, "tau": 0, "material": "Al"}, "tau = 0"),
                        ({"sigma0": 0.5, "tau": 3.0, "n": 1.5, "k": -1.0}, "k = -1"),
                        ({"filename": __file__}, "no .bsdf table")):
        try:
            mi.load_dict({"type": "he_torrance", **wrong})
            missed.append(f"accepted: {wrong}")
        except Exception as error:  # of whatever kind Mitsuba makes of it
            if word not in str(error):
                missed.append(f"{wrong}: '{error}' does not say '{word}'")


def speed():
    """Seconds of a picture over roughconductor's in the same run; printed, not judged."""
    def scene(bsdf):
        return mi.load_dict({
            "type": "scene", "integrator": {"type": "path", "max_depth": 4},
            "sensor": {"type": "perspective", "fov": 35,
                       "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
                       "film": {"type": "hdrfilm", "width": 256, "height": 256},
                       "sampler": {"type": "independent", "sample_count": 32}},
            "sky": {"type": "constant"},
            "lamp": {"type": "sphere", "center": [2, 3, 3], "radius": 0.5,
                     "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 20.0}}},
            "ball": {"type": "sphere", "bsdf": bsdf}})

    scenes = [scene({"type": "roughconductor", "material": "Al", "alpha": 0.166}),
              *(scene({"type": "he_torrance", "sigma0": 0.54, "tau": 6.5, "material": "Al",
                       "nodes": nodes}) for nodes in (8, 16))]
    seconds = []
    for seed in range(6):
        row = []
        for one in scenes:
            start = time.perf_counter()
            dr.eval(mi.render(one, seed=seed))
            dr.sync_thread()
            row.append(time.perf_counter() - start)
        seconds.append(row)
    ratios = numpy.array(seconds[1:])
    ratios = numpy.median(ratios / ratios[:, :1], axis=0)
    print(f"time over roughconductor's, {mi.variant()}: {ratios[1]:.2f} with 8 nodes, "
          f"{ratios[2]:.2f} with 16 (spectral: without)")


def main():
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        print("skip: he_torrance's tests need Debian's libllvm19, which could not be downloaded")
        return
    mi.set_variant("llvm_ad_rgb")
    import he_torrance  # registers itself for this variant
    mi.set_variant("llvm_ad_spectral")
    for part in (evaluate, chi2, furnace, gradients, speed):
        part()
    mi.set_variant("llvm_ad_rgb")
    for part in (speed, rendering, refusals):
        part()
    variants()
    for what in missed:
        print(f"MISSED {what}")
    sys.exit(bool(missed))


main()
