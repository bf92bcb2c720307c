#!/bin/bash
# The look-up library as a renderer uses it: a C and a C++ program, linked with the archive and
# without OpenCL, read tables that the program wrote.
. "$(dirname "$0")/cli_support.sh"
include=$(realpath "$scripts/../include")
archive=$(dirname "$program")/libhetab.a
libraries=$(pkg-config --libs hdf5)
sanitizers=
! nm "$archive" 2>/dev/null | grep -q __asan_init || sanitizers=-fsanitize=address,undefined

cat >renderer.c <<'END'
#include <math.h>
#include <stdio.h>
#include <hetab/lookup.h>

int main(int argc, char **argv) {
  hetab_context *ctx;
  if (hetab_context_create(&ctx) != HETAB_OK)
    return 2;
  for (int i = 1; i < argc; i++) {
    hetab_lookup *table;
    const float wi[3] = {0.6f, 0.0f, 0.8f}, mirror[3] = {-0.6f, 0.0f, 0.8f}, u[2] = {0.5f, 0.25f}, uc = 0.9f;
    float value[3], weight[3], rho_s[3], pdf;
    hetab_lookup_drawn drawn;
    if (hetab_lookup_open(ctx, argv[i], HETAB_LOOKUP_INTERPOLATE, &table) != HETAB_OK) {
      puts(hetab_error_message(ctx));
      return 1;
    }
    if (hetab_lookup_channel_count(table) != 3)
      return 1;
    hetab_lookup_eval(table, NULL, 1, wi, mirror, value, &pdf);
    hetab_lookup_albedo(table, NULL, 1, wi, NULL, rho_s);
    hetab_lookup_sample(table, NULL, 1, wi, &uc, u, &drawn, weight);
    printf("%.6g %.6g %.6g %.6g\n", (double)value[1], (double)rho_s[1], (double)drawn.pdf,
           (double)weight[1]);
    hetab_lookup_free(table);
  }
  hetab_context_free(ctx);
  return 0;
}
END
cp renderer.c renderer.cc

works "tables" tabulate NGGAL --wavelengths 450,550,650 --theta-i 0:90:46 --theta-r 0:90:46 -o t.h5
works "MERL table" tabulate NGGAL --merl-colour bands --bands 450,550,650 -o t.binary
check "C links without OpenCL" cc -std=c99 -Wall -Wextra -pedantic -Werror -I"$include" $sanitizers \
  renderer.c "$archive" $libraries -lm -pthread -o c_program
check "C++ links without OpenCL" c++ -std=c++11 -Wall -Wextra -Werror -I"$include" $sanitizers \
  renderer.cc "$archive" $libraries -lm -pthread -o cc_program
for language in c cc; do
  ./${language}_program t.h5 t.binary >"$language.out" 2>&1
  check "$language program runs" test $? = 0
  check "$language program is free of OpenCL" sh -c "! ldd ${language}_program | grep -qi opencl"
done
check "both say the same" cmp c.out cc.out
# f, rho_s and the weight of a sample of both tables against hetab eval; columns of eval by name
printf 'lambda_um,theta_i_deg,theta_r_deg,phi_deg\n0.55,36.8698976,36.8698976,180\n' >in
"$program" eval NGGAL <in >eval.csv
check "as hetab eval says" /usr/bin/python3 - <<'END'
import csv
model = next(csv.DictReader(open("eval.csv")))
f = float(model["total"])
rho_s = float(model["sp_reflectance"])
rows = [[float(x) for x in line.split()] for line in open("c.out")]
assert len(rows) == 2
for value, specular, density, weight in rows:
    assert abs(value / f - 1) < 5e-3, (value, f)
    assert density > 0 and 0 < weight < 2, (density, weight)
assert abs(rows[0][1] / rho_s - 1) < 5e-3, (rows[0][1], rho_s)
END

# README's first C example, as it stands: the main job
sed -n '/^```c$/,/^```$/p' "$scripts/../README.md" | sed '1d; /^```$/,$d' >first.c
ln -s "$(realpath "$(dirname "$program")")/libhetab.so" libhetab.so
ln -s libhetab.so "$(objdump -p libhetab.so | sed -n 's/.*SONAME *//p')"
check "12 lines" test "$(wc -l <first.c)" = 12
check "README's first C example compiles" cc -std=c99 -Wall -Wextra -Werror -I"$include" \
  $sanitizers first.c -L. -lhetab -o first
works_alone() { LD_LIBRARY_PATH=. with_library ./first; }
check "it runs" works_alone
check "it writes tables" test -s bbqal2.h5 -a -s bbqal2.binary -a -s bbqal2.bsdf
check "they are those of the program" sh -c \
  "'$program' tabulate BBQAL2 -q -o p.bsdf -o p.binary && cmp p.bsdf bbqal2.bsdf && cmp p.binary bbqal2.binary"
summary
