"""What tests/exr_readback.cc wrote of an OpenEXR file: parts, each with its channels as arrays."""
import numpy as np


def load(stem):
    """{part: {channel: [height][width]}} of STEM.txt and STEM.bin."""
    pixels, parts = np.fromfile(stem + ".bin", "f4"), {}
    for line in open(stem + ".txt"):
        kind, number, name, *rest = line.split()
        if kind == "part":
            width, height = map(int, rest)
            part = parts[name] = {}
        elif kind == "channel":
            first = int(rest[1])
            part[name] = pixels[first:first + width * height].reshape(height, width)
    return parts
