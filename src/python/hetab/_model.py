"""The model: at points, over hemispheres, as tables."""
from __future__ import annotations

import os
from collections.abc import Callable

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import (NULL, Record, address, call, create, doubles, dtype, ffi, lib, local,
                       options, record)
from ._surface import POINT, Surface

VALUE = dtype("hetab_value")
REFLECTANCE = dtype("hetab_reflectance")
AXES = ("theta_i", "theta_r", "phi")

Progress = Callable[[float, float], object]


def engine(precision="double", method="rows", device=None, tolerance=0.0):
    """The thread's engine: kernels are compiled once for each choice."""
    engines = local.__dict__.setdefault("engines", {})
    key = precision, method, device, tolerance
    if key not in engines:
        engines[key] = create("engine", lib.hetab_engine_create, options(
            "hetab_engine_options", precision=precision, method=method, devices=device,
            tolerance=tolerance))
    return engines[key]


def evaluate(points: NDArray, *, literal: bool = False, precision: str = "double",
             device: str | None = None) -> NDArray:
    """The model at points, as Surface.points() makes them (or any array of dtype hetab.POINT:
    lambda_um, theta_i, theta_r, phi in radians, sigma0_um, tau_um, n, k, diffuse_brdf in 1/sr).

    Returns an array of the points' shape with fields dd, ud and total = dd + ud (BRDF, 1/sr),
    specular (the delta's reflectance rho_s), g and x. Error: 1e-12 relative in double, 1e-5 with
    precision="float" (include/hetab/evaluate.h). literal: the printed equations, on the host."""
    points = numpy.ascontiguousarray(points, dtype=POINT)
    values = numpy.empty(points.shape, VALUE)
    arguments = (address(points), points.size, address(values))
    if literal:
        call(lib.hetab_evaluate_literal, *arguments)
    else:
        call(lib.hetab_evaluate, engine(precision, device=device), *arguments)
    return values


def reflectance(surface: Surface, theta_i: ArrayLike, *, tolerance: float = 0.0,
                precision: str = "double", device: str | None = None,
                progress: Progress | None = None) -> NDArray:
    """Directional-hemispherical reflectance at theta_i (radians, any shape): [band, *theta_i] with
    fields dh = dd + specular + ud, dd (fields value, error), specular, ud, and fresnel, that of
    the polished material. tolerance: relative, of dd; 0: 1e-9 in double, 1e-5 in float."""
    angles = numpy.asarray(theta_i, "f8")
    array, pointer = doubles(angles.ravel())
    out = numpy.empty((len(surface.bands),) + angles.shape, REFLECTANCE)
    call(lib.hetab_reflectance_dh, engine(precision, device=device), surface._handle, pointer,
         len(array), tolerance, address(out), progress=progress)
    return out


def grid_of(axes):
    grid = create("grid", lib.hetab_grid_create)
    for i, axis in enumerate(axes):
        if isinstance(axis, str):
            call(lib.hetab_grid_set_axis, grid, i, axis.encode())
        elif axis is not None:
            array, pointer = doubles(axis)
            call(lib.hetab_grid_set_values, grid, i, pointer, len(array))
    return grid


def tabulate(surface: Surface, theta_i_deg: str | ArrayLike | None = None,
             theta_r_deg: str | ArrayLike | None = None, phi_deg: str | ArrayLike | None = None, *,
             precision: str = "float", method: str = "rows", device: str | None = None,
             tolerance: float = 0.0, samples: int = 2000, seed: int = 0,
             progress: Progress | None = None) -> Record:
    """The surface over a grid: brdf[wavelength, theta_i, theta_r, phi], dd + ud in 1/sr, with the
    axes wavelengths_um, theta_i_deg, theta_r_deg, phi_deg, the delta's specular[wavelength,
    theta_i], and report, whose error was measured against the literal equations. Axes: arrays in
    degrees, or the words of `hetab tabulate` ("0:90:46", "cells:90"); None: 90, 90 and 181 angles
    over the whole range."""
    grid = grid_of((theta_i_deg, theta_r_deg, phi_deg))
    axes = [numpy.frombuffer(ffi.buffer(lib.hetab_grid_deg(grid, i),
                                        8 * lib.hetab_grid_count(grid, i))).copy()
            for i in range(3)]
    brdf = numpy.empty([len(surface.bands)] + [len(axis) for axis in axes],
                       "f4" if precision == "float" else "f8")

    @ffi.callback("hetab_slab_fn", error=lib.HETAB_ERR_ARGUMENT)
    def take(ctx, user, slab):
        part = brdf[slab.wavelength, slab.theta_i_first:slab.theta_i_first + slab.theta_i_count]
        ffi.memmove(ffi.from_buffer(part), slab.values, part.nbytes)
        return lib.HETAB_OK

    report = ffi.new("hetab_report *")
    call(lib.hetab_tabulate, engine(precision, method, device, tolerance), surface._handle, grid,
         options("hetab_tabulate_options", samples=samples, seed=seed), take, NULL, report,
         progress=progress)
    return Record(brdf=brdf, wavelengths_um=surface.wavelengths_um,
                  **{f"{name}_deg": axis for name, axis in zip(AXES, axes)},
                  specular=specular_reflectance(surface, numpy.radians(axes[0])),
                  report=record(report, {}))


def tabulate_to(surface: Surface, *paths: str | os.PathLike, overwrite: bool = False,
                precision: str = "float", device: str | None = None, exr: dict | None = None,
                progress: Progress | None = None) -> None:
    """The surface as files, whose endings choose the format: .h5, .exr, .binary (MERL), .bsdf (RGL),
    as `hetab tabulate` writes them. All appear together, whole, or not at all. exr: options of
    hetab/exr.h, as {"parts": "atlas", "element": "half"}."""
    of_exr = options("hetab_exr_options", **(exr or {}))
    names = [ffi.new("char[]", os.fsencode(path)) for path in paths]
    call(lib.hetab_tabulate_to, engine(precision, device=device), surface._handle,
         ffi.new("char *[]", names), len(names),
         options("hetab_tabulate_to_options", overwrite=overwrite, exr=of_exr), NULL,
         progress=progress)


def specular_reflectance(surface: Surface, theta_i: ArrayLike) -> NDArray:
    """rho_s of Eq. 10, the delta's reflectance: [band, *theta_i], theta_i in radians."""
    angles = numpy.asarray(theta_i, "f8")
    array, pointer = doubles(angles.ravel())
    out = numpy.empty((len(surface.bands),) + angles.shape)
    call(lib.hetab_specular_reflectance, surface._handle, pointer, len(array),
         address(out))
    return out
