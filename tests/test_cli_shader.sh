#!/bin/bash
# `hetab shader`, the page of `hetab view` and `hetab surfaces --as`: what is written, and bad input.
# What the sources compute is compared with the model in tests/test_python.py and in tests/renderers.
# usage: test_cli_shader.sh PROGRAM
. "$(dirname "$0")/cli_support.sh"

for language in c glsl python mitsuba; do
  works "$language" shader NGGAL --language $language -o $language.txt
  check "$language: the surface" grep -q '"sigma0_um": 0.13' $language.txt
  check "$language: the error" grep -q 'where it is above 1e-6' $language.txt
  check "$language: no marks left" sh -c "! grep -qE '@[A-Z_]+@|@[a-z_]+\.[a-z]+@' $language.txt"
done
works "free parameters, standard output" shader --language python
check "no surface" has 'loads\("""null"""\)'
check "Python reads it" /usr/bin/python3 -m py_compile python.txt
check "Python reads the material" /usr/bin/python3 -m py_compile mitsuba.txt
printf 'name: "*/ \\" @TABLE@ </script> %%s"\nsigma0_um: 0.3\ntau_um: 3\nindex: Au\n' >odd.yml
works "odd name" shader odd.yml --language c -o odd.h
printf '#include "odd.h"\nint main(void) { return 0; }\n' >odd.c
check "odd name: compiles" cc -std=c99 -Wall -Wextra -Werror -Wno-unused-function -o odd odd.c -lm

works "explorer" view BBQAL2 -o page.html
check "prints the file" has '^page.html$'
check "of one file, small" test "$(stat -c %s page.html)" -lt 150000
check "no network" sh -c "! grep -qE 'https?:|url\(|src=' page.html"
works "explorer of an odd name" view odd.yml -o odd.html --quiet
check "no foreign script" test "$(grep -c '</script>' odd.html)" = "$(grep -c '</script>' page.html)"

works "stand-in" surfaces NGGAL --as ggx --json
check "alpha is 2 sigma0 / tau" json "abs(d['alpha'] - 2 * 0.13 / 5.4) < 1e-9"
check "n and k by wavelength and of three" json "len(d['bands']) == 31 and d['n_rgb'][1] == d['bands'][15]['n']"
check "seven incidences" json "[r['theta_i_deg'] for r in d['incidences']] == [0, 15, 30, 45, 60, 75, 85]"
works "stand-in of a file" surfaces ./odd.yml --as beckmann
check "its energy" has '^ +0 .* 0\.9[0-9]+$|^ +0 .* 1\.0[0-9]+$'
refuses "stand-in of nothing" 2 "--as takes" surfaces --as ggx

refuses "no language" 2 "no --language given" shader NGGAL
refuses "another language" 2 "language" shader NGGAL --language osl
refuses "no such surface" 1 "no preset 'nope'" shader nope --language c
refuses "exists" 1 "page.html.*--force|page.html.*exists" view BBQAL2 -o page.html
mkdir folder
refuses "a folder for a surface" 1 "folder is a folder, no surface: .* ending in .yml" shader folder --language c
refuses "a header for a surface" 1 "odd.h is a file of another kind, no surface" view odd.h -o no.png
refuses "shader exists" 1 "c.txt exists: use --force" shader --language c -o c.txt
refuses "page of a table" 2 "explores the model of a SURFACE" view t.h5 -o t.html
summary
