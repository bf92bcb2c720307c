"""Checks .bsdf files of hetab in Mitsuba 3; see scripts/test_renderers.

usage: verify.py HETAB FOLDER SURFACE...     FOLDER has SURFACE-rgb.bsdf and SURFACE-spectral.bsdf

Every surface, in the scalar variants: eval against the model, sample against pdf, a white furnace,
values at the horizon; and that damaged files are refused. Prints what was measured, and exits with
1 if a bound is missed. With DRJIT_LIBLLVM_PATH set, mitsuba.chi2 itself runs in the LLVM variants,
and a second furnace with the specular delta added.
"""
import ctypes
import json
import math
import multiprocessing
import os
import sys

import mitsuba as mi
import numpy

import chi_square
import evaluation
import furnace
from material import Material
from model import Model, srgb_weights

VARIANTS = ("rgb", "spectral")
PROCESSES = 2
CHI2 = ("scalar", "llvm")

BOUNDS = {                   # of what is printed
    "l1": 0.01,              # relative, the worst incidence up to 80 degrees
    "bias": 0.003,
    "ring": 0.005,           # relative: the bias of the reflectance, and the picture's noise
    "excess": 0.005,         # of the brightest pixel over what the model reflects, or 1: noise
    "rgb_bytes": 4_000_000,
}
SKY_DEG = tuple(range(90))
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])


def path_of(folder, surface, variant):
    return os.path.join(folder, f"{surface}-{variant}.bsdf")


def colour_weights():
    mi.set_variant("scalar_rgb")
    return srgb_weights(mi)


def evaluate(hetab, folder, surface):
    """{(surface, variant): measured} of eval."""
    model = Model(hetab, surface)
    about = json.loads(model.run("surfaces", surface, "--json"))
    pairs = evaluation.Pairs(model, evaluation.lobe_width(about["sigma0_um"], about["tau_um"]))
    weights, measured = colour_weights(), {}
    for variant in VARIANTS:
        mi.set_variant("scalar_" + variant)
        path = path_of(folder, surface, variant)
        material = Material(mi, path)
        errors = pairs.compare(material, weights)
        edge = evaluation.horizon_values(material)
        errors["bad"] += int(numpy.sum(~(numpy.isfinite(edge) & (edge >= 0))))
        measured[surface, variant] = {**errors, "bytes": os.path.getsize(path)}
    return measured


def sample(hetab, folder, surface):
    """{(surface, variant): measured} of sample, pdf and pictures."""
    model, weights, measured = Model(hetab, surface), colour_weights(), {}
    whole = weights @ model.reflectance(SKY_DEG, "rho_dh")
    reflectance = whole - weights @ model.reflectance(SKY_DEG, "rho_s")
    for variant in VARIANTS:
        mi.set_variant("scalar_" + variant)
        path = path_of(folder, surface, variant)
        # Outside 400-700 nm the spectral picture repeats the outer bands, which shifts its hue.
        views = numpy.eye(3) if variant == "rgb" else LUMINANCE[None]
        picture = furnace.render(mi, {"type": "measured", "filename": path})
        found = furnace.compare(picture, SKY_DEG, reflectance, views)
        found["scalar"] = chi_square.scalar_tests(mi, Material(mi, path))
        if "DRJIT_LIBLLVM_PATH" in os.environ:
            mi.set_variant("llvm_ad_" + variant)
            found["llvm"] = chi_square.llvm_tests(mi, path)
        measured[surface, variant] = found
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        path = path_of(folder, surface, "rgb")
        measured[surface, "rgb"]["whole"] = sample_whole(hetab, path, whole)
    return measured


def sample_whole(hetab, path, reflectance):
    """Rings of the furnace with the specular delta added, as the gallery does it."""
    sys.path.insert(0, os.path.join(os.path.dirname(hetab), "share/hetab/mitsuba"))
    mi.set_variant("llvm_ad_rgb")
    import he_torrance  # registers the material of that name
    picture = furnace.render(mi, {"type": "he_torrance", "filename": path})
    return furnace.compare(picture, SKY_DEG, reflectance, numpy.eye(3))["rings"]


def load_by_hetab(library, path):
    """Status of hetab_rgl_load: 0 if it loads."""
    context, table = ctypes.c_void_p(), ctypes.c_void_p()
    library.hetab_context_create(ctypes.byref(context))
    name = ctypes.c_char_p(os.fsencode(path))
    status = library.hetab_rgl_load(context, name, ctypes.byref(table))
    library.hetab_rgl_free(table)
    library.hetab_context_free(context)
    return status


def load_by_mitsuba(path):
    try:
        Material(mi, path)
    except RuntimeError:
        return 1
    return 0


