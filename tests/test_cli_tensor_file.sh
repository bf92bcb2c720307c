#!/bin/bash
# The bytes and fields of RGL tables (.bsdf), by a reader that shares nothing with the library.
# usage: test_cli_tensor_file.sh PROGRAM
tests=$(realpath "$(dirname "$0")")
. "$tests/cli_support.sh"

reads() { /usr/bin/python3 "$tests/tensor_file.py" "$@" >out 2>err; }
refused() { ! reads "$2" && grep -q "^$2: .*$1" err; }

works "rgb" tabulate BBQAL2 -o rgb.bsdf --table-error 0.05
works "spectral" tabulate BBQAL2 -o spectral.bsdf --table-error 0.05 --bands spectral --wavelengths 500,600
check "read" reads rgb.bsdf spectral.bsdf
check "three channels" has '^rgb float32 1 [0-9]+ 3 ([0-9]+) \1$'
check "two wavelengths" has '^spectra float32 1 [0-9]+ 2 ([0-9]+) \1$'

# The reader would notice.
head -c 20000 rgb.bsdf >short.bsdf
(cat rgb.bsdf && echo "more than eight") >long.bsdf
sed 's/jacobian/jacobiaN/' rgb.bsdf >renamed.bsdf
: >empty.bsdf
check "short" refused "ends at" short.bsdf
check "long" refused "follow the last field" long.bsdf
check "renamed" refused "jacobian" renamed.bsdf
check "empty" refused "ends early" empty.bsdf

summary
