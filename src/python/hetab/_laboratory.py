"""The laboratory's side: roughness from heights, fits to measured BRDFs, audits."""
from __future__ import annotations

import os

import numpy
from numpy.typing import ArrayLike

from ._library import (NULL, Record, address, call, create, doubles, dtype, ffi, lib, options,
                       record, text)
from ._model import Progress, engine
from ._surface import Surface, metals

PAIR = dtype("hetab_directions")

# What the pointers in results are as long as.
SCANS = {"scans": "count", "trials": "count", "notes": "note_count",
         "split_levelled_um": "split_count", "split_line_um": "split_count"}
FIT = {"estimates": "estimate_count", "incidences": "incidence_count", "starts": "start_count",
       "free_estimates": "free_count", "correlation": ("free_count", "free_count"),
       "band_of": "bands", "lambda_um": "bands", "diffuse": "bands", "notes": "note_count"}
AUDIT = {"checks": "check_count", "lambda_um": "channel_count", "theta_i": "theta_count",
         "energy": ("channel_count", "theta_count"), "bands": "channel_count", "against": True,
         "views": (lib.HETAB_AUDIT_VIEWS,)}


# ---- roughness -------------------------------------------------------------------------------

def heights_of(source, spacing_um, unit):
    if isinstance(source, (str, os.PathLike)):
        return create("heights", lib.hetab_heights_load, os.fsencode(source), options(
            "hetab_heights_options", spacing_um=spacing_um, unit=unit))
    array, pointer = doubles(numpy.atleast_2d(source))
    return create("heights", lib.hetab_heights_create, b"scans", lib.HETAB_HEIGHTS_SCANS, pointer,
                  array.shape[1], array.shape[0], spacing_um or 0.0, 0.0)


def roughness(*heights: str | os.PathLike | ArrayLike, cutoff_um: float | str | None = None,
              spacing_um: float | None = None, unit: str | None = None,
              outlier: float | None = None, filter: str | None = None,
              progress: Progress | None = None) -> Record:
    """sigma0 and tau of height scans: files (text, X3P, SDF) or arrays [scan, point] in um with
    their spacing_um. cutoff_um: of the filter ("gaussian", "robust", "fourier", "average"), or
    "auto".

    raw and, with a cut-off, small are what was found (sigma_um.mean, tau_um.mean, slope.mean with
    error, low, high; scans has each); notes says where the model's assumptions fail
    (include/hetab/roughness.h)."""
    handles = [heights_of(source, spacing_um, unit) for source in heights]
    chosen = options("hetab_roughness_options", outlier=outlier, filter=filter,
                     cutoff_um=-1.0 if cutoff_um == "auto" else cutoff_um)
    result = create("roughness", lib.hetab_roughness_measure,
                    ffi.new("hetab_heights *[]", handles), len(handles), chosen, progress=progress)
    return record(result, SCANS)


# ---- fits ------------------------------------------------------------------------------------

def index_of(index):
    """A metal's symbol, a file, or n + ik as a number."""
    if isinstance(index, str) and index in metals():
        return create("index", lib.hetab_index_metal, index.encode())
    if isinstance(index, (str, os.PathLike)):
        return create("index", lib.hetab_index_load, os.fsencode(index))
    return create("index", lib.hetab_index_constant, index.real, index.imag)


def measurements(lambda_um: ArrayLike, theta_i: ArrayLike, theta_r: ArrayLike, phi: ArrayLike,
                 values: ArrayLike):
    """Measurements for fit(): values[pair, wavelength] in 1/sr (NaN: missing), the pairs' angles in
    radians, phi the viewer's azimuth minus the light's."""
    lambdas, lambda_pointer = doubles(lambda_um)
    pairs = numpy.empty(numpy.shape(theta_i), PAIR)
    pairs["theta_i"], pairs["theta_r"], pairs["phi"] = theta_i, theta_r, phi
    array, pointer = doubles(values)
    if array.shape != (len(pairs), len(lambdas)):
        raise ValueError(f"values of shape {array.shape} where [pair, wavelength] = "
                         f"[{len(pairs)}, {len(lambdas)}] is needed")
    return create("measurements", lib.hetab_measurements_create, lambda_pointer, len(lambdas),
                  address(pairs), len(pairs), pointer)


def parameter(wish):
    if wish is None:
        return {}
    if isinstance(wish, str):
        if wish != "free":
            raise ValueError(f"'{wish}': a quantity is given as a number, 'free' or (low, high)")
        return {"free": 1}
    if isinstance(wish, (tuple, list)):
        return {"free": 1, "low": wish[0], "high": wish[1]}
    return {"value": wish}


def fit(measured, index: str | os.PathLike | complex, *, slope=None, sigma0_um=None, tau_um=None,
        n=None, diffuse="free", weights: str = "auto", constraint: str = "auto",
        precision: str = "double", device: str | None = None, progress: Progress | None = None,
        **other) -> Record:
    """The parameters of a surface from its BRDF: a file (.brdf, .astm, .csv, MERL, HDF5) or what
    measurements() made. Of slope, sigma0_um and tau_um give two; n and diffuse (a reflectance)
    beside them: each a number, "free", or (low, high) to be searched. index: a metal, a file, or
    n + ik. Other options by their names in hetab_fit_options (include/hetab/fit.h).

    estimates have quantity, value, low, high; sigma0_um, tau_um, slope, error, notes say the rest;
    surface is the fitted Surface (None: nothing keeps the constraint); model[pair, wavelength]."""
    if isinstance(measured, (str, os.PathLike)):
        measured = create("measurements", lib.hetab_measurements_load, os.fsencode(measured))
    held = index_of(index)
    chosen = options("hetab_fit_options", index=held, weights=weights, constraint=constraint,
                     **other)
    for i, wish in enumerate((slope, sigma0_um, tau_um, n, diffuse)):
        chosen.parameters[i] = parameter(wish)
    result = create("fit", lib.hetab_fit_create, engine(precision, device=device), measured, chosen,
                    progress=progress)
    pairs = lib.hetab_measurements_pair_count(measured)
    found = record(result, {**FIT, "model": (pairs, "bands"), "used": (pairs, "bands")})
    found.surface = None if result.surface == NULL else Surface._of_handle(result.surface, result)
    return found


# ---- audits ----------------------------------------------------------------------------------

def audit(what: Surface | str | os.PathLike, *, against: Surface | None = None,
          precision: str = "float", device: str | None = None, progress: Progress | None = None,
          **other) -> Record:
    """Does a surface, or a table (MERL or HDF5, a path), conserve energy, is it reciprocal,
    physical? Tables are compared with the Surface `against` (HDF5 files know theirs). Other
    options by their names in hetab_audit_options (include/hetab/audit.h).

    checks have name, verdict ("pass", "warn", "fail"), value, error, threshold, detail; verdict is
    the worst of them; energy[channel * theta_i] has rho_dh and its parts."""
    chosen = options("hetab_audit_options", against=against and against._handle, **other)
    arguments = (engine(precision, device=device),
                 what._handle if isinstance(what, Surface) else os.fsencode(what), chosen)
    function = lib.hetab_audit_surface if isinstance(what, Surface) else lib.hetab_audit_table
    result = create("audit", function, *arguments, progress=progress)
    found = record(result, AUDIT)
    found.verdict = text(lib.hetab_verdict_name(lib.hetab_audit_verdict(result))).lower()
    return found
