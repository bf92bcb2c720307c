#!/usr/bin/python3
"""A sheet of spheres from a batch's tables for Mitsuba: each alone in a small studio, by path tracing with hetab's
look-ups, which read .bsdf tables as Mitsuba does, and the delta beside them.

usage: sheet.py BUILD FOLDER OUT.png [SAMPLES]     FOLDER of a sweep over index, sigma0_um and tau_um"""
import json
import os
import re
import sys

build, folder, out = sys.argv[1:4]
os.environ["HETAB_LIBRARY"] = os.path.join(build, "libhetab.so")
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../src/python"))

import matplotlib
import numpy

import hetab

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

SIDE, SAMPLES, TAUS = 64, int((sys.argv[4:] or ["64"])[0]), 2  # of each metal


def studio(d):
    """Radiance from directions d[..., 3]; z is up, y away from the camera."""
    azimuth, height = numpy.degrees(numpy.arctan2(d[..., 0], -d[..., 1])), numpy.degrees(numpy.arcsin(numpy.clip(d[..., 2], -1, 1)))
    t = numpy.sqrt(numpy.maximum(d[..., 2:], 0))
    light = numpy.array([0.5, 0.53, 0.58]) * (1 - t) + numpy.array([0.05, 0.07, 0.12]) * t
    ground = d[..., :2] / numpy.minimum(d[..., 2:], -0.02)
    squares = numpy.where((numpy.floor(1.5 * ground[..., :1]) + numpy.floor(1.5 * ground[..., 1:])) % 2, 0.35, 0.06)
    far = numpy.exp(-0.12 * numpy.sum(ground**2, axis=-1, keepdims=True))
    light = numpy.where(d[..., 2:] < 0, squares * far + 0.18 * (1 - far), light)
    for a, b, low, high, bright in (-65, -15, 25, 62, [11, 10.3, 9]), (55, 80, -5, 60, [2.2, 2.8, 4]):
        box = (azimuth > a) & (azimuth < b) & (height > low) & (height < high)
        light = numpy.where(box[..., None], bright, light)
    return light


def sphere(path, random):
    """[SIDE, SIDE, 4]: linear sRGB and coverage."""
    table = hetab.open_table(path)
    x, z = (random.random((2, SIDE, SIDE, SAMPLES)) + numpy.mgrid[:SIDE, :SIDE][::-1, ..., None]) * 2.1 / SIDE - 1.05
    z, inside = -z, x * x + z * z < 0.9999
    n = numpy.stack([x, -numpy.sqrt(numpy.where(inside, 1 - x * x - z * z, 1)), z], axis=-1)[inside]
    cosine = -n[:, 1]
    towards = numpy.array([0.0, -1.0, 0.0])
    # In the normal's frame, whose x is along the view, the view is (sine, 0, cosine).
    sine = numpy.sqrt(1 - cosine**2)
    along = (towards - cosine[:, None] * n) / numpy.maximum(sine, 1e-6)[:, None]
    along[sine < 1e-6] = [1, 0, 0]
    wi = numpy.stack([sine, 0 * sine, cosine], axis=-1).astype("f4")
    # Evenly spread over a pixel's samples (the additive sequence of the plastic number).
    even = numpy.arange(SAMPLES)[:, None] * [0.7548776662466927, 0.5698402909980532]
    u = (even + random.random((SIDE, SIDE, 1, 2)))[inside] % 1
    drawn, weight = table.sample(wi, random.random(len(n), dtype="f4"), numpy.minimum(u, 0.9999999).astype("f4"))
    wo, weight = drawn["wo"], numpy.where(drawn["lobe"][:, None] > 0, weight, 0)
    d = wo[:, :1] * along + wo[:, 1:2] * numpy.cross(n, along) + wo[:, 2:] * n
    light = numpy.zeros((SIDE, SIDE, SAMPLES, 3))
    light[inside] = numpy.minimum(weight * studio(d), 12)
    return numpy.concatenate([light.mean(axis=2), inside.mean(axis=2)[..., None]], axis=2)


def chosen():
    """(metals, sigma0s, {(metal, tau): names by sigma0}) of TAUS values of tau for each metal."""
    with open(os.path.join(folder, "manifest.json")) as file:
        names = {line["surface"] for line in json.load(file)}
    found = [re.fullmatch(r"(\w+)_s([\d.]+)_t([\d.]+)", name).groups() for name in names]
    taus = sorted({float(t) for _, _, t in found})
    taus = [taus[(2 * k + 1) * len(taus) // (2 * TAUS)] for k in range(TAUS)]
    rows = {}
    for metal, sigma0, tau in found:
        if float(tau) in taus:
            rows.setdefault((metal, float(tau)), {})[float(sigma0)] = f"{metal}_s{sigma0}_t{tau}"
    return dict(sorted(rows.items()))


def table_of(name):
    with open(os.path.join(folder, name + ".json")) as file:
        return os.path.join(folder, json.load(file)["table_of"] + ".bsdf")


def main():
    rows, random = chosen(), numpy.random.default_rng(1)
    sigma0s = sorted(next(iter(rows.values())))
    picture = numpy.zeros((len(rows) * SIDE, len(sigma0s) * SIDE, 3))
    for r, (row, names) in enumerate(rows.items()):
        for c, sigma0 in enumerate(sigma0s):
            drawn = sphere(table_of(names[sigma0]), random)
            tone = 1 - numpy.exp(-1.2 * drawn[..., :3])
            srgb = numpy.where(tone < 0.0031308, 12.92 * tone, 1.055 * tone ** (1 / 2.4) - 0.055)
            at = numpy.s_[r * SIDE:(r + 1) * SIDE, c * SIDE:(c + 1) * SIDE]
            picture[at] = 0.11 * (1 - drawn[..., 3:]) + srgb * (drawn[..., 3:] > 0)
    height, width = picture.shape[0] + 60, picture.shape[1] + 90
    figure = plt.figure(figsize=(width / 100, height / 100), dpi=100, facecolor="0.11")
    axes = figure.add_axes((85 / width, 10 / height, picture.shape[1] / width, picture.shape[0] / height))
    axes.imshow(numpy.clip(picture, 0, 1), interpolation="nearest")
    axes.set_xticks([SIDE * (c + 0.5) for c in range(len(sigma0s))], [f"{s:.3g}" for s in sigma0s])
    axes.set_yticks([SIDE * (r + 0.5) for r in range(len(rows))], [f"{m}, {t:.3g}" for m, t in rows])
    axes.tick_params(length=0, colors="0.8", labelsize=9, labeltop=True, labelbottom=False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.text(0.5, 1 - 14 / height, "sigma0, um (rows: metal, tau in um)", color="0.8", ha="center", va="center", fontsize=9)
    figure.savefig(out, facecolor="0.11")
    Image.open(out).convert("RGB").quantize(256).save(out, optimize=True)
    print(f"{out}: {len(rows) * len(sigma0s)} spheres")


main()
