"""Tables, looked up and sampled as renderers do."""
from __future__ import annotations

import os

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import NULL, address, choice, create, ffi, lib, view


class Table:
    """An open table. Directions are unit vectors [..., 3] away from the surface, z the normal;
    values [..., channel] are BRDFs in 1/sr without a cosine, dd + ud. With lambda_um [..., n] they
    are [..., n]: of each path's own wavelengths; a scalar is one. Leading shapes are broadcast;
    float32 arrays in C order are read where they lie. Any number of threads may share a table.
    Errors and speed: include/hetab/lookup.h."""

    def __init__(self, path: str | os.PathLike, rule: str = "interpolate"):
        self._handle = create("lookup", lib.hetab_lookup_open, os.fsencode(path),
                              choice("hetab_lookup_rule", rule))
        self.channels: int = lib.hetab_lookup_channel_count(self._handle)
        lambda_um = lib.hetab_lookup_wavelengths_um(self._handle)
        #: [channel], um; None: linear sRGB
        self.wavelengths_um: NDArray | None = (
            None if lambda_um == NULL else view(lambda_um, "f8", (self.channels,)))

    def _call(self, function, lambda_um, inputs, results):
        """Arrays of the results' types (None: a row of values) that function(table, query, count,
        inputs, results) fills; inputs: (array, length of its last axis or None)."""
        if lambda_um is not None and self.wavelengths_um is None:
            raise ValueError("a table of linear sRGB has no wavelengths to choose from")
        count = self.channels
        if lambda_um is not None:
            lambda_um = numpy.atleast_1d(lambda_um)
            count = lambda_um.shape[-1]
            if not count:
                raise ValueError("lambda_um is empty: give a wavelength or several")
            inputs = [*inputs, (lambda_um, count)]
        arrays = [numpy.asarray(values, "f4") for values, _ in inputs]
        for array, (_, width) in zip(arrays, inputs):
            if width and array.shape[-1:] != (width,):
                raise ValueError(f"shape {array.shape} where [..., {width}] is needed")
        rows = [array.shape[-1:] if width else () for array, (_, width) in zip(arrays, inputs)]
        shape = numpy.broadcast_shapes(*(array.shape[:array.ndim - len(row)]
                                         for array, row in zip(arrays, rows)))
        arrays = [numpy.ascontiguousarray(numpy.broadcast_to(array, shape + row))
                  for array, row in zip(arrays, rows)]
        filled = [numpy.empty(shape, ("f4", (count,)) if kind is None else kind)
                  for kind in results]
        query = ffi.new("hetab_lookup_query *", {"lambda_count": count})
        if lambda_um is not None:
            query.lambda_um = ffi.cast("float *", address(arrays[-1]))
        function(self._handle, query, int(numpy.prod(shape)),
                 *map(address, arrays[:len(arrays) - (lambda_um is not None)] + filled))
        return tuple(filled)

    def eval(self, wi: ArrayLike, wo: ArrayLike, lambda_um: ArrayLike | None = None
             ) -> tuple[NDArray, NDArray]:
        """(value [..., channel] in 1/sr, density [...] of sample() there, the choice of the lobe in
        it); 0 where a direction is not above the horizon."""
        return self._call(lib.hetab_lookup_eval, lambda_um, [(wi, 3), (wo, 3)], [None, "f4"])

    def sample(self, wi: ArrayLike, uc: ArrayLike, u: ArrayLike, lambda_um: ArrayLike | None = None
               ) -> tuple[NDArray, NDArray]:
        """The whole BSDF, of uc [...] and u [..., 2] in [0, 1): (drawn, weight [..., channel]).
        Fields of drawn [...]: "wo" [3]; "pdf"; "lobe": 0 no sample, 1 diffuse, 2 glossy, 3 the
        delta. weight = f cos(theta_o) / pdf; of the delta rho_s / pdf, its probability."""
        drawn = numpy.dtype([("wo", "f4", 3), ("pdf", "f4"), ("lobe", "i4")])
        return self._call(lib.hetab_lookup_sample, lambda_um, [(wi, 3), (uc, None), (u, 2)],
                          [drawn, None])

    def albedo(self, wi: ArrayLike, lambda_um: ArrayLike | None = None) -> tuple[NDArray, NDArray]:
        """(albedo, specular), both [..., channel]: the directional-hemispherical reflectance of
        what eval returns; rho_s, the weight of the delta in the mirror direction."""
        return self._call(lib.hetab_lookup_albedo, lambda_um, [(wi, 3)], [None, None])


def open_table(path: str | os.PathLike, rule: str = "interpolate") -> Table:
    """An HDF5 (.h5), MERL (.binary) or RGL (.bsdf) table, told apart by content. rule:
    "interpolate", or "nearest" for the file's own numbers."""
    return Table(path, rule)
