@he_torrance.py@

# ==== Mitsuba 3 ===============================================================================
# mi.set_variant("llvm_ad_rgb"); import he_torrance
# mi.load_dict({"type": "he_torrance", "sigma0": 0.54, "tau": 6.5, "material": "Al"})
#
# sigma0, tau            um: numbers or textures
# material               a built-in metal, or a CSV of wavelength_nm,n,k; or n and k: numbers
# diffuse_reflectance    a number, colour or texture
# nodes                  wavelengths behind an RGB colour: 8 (within 0.6 %) or 16 (0.05 %)
# filename               instead of all these: a .bsdf table, with the delta from the
#                        NAME.specular.csv beside it
#
# Components: 0 the directional-diffuse lobe, 1 the specular delta, 2 the uniform-diffuse term (of a
# table: 0 and 1). Samples carry values with gradients over densities without: see check().

import os

import drjit as dr
import mitsuba as mi

HERO_UM, DELTA_UM = 0.6, 0.7  # the lobe that is sampled; where the delta is taken as large
NODES_NM = 400.0 + 10.0 * numpy.arange(31)


def arithmetic():
    """Of the variant that is set."""
    if mi.variant().startswith("scalar"):
        return Numpy
    runs = mi.Float(RUNS.ravel())

    class DrJit:
        sqrt, exp, log, cos, sin = dr.sqrt, dr.exp, dr.log, dr.cos, dr.sin
        minimum, maximum, where, detach = dr.minimum, dr.maximum, dr.select, dr.detach

        @staticmethod
        def cell(place):
            cell = dr.detach(dr.clip(dr.floor(place), 0.0, CELLS - 1.0))
            return cell, mi.UInt32(cell)

        @staticmethod
        def run(row, column):
            return dr.gather(mi.Vector4f, runs, row * RUNS.shape[1] + column)

        @staticmethod
        def repeat(state, go_on, step):
            return dr.while_loop(state, go_on, step, mode="symbolic")

    return DrJit


def read_index(path):
    """n and k at NODES_NM from a CSV of wavelength_nm,n,k."""
    rows = numpy.genfromtxt(path, delimiter=",", names=True)
    if not {"wavelength_nm", "n", "k"} <= set(rows.dtype.names or ()):
        raise ValueError(f"he_torrance: {path}: no columns wavelength_nm, n and k: 'hetab surfaces "
                         "Al' writes such a file")
    return [numpy.interp(NODES_NM, rows["wavelength_nm"], rows[c]) for c in ("n", "k")]


def index_of(props):
    """n and k: lists over NODES_NM, or of one number."""
    if props.has_property("material"):
        material = props["material"]
        if material in METALS:
            return METALS[material]["n"], METALS[material]["k"]
        if os.path.exists(material):
            return read_index(material)
        raise ValueError(f"he_torrance: no material '{material}': give {', '.join(METALS)}, a CSV "
                         "file, or n and k")
    if props.has_property("n"):
        return [props["n"]], [props.get("k", 0.0)]
    if SURFACE:
        return [numpy.interp(NODES_NM, SURFACE["wavelengths_nm"], SURFACE[c]) for c in ("n", "k")]
    raise ValueError("he_torrance: no material: give a metal's symbol, or n and k")


