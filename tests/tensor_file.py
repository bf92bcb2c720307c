#!/usr/bin/python3
"""Reads tensor files (.bsdf) from the description of their bytes alone, and checks what is in those
of RGL: a second reader for the tests, which shares nothing with the library.

usage: tensor_file.py FILE...      prints the fields; exit status 1 if a file is not as it should be
       tensor_file.py --reader NAME FILE...   likewise 1 if the reader (pbrt, powitacq,
                                   mitsuba-spectral, mitsuba-rgb, powitacq-rgb) would refuse it

Container, little-endian: 12 bytes "tensor_file\\0", two version bytes 1 and 0, u32 number of
fields; then for each field u16 length of its name, the name, u16 number of dimensions, u8 type,
u64 offset of its data in the file, u64 for each dimension. Data in C order.
"""
import math
import struct
import sys

import numpy

MAGIC = b"tensor_file\0"
TYPES = dict(enumerate("u1 i1 <u2 <i2 <u4 <i4 <u8 <i8 <f2 <f4 <f8".split(), 1))
ALIGNMENT = 8


class Malformed(ValueError):
    """The file is not what it claims to be."""


def require(condition, problem):
    if not condition:
        raise Malformed(problem)


class Cursor:
    """The header, read from its front."""

    def __init__(self, data):
        self.data, self.place = data, 0

    def bytes(self, count):
        require(self.place + count <= len(self.data), f"the header ends early, at {len(self.data)}")
        self.place += count
        return self.data[self.place - count:self.place]

    def numbers(self, layout):
        return struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))


def read_field(cursor):
    """(name, type, offset, shape)."""
    name = cursor.bytes(cursor.numbers("H")[0]).decode("ascii")
    dimensions, code, offset = cursor.numbers("HBQ")
    require(code in TYPES, f"field '{name}': type {code} does not exist")
    return name, numpy.dtype(TYPES[code]), offset, cursor.numbers(f"{dimensions}Q")


def parse(data):
    """{name: array} of the bytes of a tensor file."""
    cursor = Cursor(data)
    require(cursor.bytes(len(MAGIC)) == MAGIC, "no tensor file")
    version = cursor.numbers("BB")
    require(version == (1, 0), f"version {version}")
    fields = [read_field(cursor) for _ in range(cursor.numbers("I")[0])]
    require(len({field[0] for field in fields}) == len(fields), "a name is there twice")
    end, tensors = cursor.place, {}
    for name, kind, offset, shape in sorted(fields, key=lambda field: field[2]):
        size = math.prod(shape) * kind.itemsize
        require(offset >= end, f"field '{name}' at {offset} overlaps what ends at {end}")
        require(offset % ALIGNMENT == 0, f"field '{name}': offset {offset} is not a multiple of 8")
        require(offset + size <= len(data), f"'{name}' ends at {offset + size} of {len(data)}")
        tensors[name] = numpy.frombuffer(data, kind, math.prod(shape), offset).reshape(shape)
        end = offset + size
    require(len(data) - end < ALIGNMENT, f"{len(data) - end} bytes follow the last field")
    return tensors


def read(path):
    with open(path, "rb") as file:
        return parse(file.read())


# ---- what RGL puts into it -----------------------------------------------------------------------

FLOATS = ("phi_i", "theta_i", "ndf", "sigma", "vndf", "luminance")


def shape_of(rgl, name, *shape):
    require(name in rgl, f"no field '{name}'")
    found = rgl[name].shape
    fits = all(n in (None, m) for n, m in zip(shape, found))
    require(len(found) == len(shape) and fits, f"'{name}' has shape {found}, not {shape}")
    return found


def check_colours(rgl, incidences, resolution):
    """rgb or spectra, one of them, non-negative."""
    require(("rgb" in rgl) != ("spectra" in rgl), "rgb or spectra: one of them, never both")
    if "rgb" in rgl:
        shape_of(rgl, "rgb", 1, incidences, 3, *resolution)
        return "rgb"
    (bands,) = shape_of(rgl, "wavelengths", None)
    require((numpy.diff(rgl["wavelengths"]) > 0).all(), "wavelengths do not ascend")
    require(rgl["wavelengths"][0] > 100, "wavelengths are not in nm")
    shape_of(rgl, "spectra", 1, incidences, bands, *resolution)
    return "spectra"


