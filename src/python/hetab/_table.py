"""Tables, looked up and sampled as renderers do."""
from __future__ import annotations

import os

import numpy
from numpy.typing import ArrayLike, NDArray

from ._library import NULL, address, choice, create, lib, view


class Table:
    """An open table. Directions are unit vectors [..., 3] away from the surface, z the normal;
    values [..., channel] are BRDFs in 1/sr without a cosine, dd + ud. Leading shapes are broadcast;
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

    def _batch(self, function, inputs, widths):
        """Arrays of the widths (0: a number) that function(table, count, inputs, outputs) fills."""
        arrays = [numpy.asarray(values, "f4") for values, _ in inputs]
        for array, (_, width) in zip(arrays, inputs):
            if array.shape[-1:] != (width,):
                raise ValueError(f"shape {array.shape} where [..., {width}] is needed")
        shape = numpy.broadcast_shapes(*(array.shape[:-1] for array in arrays))
        arrays = [numpy.ascontiguousarray(numpy.broadcast_to(array, shape + array.shape[-1:]))
                  for array in arrays]
        results = [numpy.empty(shape + ((width,) if width else ()), "f4") for width in widths]
        function(self._handle, int(numpy.prod(shape)), *map(address, arrays + results))
        return results

    def eval(self, wi: ArrayLike, wo: ArrayLike) -> NDArray:
        """[..., channel], 1/sr; 0 where a direction is not above the horizon."""
        return self._batch(lib.hetab_lookup_eval_batch, [(wi, 3), (wo, 3)], [self.channels])[0]

    def sample(self, wi: ArrayLike, u: ArrayLike) -> tuple[NDArray, NDArray, NDArray]:
        """(wo [..., 3], density [...] in 1/sr, weight [..., channel] = f cos(theta_o) / density) of
        u [..., 2] in [0, 1). Density 0: no sample."""
        return tuple(self._batch(lib.hetab_lookup_sample_batch, [(wi, 3), (u, 2)],
                                 [3, 0, self.channels]))

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> NDArray:
        """[...]: the density with which sample() returns wo, 1/sr."""
        return self._batch(lib.hetab_lookup_pdf_batch, [(wi, 3), (wo, 3)], [0])[0]

    def albedo(self, wi: ArrayLike) -> NDArray:
        """[..., channel]: directional-hemispherical reflectance of what eval returns."""
        return self._batch(lib.hetab_lookup_albedo_batch, [(wi, 3)], [self.channels])[0]

    def specular(self, wi: ArrayLike) -> NDArray:
        """[..., channel]: rho_s, the weight of the delta in the mirror direction."""
        return self._batch(lib.hetab_lookup_specular_batch, [(wi, 3)], [self.channels])[0]


def open_table(path: str | os.PathLike, rule: str = "interpolate") -> Table:
    """An HDF5 (.h5), MERL (.binary) or RGL (.bsdf) table, told apart by content. rule:
    "interpolate", or "nearest" for the file's own numbers."""
    return Table(path, rule)
