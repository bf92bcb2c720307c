"""The He-Torrance reflectance model, its tables and what the laboratory needs, from libhetab.

    surface = hetab.Surface("BBQAL2")
    values = hetab.evaluate(surface.points(theta_i=0.5, theta_r=angles, phi=numpy.pi))
    values["total"]                                  # [band, angle], 1/sr

Angles are in radians where their names do not say degrees. Failures are hetab.Error with the
library's message. Long calls take progress(done, total), end at Ctrl-C and release the GIL;
different threads may work at once. What is behind every number is in the headers under
include/hetab."""
from ._library import Error, Record, lib as _lib, text as _text
from ._laboratory import audit, fit, measurements, roughness
from ._model import (POINT, REFLECTANCE, VALUE, evaluate, reflectance, specular_reflectance,
                     tabulate, tabulate_to)
from ._surface import BAND, Surface, metals, presets, shader
from ._table import Table, open_table

__version__ = _text(_lib.hetab_version())
__all__ = ["BAND", "Error", "POINT", "REFLECTANCE", "Record", "Surface", "Table", "VALUE", "audit",
           "evaluate", "fit", "measurements", "metals", "open_table", "presets", "reflectance",
           "roughness", "shader", "specular_reflectance", "tabulate",
           "tabulate_to"]