def check_distributions(rgl):
    """Nodes, symmetry and slices that a reader divides by."""
    theta_i, vndf = rgl["theta_i"], rgl["vndf"].astype("f8")
    require(theta_i[0] == 0 and theta_i[-1] == numpy.float32(math.pi / 2) and
            (numpy.diff(theta_i) > 0).all(), "theta_i does not ascend from 0 to pi / 2")
    for name in ("ndf", "sigma"):
        require((rgl[name][0] == rgl[name][1]).all(), f"the rows of '{name}' differ")
        require((rgl[name] > 0).all(), f"'{name}' is not positive")
    for name in ("vndf", "luminance"):
        require((rgl[name].max(axis=(2, 3)) > 0).all(), f"a slice of '{name}' is all zero")
    cells = (vndf[..., 1:, 1:] + vndf[..., :-1, 1:] + vndf[..., 1:, :-1] + vndf[..., :-1, :-1]) / 4
    norms = cells.mean(axis=(2, 3))
    # To what is the reader's affair: it normalises again.
    require(numpy.ptp(norms) < 1e-4 * norms.mean(), f"slices of 'vndf' sum to {norms.ravel()}")


def check_rgl(rgl):
    """Isotropic RGL tables; Malformed where a reader would go wrong."""
    require(rgl.get("jacobian", numpy.zeros(1)).tolist() == [1], "jacobian is not u8[1] = 1")
    require(rgl["jacobian"].dtype == numpy.uint8, "jacobian is not u8[1] = 1")
    require("description" in rgl and rgl["description"].dtype == numpy.uint8, "no description")
    shape_of(rgl, "phi_i", 1)
    (incidences,) = shape_of(rgl, "theta_i", None)
    _, nodes = shape_of(rgl, "ndf", 2, None)
    shape_of(rgl, "sigma", 2, nodes)
    shape_of(rgl, "vndf", 1, incidences, None, None)
    resolution = shape_of(rgl, "luminance", 1, incidences, None, None)[2:]
    colours = check_colours(rgl, incidences, resolution)
    for name in FLOATS + (colours,):
        require(rgl[name].dtype == numpy.dtype("<f4"), f"'{name}' is not f32")
        require(numpy.isfinite(rgl[name]).all() and (rgl[name] >= 0).all(),
                f"'{name}' is negative or not finite somewhere")
    check_distributions(rgl)


# ---- what others ask of it -----------------------------------------------------------------------

# As pbrt-v4 checks a file before it takes it (MeasuredBxDFData::Create; a field that is missing aborts
# it at a CHECK): names, types, dimensions. Letters are extents that have to agree.
SPECTRAL = {
    "theta_i": ("f4", "T"), "phi_i": ("f4", "P"), "wavelengths": ("f4", "W"),
    "ndf": ("f4", "ab"), "sigma": ("f4", "cd"), "vndf": ("f4", "PTef"),
    "luminance": ("f4", "PTRR"), "spectra": ("f4", "PTWRR"),
    "description": ("u1", "n"), "jacobian": ("u1", "1"),
}
COLOURS = {name: rule for name, rule in SPECTRAL.items() if name not in ("wavelengths", "spectra")}
COLOURS["rgb"] = ("f4", "PT3RR")
READERS = {"pbrt": SPECTRAL, "powitacq": SPECTRAL, "mitsuba-spectral": SPECTRAL,
           "mitsuba-rgb": COLOURS, "powitacq-rgb": COLOURS}


def check_reader(rgl, reader):
    extents = {"1": 1, "3": 3}
    for name, (kind, letters) in READERS[reader].items():
        require(name in rgl, f"{reader} finds no field '{name}'")
        require(rgl[name].dtype == numpy.dtype("<" + kind), f"{reader}: '{name}' is not {kind}")
        require(rgl[name].ndim == len(letters), f"{reader}: '{name}' has {rgl[name].ndim} dimensions")
        for letter, extent in zip(letters, rgl[name].shape):
            expected = extents.setdefault(letter, extent)
            require(extent == expected, f"{reader}: '{name}' has {extent} in place of {expected}")
    require(extents["P"] <= 2, f"{reader}: {extents['P']} azimuths: not isotropic")


def main():
    arguments, reader = sys.argv[1:], None
    if len(arguments) > 2 and arguments[0] == "--reader" and arguments[1] in READERS:
        reader, arguments = arguments[1], arguments[2:]
    if not arguments or arguments[0].startswith("-"):
        sys.exit(__doc__)
    for path in arguments:
        try:
            tensors = read(path)
            if reader:
                check_reader(tensors, reader)
            for name, tensor in tensors.items():
                print(name, tensor.dtype.name, *tensor.shape)
            check_rgl(tensors)
        except (OSError, ValueError) as error:
            sys.exit(f"{path}: {error}")


if __name__ == "__main__":
    main()