def refusals(hetab, folder, surface):
    """The damaged copies that a reader loads as if nothing had happened."""
    mi.set_variant("scalar_rgb")
    library = ctypes.CDLL(os.path.join(os.path.dirname(os.path.abspath(hetab)), "libhetab.so"))
    with open(path_of(folder, surface, "rgb"), "rb") as file:
        data = file.read()
    damaged = {"truncated": data[:len(data) * 3 // 5], "magic": b"tensor_fist" + data[11:],
               "header": data[:40], "empty": b"",
               "renamed": data.replace(b"luminance", b"lumimance")}
    accepted = []
    for name, content in damaged.items():
        path = os.path.join(folder, f"damaged-{name}.bsdf")
        with open(path, "wb") as file:
            file.write(content)
        if load_by_hetab(library, path) == 0:
            accepted.append(f"{name}, by hetab")
        # Mitsuba maps the file and does not compare its length with the header.
        if name != "truncated" and load_by_mitsuba(path) == 0:
            accepted.append(f"{name}, by Mitsuba")
        os.remove(path)
    return accepted


# ---- verdicts ------------------------------------------------------------------------------------

def worst(values, theta_deg):
    k = int(numpy.argmax(numpy.abs(values)))
    return values[k], f"{theta_deg[k]:g}"


def summarise(variant, found, tables):
    """What the table prints, and the names of the bounds that are missed."""
    bounded = len(evaluation.BOUNDED_DEG)
    row = {"l1": worst(found["l1"][:bounded], evaluation.BOUNDED_DEG),
           "channel": worst(found["l1_channel"][:bounded], evaluation.BOUNDED_DEG),
           "bias": worst(found["bias"][:bounded], evaluation.BOUNDED_DEG),
           "l1_85": found["l1"][bounded], "ring": float(numpy.abs(found["rings"]).max()),
           "whole": float(numpy.abs(found["whole"]).max()) if "whole" in found else None}
    chi2 = {kind: chi_square.passes(found[kind], tables) for kind in CHI2 if kind in found}
    checks = {"L1": row["l1"][0] <= BOUNDS["l1"], "bias": abs(row["bias"][0]) <= BOUNDS["bias"],
              "chi2": all(passed == chi_square.COUNT for passed in chi2.values()),
              "furnace with specular": (row["whole"] or 0) <= BOUNDS["ring"],
              "furnace": row["ring"] <= BOUNDS["ring"] and
                         found["brightest"] <= max(1.0, found["reflects"]) + BOUNDS["excess"],
              "NaN or negative": found["bad"] == 0,
              "size": found["bytes"] <= BOUNDS.get(variant + "_bytes", math.inf)}
    return {**row, **chi2}, [name for name, fulfilled in checks.items() if not fulfilled]


def percent(value):
    return "-" if value is None else f"{value:.2%}"


def print_table(measured):
    print("surface  variant    bytes    L1 worst  band worst  bias worst  L1 at 85  chi2 scalar "
          " LLVM  furnace: rings  with delta  brightest  bad")
    missed = []
    for (surface, variant), found in measured.items():
        row, failures = summarise(variant, found, len(measured))
        (l1, at), (channel, channel_at), (bias, bias_at) = row["l1"], row["channel"], row["bias"]
        print(f"{surface:8s} {variant:8s} {found['bytes']:9d} {l1:6.2%} @{at:3s} "
              f"{channel:6.2%} @{channel_at:3s} {bias:+7.3%} @{bias_at:3s} {row['l1_85']:7.1%}  "
              f"{row['scalar']:6d}/{chi_square.COUNT} {row.get('llvm', '-'):>5}  "
              f"{row['ring']:12.2%} {percent(row['whole']):>11} "
              f"{found['brightest']:11.4f} {found['bad']:4d}")
        missed += [f"{surface} {variant}: {name}" for name in failures]
    return missed


def call(task):
    return task[0](*task[1:])


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    hetab, folder, surfaces = sys.argv[1], sys.argv[2], sys.argv[3:]
    tasks = [(job, hetab, folder, surface) for surface in surfaces for job in (evaluate, sample)]
    measured = {(surface, variant): {} for surface in surfaces for variant in VARIANTS}
    # Processes of their own: Mitsuba's threads do not survive a fork.
    with multiprocessing.get_context("spawn").Pool(PROCESSES) as pool:
        for answer in pool.imap_unordered(call, tasks):
            for key, found in answer.items():
                measured[key].update(found)
    missed = print_table(measured)
    missed += [f"damaged file loaded: {name}" for name in refusals(hetab, folder, surfaces[0])]
    for failure in missed:
        print("FAILED", failure)
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