def define():
    """Registers the material for the variant that is set."""
    N, scalar = arithmetic(), mi.variant().startswith("scalar")
    spectral = "spectral" in mi.variant()
    if "polarized" in mi.variant() or "mono" in mi.variant():
        return
    number, yes = (float, bool) if scalar else (mi.Float, mi.Bool)
    glossy, delta, diffuse = (mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DeltaReflection,
                              mi.BSDFFlags.DiffuseReflection)

    def mirrored(w):
        return mi.Vector3f(-w.x, -w.y, w.z)

    def direction(si, sigma0, tau):
        return Direction(N, si.wi.z, N.sqrt(si.wi.x * si.wi.x + si.wi.y * si.wi.y),
                         tau / (2.0 * sigma0))

    def colour(nodes, values):
        return mi.Color3f(*(number(sum(node[1 + c] * v for node, v in zip(nodes, values)))
                            for c in range(3)))

    class Delta(mi.BSDF):
        """What materials with a delta as component 1 have in common."""

        def enabled(self, ctx):
            return [ctx.is_enabled(mi.BSDFFlags(flags & int(mi.BSDFFlags.All)), i)
                    for i, flags in enumerate(self.m_components)]

        def finish(self, si, chance, is_delta, rho, wo, value, density, active):
            """The sample: a delta where is_delta, else a direction of this value and density."""
            bs = mi.BSDFSample3f()
            bs.wo = dr.select(is_delta, mirrored(si.wi), wo)
            bs.pdf = dr.select(is_delta & active, number(chance), number(density))
            bs.eta = 1.0
            bs.sampled_type = dr.select(is_delta, int(delta), int(glossy))
            bs.sampled_component = dr.select(is_delta, 1, 0)
            good = active & (bs.pdf > 0.0)
            weight = dr.select(is_delta, rho, value) / dr.maximum(bs.pdf, 1e-30)
            return bs, dr.select(good, weight, 0.0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    class Model(Delta):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            known = SURFACE or {}
            self.sigma0 = props.get_unbounded_texture("sigma0", known.get("sigma0_um", 0.0))
            self.tau = props.get_unbounded_texture("tau", known.get("tau_um", 0.0))
            if not (props.has_property("sigma0") and props.has_property("tau") or SURFACE):
                raise ValueError("he_torrance: give sigma0 and tau, in um")
            for name, limit in (("sigma0", 0.0), ("tau", 0.0), ("n", 0.0), ("k", -1e-30)):
                value = props[name] if props.has_property(name) else 1.0
                if isinstance(value, (int, float)) and not limit < value < math.inf:
                    raise ValueError(f"he_torrance: {name} = {value:g}: give a number "
                                     f"{'of at least' if limit else 'above'} 0"
                                     f"{', in um' if name in ('sigma0', 'tau') else ''}")
            self.diffuse = props.get_texture("diffuse_reflectance", 0.0)
            self.nodes = COLOUR_NODES.get(str(props.get("nodes", 8)))
            if not self.nodes:
                raise ValueError("he_torrance: nodes is 8 or 16")
            self.n, self.k = ([float(v) for v in values] if scalar else
                              mi.Float([float(v) for v in values]) for values in index_of(props))
            side = mi.BSDFFlags.FrontSide | (mi.BSDFFlags.SpatiallyVarying if any(
                t.is_spatially_varying() for t in (self.sigma0, self.tau)) else 0)
            self.m_components = [int(kind | side) for kind in (glossy, delta, diffuse)]
            self.m_flags = self.m_components[0] | self.m_components[1] | self.m_components[2]

        def traverse(self, callback):
            for name in ("sigma0", "tau", "n", "k"):
                callback.put(name, getattr(self, name), mi.ParamFlags.Differentiable)
            callback.put("diffuse_reflectance", self.diffuse, mi.ParamFlags.Differentiable)

        # ---- values

        def roughness(self, si, active):
            return (N.maximum(t.eval_1(si, active), 1e-4) for t in (self.sigma0, self.tau))

        def index(self, nm):
            """n and k, linear between the nodes and held beyond."""
            if len(self.n) == 1:
                return (self.n[0], self.k[0]) if scalar else (self.n, self.k)
            place = dr.clip((nm - 400.0) / 10.0, 0.0, 30.0)
            read = (lambda v, i: v[i]) if scalar else (
                lambda v, i: dr.gather(mi.Float, v, mi.UInt32(i)))
            if isinstance(nm, float) and nm % 10.0 == 0.0:
                return tuple(read(v, int(place)) for v in (self.n, self.k))
            left = min(int(place), 29) if scalar else dr.minimum(mi.UInt32(place), 29)
            f = place - left
            return tuple(read(v, left) * (1.0 - f) + read(v, left + 1) * f
                         for v in (self.n, self.k))

        def spectrum(self, si, at):
            """at(lambda in um, n, k), as the variant's colours."""
            if spectral:
                lanes = [dr.clip(w, 100.0, 1e5) for w in si.wavelengths]
                return mi.Spectrum([number(at(1e-3 * w, *self.index(w))) for w in lanes])
            values = [at(1e-3 * node[0], *self.index(float(node[0]))) for node in self.nodes]
            return dr.maximum(colour(self.nodes, values), 0.0)

        def lobe(self, si, wo, roughness):
            pair = Pair(N, si.wi, wo, *roughness)
            return self.spectrum(si, lambda *wave: directional_diffuse(N, pair, *roughness, *wave))

        def reflected(self, si, roughness):
            i = direction(si, *roughness)
            return self.spectrum(si, lambda *wave: specular(N, i, *roughness, *wave))

        def eval(self, ctx, si, wo, active=True):
            on = self.enabled(ctx)
            active &= (si.wi.z > 0.0) & (wo.z > 0.0)
            value = mi.Spectrum(0.0)
            if on[0]:
                value += self.lobe(si, wo, tuple(self.roughness(si, active)))
            if on[2]:
                value += self.diffuse.eval(si, active) / math.pi
            return dr.select(active, value * wo.z, 0.0)

        # ---- sampling, without gradients

        def plan(self, ctx, si, active):
            """(lobes, chances of the three components) from what each reflects."""
            sigma0, tau = self.roughness(si, active)
            i, on = direction(si, sigma0, tau), self.enabled(ctx)
            n, k = self.index(1e3 * HERO_UM)
            polished = fresnel(N, i.mu * i.mu, n, k)
            rho = specular(N, i, sigma0, tau, DELTA_UM, n, k)
            rho = N.where(rho > 1e-6, N.maximum(rho, 0.01), 0.0) if on[1] else 0.0 * rho
            lobe = N.maximum(polished - rho, 0.02) if on[0] else 0.0 * rho
            ud = dr.mean(self.diffuse.eval(si, active)) if on[2] else 0.0 * rho
            total = N.maximum(rho + lobe + ud, 1e-9)
            lobes = Lobes(N, si.wi, i, sigma0, tau, HERO_UM)
            return lobes, lobe / total, rho / total, ud / total

        def density(self, lobes, chances, wo, active):
            value = chances[0] * lobes.density(wo) + chances[2] * wo.z / math.pi
            return dr.select(active & (wo.z > 0.0), number(value), 0.0)

        def pdf(self, ctx, si, wo, active=True):
            with dr.suspend_grad():
                active &= si.wi.z > 0.0
                lobes, *chances = self.plan(ctx, si, active)
                return self.density(lobes, chances, wo, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            active &= si.wi.z > 0.0
            with dr.suspend_grad():
                lobes, *chances = self.plan(ctx, si, active)
                is_delta = active & yes(sample1 < chances[1])
                of_lobe = yes(sample1 < chances[1] + chances[0])
                rest = (sample1 - chances[1]) / N.maximum(chances[0], 1e-9)
                drawn, good = lobes.sample(N.minimum(N.maximum(rest, 0.0), 1.0 - 1e-7), *sample2)
                wo = dr.select(of_lobe, mi.Vector3f(*map(number, drawn)),
                               mi.warp.square_to_cosine_hemisphere(sample2))
                good = is_delta | yes(sample1 >= chances[1] + chances[0]) | yes(good)
                density = self.density(lobes, chances, wo, active)
            rho = self.reflected(si, tuple(self.roughness(si, active)))
            value = self.eval(ctx, si, wo, active & good)
            return self.finish(si, chances[1], is_delta, rho, wo, value, density, active & good)

        def to_string(self):
            return f"HeTorrance[sigma0={self.sigma0}, tau={self.tau}, diffuse={self.diffuse}]"

    class Table(Delta):
        """A .bsdf by Mitsuba's `measured`, and its delta."""
        ANGLES = 361  # of rho_s in theta, linear between them

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            path = str(mi.file_resolver().resolve(props["filename"]))
            with open(path, "rb") as file:
                head = file.read(2048)
            if not head.startswith(b"tensor_file"):
                raise ValueError(f"he_torrance: {path} is no .bsdf table: 'hetab tabulate SURFACE "
                                 "-o NAME.bsdf' writes one")
            self.table = mi.load_dict({"type": "measured", "filename": path})
            folded = b"specular_cone_deg" in head  # the delta is in the table
            if folded:
                self.nm = numpy.array([550.0]) if spectral else None
                self.rho = numpy.zeros((1 if spectral else 3, self.ANGLES))
            else:
                self.nm, self.rho = self.read(os.path.splitext(path)[0] + ".specular.csv")
            flat = numpy.ascontiguousarray(self.rho.T, "f4").ravel()
            self.rho = [float(v) for v in flat] if scalar else mi.Float(flat)
            side = mi.BSDFFlags.FrontSide
            self.m_components = [int(glossy | side), int(delta | side)]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def read(self, path):
            """Wavelengths and rho_s[wavelength][angle]; of RGB, the three channels."""
            rows = numpy.genfromtxt(path, delimiter=",", names=True)
            nm, theta = numpy.unique(rows["wavelength_nm"]), numpy.linspace(0.0, 90.0, self.ANGLES)
            bands = [rows[rows["wavelength_nm"] == w] for w in nm]
            rho = numpy.array([numpy.interp(theta, b["theta_i_deg"], b["rho_s"]) for b in bands])
            if spectral:
                return nm, rho
            nodes = numpy.array(COLOUR_NODES["16"])
            at = [[numpy.interp(w, nm, column) for w in nodes[:, 0]] for column in rho.T]
            return None, numpy.clip(numpy.array(at) @ nodes[:, 1:], 0.0, 1.0).T

        def reflected(self, si):
            channels = 3 if self.nm is None else len(self.nm)
            place = dr.safe_acos(si.wi.z) * (2.0 / math.pi) * (self.ANGLES - 1.0)
            place = dr.clip(place, 0.0, self.ANGLES - 1.0)
            left = (min(int(place), self.ANGLES - 2) if scalar else
                    dr.minimum(mi.UInt32(place), self.ANGLES - 2))
            f = place - left
            read = (lambda i: self.rho[i]) if scalar else lambda i: dr.gather(mi.Float, self.rho, i)

            def at(channel):
                first = left * channels + channel
                return read(first) * (1.0 - f) + read(first + channels) * f

            if self.nm is None:
                return mi.Color3f(*(number(at(c)) for c in range(3)))
            return mi.Spectrum([number(self.between(at, w)) for w in si.wavelengths])

        def between(self, at, nm):
            """Linear between the wavelengths, which are equally spaced, and held beyond."""
            count = len(self.nm)
            if count == 1:
                return at(0)
            step = (self.nm[-1] - self.nm[0]) / (count - 1)
            place = dr.clip((nm - float(self.nm[0])) / float(step), 0.0, count - 1.0)
            left = (min(int(place), count - 2) if scalar else
                    dr.minimum(mi.UInt32(place), count - 2))
            return at(left) * (1.0 - (place - left)) + at(left + 1) * (place - left)

        def chance(self, ctx, rho):
            on = self.enabled(ctx)
            mean = dr.mean(rho)
            usual = dr.select(mean > 1e-5, dr.clip(mean, 0.02, 0.95), 0.0)
            return usual if on[0] and on[1] else dr.select(mean >= 0.0, float(on[1]), 0.0)

        def eval(self, ctx, si, wo, active=True):
            return self.table.eval(mi.BSDFContext(), si, wo, active) if self.enabled(ctx)[0] else (
                mi.Spectrum(0.0))

        def pdf(self, ctx, si, wo, active=True):
            return self.table.pdf(mi.BSDFContext(), si, wo, active) * (
                1.0 - self.chance(ctx, self.reflected(si)))

        def sample(self, ctx, si, sample1, sample2, active=True):
            active &= si.wi.z > 0.0
            rho = self.reflected(si)
            chance = self.chance(ctx, rho)
            is_delta = active & (sample1 < chance)
            bs, weight = self.table.sample(mi.BSDFContext(), si, sample1, sample2, active)
            density = bs.pdf * (1.0 - chance)
            return self.finish(si, chance, is_delta, rho, bs.wo, weight * bs.pdf, density, active)

        def to_string(self):
            return f"HeTorrance[{self.table}]"

    mi.register_bsdf("he_torrance", lambda props: (
        Table if props.has_property("filename") else Model)(props))


def check(scene, integrator, spp=64, runs=10, step=0.02):
    """Whether an integrator's gradients are right in a scene: the derivative of the mean pixel by
    every sigma0 and tau of a he_torrance in it, from forward differentiation and from differences
    of pictures (relative steps). Prints and returns [(parameter, gradient, difference, standard
    error of their difference, right)].

    A delta is not in eval(), from which `prb` and its kin replay their paths: with one in the scene
    their gradients are wrong, in sign too. `path` and `direct`, which differentiate the samples'
    weights, are right."""
    parameters, report = mi.traverse(scene), []

    def mean(seed):
        picture = mi.render(scene, parameters, integrator=integrator, spp=spp, seed=seed)
        return dr.mean(picture, axis=None)

    for key in parameters.keys():
        if not key.endswith(("sigma0.value", "tau.value")):
            continue
        value, gradients, differences = type(parameters[key])(parameters[key]), [], []
        for seed in range(runs):
            parameters[key] = dr.opaque(type(value), float(value[0]))
            dr.enable_grad(parameters[key])
            parameters.update()
            found = mean(seed)
            dr.forward(parameters[key])
            gradients.append(float(dr.grad(found).array[0]))
            sides = []
            for scale in (1.0 + step, 1.0 - step):
                parameters[key] = dr.opaque(type(value), scale * float(value[0]))
                parameters.update()
                sides.append(float(mean(seed).array[0]))
            differences.append((sides[0] - sides[1]) / (2.0 * step * float(dr.mean(value)[0])))
        parameters[key] = dr.detach(value)
        parameters.update()
        gradient, difference = numpy.mean(gradients), numpy.mean(differences)
        error = math.hypot(numpy.std(gradients), numpy.std(differences)) / math.sqrt(runs - 1.0)
        right = abs(gradient - difference) <= 4.0 * error + 1e-3 * abs(difference)
        report.append((key, gradient, difference, error, bool(right)))
        print(f"{key}: gradient {gradient:+.4g}, difference {difference:+.4g}, noise {error:.2g}: "
              f"{'right' if right else 'WRONG'}")
    return report


if mi.variant():
    define()
mi.detail.add_variant_callback(lambda old, new: define() if new else None)
