"""Surfaces and refractive indices."""
from __future__ import annotations

import json
import os
import tempfile

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import NULL, Error, call, choice, create, doubles, dtype, ffi, lib, libc, text, view

BAND = dtype("hetab_band")
POINT = dtype("hetab_point")


class Surface:
    """A rough surface: roughness, refractive index, diffuse part, wavelengths.

    Surface("BBQAL2")                  a preset (presets() lists them)
    Surface("mine.yml")                a file
    Surface(sigma0_um=0.54, tau_um=6.5, index="Al", wavelengths_nm="400:700:10")
                                       the keys of a file (include/hetab/surface.h): index is a
                                       metal, {"file": path} or {"n": 1.5, "k": 0}
    """

    def __init__(self, source: str | os.PathLike | None = None, **keys):
        if (source is None) == (not keys):
            raise TypeError("Surface takes the name of a preset, a path, or keys as sigma0_um=0.5")
        self._handle = (create("surface", lib.hetab_surface_open, os.fsencode(source)) if source
                        else self._of_keys(keys))

    @staticmethod
    def _of_keys(keys):
        """YAML contains JSON: the library's own reader judges the keys."""
        with tempfile.TemporaryDirectory(prefix="hetab") as folder:
            index = keys.get("index")
            if isinstance(index, dict) and "file" in index:
                keys["index"] = {"file": os.path.abspath(index["file"])}
            path = os.path.join(folder, "surface.yml")
            with open(path, "w", encoding="utf-8") as file:
                json.dump({"name": "surface", **keys}, file, default=lambda a: a.tolist())
            try:
                return create("surface", lib.hetab_surface_load, os.fsencode(path))
            except Error as error:  # of a file that the caller has not written
                message = str(error).replace(f"{path}:1: ", "Surface: ").replace(path, "Surface")
                raise Error(message, error.status) from None

    @classmethod
    def _of_handle(cls, handle, owner):
        surface = cls.__new__(cls)
        surface._handle, surface._owner = handle, owner
        return surface

    @property
    def name(self) -> str:
        return text(lib.hetab_surface_name(self._handle))

    @property
    def sigma0_um(self) -> float:
        return lib.hetab_surface_sigma0_um(self._handle)

    @property
    def tau_um(self) -> float:
        return lib.hetab_surface_tau_um(self._handle)

    @property
    def bands(self) -> NDArray:
        """[band] with fields lambda_um, n, k, diffuse_brdf (1/sr)."""
        return view(lib.hetab_surface_bands(self._handle), BAND,
                    (lib.hetab_surface_band_count(self._handle),))

    @property
    def wavelengths_um(self) -> NDArray:
        """[band]; assign to sample the index anew."""
        return self.bands["lambda_um"].copy()

    @wavelengths_um.setter
    def wavelengths_um(self, lambda_um: ArrayLike):
        array, pointer = doubles(numpy.atleast_1d(lambda_um))
        call(lib.hetab_surface_set_wavelengths, self._handle, pointer, len(array))

    def at(self, lambda_um: ArrayLike) -> NDArray:
        """Bands at any wavelengths within the index data, of lambda_um's shape."""
        lambdas = numpy.asarray(lambda_um, dtype="f8")
        out = numpy.empty(lambdas.shape, BAND)
        different, places = numpy.unique(lambdas, return_inverse=True)
        bands = ffi.new("hetab_band[]", max(len(different), 1))
        for i, value in enumerate(different):
            call(lib.hetab_surface_at, self._handle, value, bands + i)
        out[...] = view(bands, BAND, (len(different),))[places].reshape(lambdas.shape)
        return out

    def yaml(self) -> str:
        """The surface as a file."""
        out = ffi.new("char **")
        call(lib.hetab_surface_yaml, self._handle, out)
        return text(ffi.gc(out[0], libc.free))

    def points(self, theta_i: ArrayLike, theta_r: ArrayLike, phi: ArrayLike,
               lambda_um: ArrayLike | None = None) -> NDArray:
        """Points to evaluate(), angles in radians, the mirror direction being theta_r = theta_i,
        phi = pi. Arguments are broadcast against each other; without lambda_um all bands stand
        on a first axis: [band, ...]."""
        angles = numpy.broadcast_arrays(*(numpy.asarray(a, "f8") for a in (theta_i, theta_r, phi)))
        bands = self.bands if lambda_um is None else self.at(lambda_um)
        if lambda_um is None:
            bands = bands.reshape(bands.shape + (1,) * angles[0].ndim)
        out = numpy.empty(numpy.broadcast_shapes(bands.shape, angles[0].shape), POINT)
        for name, values in zip(("theta_i", "theta_r", "phi"), angles):
            out[name] = values
        for name in BAND.names:
            out[name] = bands[name]
        out["sigma0_um"], out["tau_um"] = self.sigma0_um, self.tau_um
        return out

    def __repr__(self):
        return (f"<hetab.Surface {self.name}: sigma0 {self.sigma0_um:g} um, tau {self.tau_um:g} "
                f"um, {len(self.bands)} wavelengths>")


def presets() -> dict[str, str]:
    """{name: description} of the built-in surfaces."""
    return {text(lib.hetab_preset_name(i)): text(lib.hetab_preset_description(i))
            for i in range(lib.hetab_preset_count())}


def metals() -> dict[str, str]:
    """{symbol: name} of the built-in metals."""
    return {text(lib.hetab_metal_symbol(i)): text(lib.hetab_metal_name(i))
            for i in range(lib.hetab_metal_count())}


def shader(language: str, surface: Surface | None = None) -> str:
    """The model as source: "c", "glsl", "python" (numpy) or "mitsuba". With a surface its numbers are in it
    (include/hetab/shader.h)."""
    out = ffi.new("char **")
    call(lib.hetab_shader_text, surface._handle if surface else NULL,
         choice("hetab_shader_language", language), out)
    return text(ffi.gc(out[0], libc.free))
