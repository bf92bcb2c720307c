# hetab: `make help` lists what can be made.

VERSION := 0.2.0
# Below 1.0 every minor version may break what was linked with the one before.
SOVERSION := 0.2
PREFIX  ?= /usr/local
DESTDIR ?=
BUILD   ?= build
OUT     ?= out
CC      ?= cc
CFLAGS  ?= -O2 -g
PYTHON  ?= /usr/bin/python3

WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wno-unused-parameter
# Deferred (=), so that they see what scripts/setup has installed. An MPI HDF5 beside the serial one takes the name hdf5.
HDF5 = $(shell pkg-config --exists hdf5-serial && echo hdf5-serial || echo hdf5)
PACKAGES = OpenCL $(HDF5) yaml-0.1 jansson nlopt libzip expat libpng
PACKAGE_FLAGS = $(shell pkg-config --cflags $(PACKAGES) OpenEXR)
# Of OpenEXR the C API alone, whose name carries the version.
EXR_LIB = $(filter -lOpenEXRCore%,$(shell pkg-config --libs OpenEXR))
PACKAGE_LIBS = $(shell pkg-config --libs-only-L $(HDF5)) -lhdf5_hl $(shell pkg-config --libs $(PACKAGES)) $(EXR_LIB)
CPPFLAGS_ALL = -Iinclude -Isrc -I. -DHETAB_VERSION='"$(VERSION)"' -D_GNU_SOURCE \
  -DCL_TARGET_OPENCL_VERSION=120 $(PACKAGE_FLAGS) $(CPPFLAGS)
# No contraction: host values must not depend on what the compiler fuses. Nobody asks errno after
# sqrt() or erfc(), so that they are inlined and shared.
CFLAGS_ALL = -std=c11 -fPIC -ffp-contract=off -fno-math-errno -pthread $(WARNINGS) $(CFLAGS)
LIBS = $(PACKAGE_LIBS) -lm -pthread

LIB_SOURCES := $(filter-out src/cli/%,$(wildcard src/*/*.c))
CLI_SOURCES := $(wildcard src/cli/*.c)
TEST_SOURCES := $(wildcard tests/test_*.c)
TEST_COMMON := $(filter-out $(TEST_SOURCES),$(wildcard tests/*.c))
HEADERS := $(wildcard include/hetab/*.h)
FORMATTED := $(wildcard include/hetab/*.h src/*/*.[ch] kernels/*.h kernels/*.cl tests/*.[ch] tests/*/*.[ch])

LIB_OBJECTS := $(LIB_SOURCES:%.c=$(BUILD)/%.o) $(BUILD)/kernels_embedded.o $(BUILD)/shaders_embedded.o
CLI_OBJECTS := $(CLI_SOURCES:%.c=$(BUILD)/%.o)
TEST_OBJECTS := $(TEST_SOURCES:%.c=$(BUILD)/%.o)
TEST_COMMON_OBJECTS := $(TEST_COMMON:%.c=$(BUILD)/%.o)
TESTS := $(TEST_SOURCES:tests/%.c=$(BUILD)/tests/%)

# The material for Mitsuba 3.
PLUGIN := share/hetab/mitsuba/he_torrance.py

.PHONY: build
build: $(BUILD)/hetab $(BUILD)/libhetab.so $(BUILD)/libhetab.a $(BUILD)/hetab.1 $(BUILD)/$(PLUGIN) ## build the program and the library (the default)

.PHONY: help
help: ## list what can be made
	@sed -n 's/^\([a-z-]*\):.*## /\1	/p' Makefile | expand -t 16

.PHONY: setup
setup: ## install the Debian packages that are missing (root or sudo)
	@sh scripts/setup

.PHONY: demo
demo: setup ## set up, build, tabulate the report's five surfaces to out/ and plot them
	@$(MAKE) --no-print-directory -s build
	@scripts/demo $(BUILD)/hetab out

.PHONY: test
test: setup ## set up, build and run every test; T=rgl: those with rgl in their names
	@$(MAKE) --no-print-directory -s build tests
	@PYTHON=$(PYTHON) scripts/run_tests $(BUILD) $(T)

.PHONY: check
check: setup ## set up, build and run the fast tests, in a minute on two cores; T= as above
	@$(MAKE) --no-print-directory -s build tests
	@PYTHON=$(PYTHON) scripts/run_tests $(BUILD) check $(T)

.PHONY: golden-check
golden-check: setup ## compute the reference values of tests/golden anew, in minutes
	@scripts/golden tests/golden/he_torrance.csv --check
	@scripts/golden tests/golden/reflectance.csv --check

# HETAB_SHAPE lays the kernels out as for a GPU, whatever the device is.
.PHONY: test-gpu-shape
test-gpu-shape: $(patsubst %,gpu-shape-%,golden engine) ## the golden and engine tests with kernels laid out as for a GPU

.PHONY: test-gpu-shape-all
test-gpu-shape-all: $(patsubst %,gpu-shape-%,golden engine tabulate merl reflectance rgl) ## so, every test that runs on a device

gpu-shape-%: $(BUILD)/tests/test_%
	@HETAB_SHAPE=gpu $<

.PHONY: test-renderers
test-renderers: ## check tables in Mitsuba 3 and OpenCV (from PyPI, below build/), OpenImageIO and WebGL
	@sh scripts/setup renderers
	@$(MAKE) --no-print-directory -s build $(BUILD)/tests/exr_readback
	@PYTHON=$(PYTHON) scripts/test_renderers $(BUILD)

.PHONY: gallery
gallery: setup ## render tables to out/gallery/: in Mitsuba 3, and in C with the look-up library
	@$(MAKE) --no-print-directory -s build $(BUILD)/path_tracer
	@scripts/gallery_path_tracer $(BUILD) out/gallery
	@PYTHON=$(PYTHON) scripts/gallery $(BUILD) out/gallery

.PHONY: sweep
sweep: setup ## make 1000 tables, audit them and draw 200, in out/sweep
	@$(MAKE) --no-print-directory -s build
	@scripts/sweep $(BUILD) out/sweep

COUNT ?= 40
.PHONY: test-cluster
test-cluster: ## run batches by GNU parallel, Open MPI and Slurm on this machine: COUNT surfaces, 400 for its times
	@sh scripts/setup cluster
	@$(MAKE) --no-print-directory -s build
	@scripts/test_cluster $(BUILD)/hetab $(COUNT)

.PHONY: tests
tests: $(TESTS) $(BUILD)/tests/exr_readback

.PHONY: bench
bench: setup ## speed against error of every method, with plots, in out/
	@$(MAKE) --no-print-directory -s build
	@mkdir -p out
	@$(BUILD)/hetab bench --force --csv out/bench.csv
	@$(BUILD)/hetab bench --force --csv out/roughness.csv --samples 200 \
	  $(addprefix roughness-,0.05 0.2 1 5 20 50 100)
	@scripts/plot_bench out/bench.csv out/bench.png
	@scripts/plot_roofline out/bench.csv out/roofline.png
	@scripts/bench_commands $(BUILD)/hetab
	@$(MAKE) --no-print-directory -s $(patsubst %,$(BUILD)/tests/bench/%_speed,lookup series)
	@$(BUILD)/tests/bench/lookup_speed out BBQAL1 BBQAL2 GGAL120 GGAL240 NGGAL | tee out/lookup.csv
	@$(BUILD)/tests/bench/series_speed
	@$(PYTHON) tests/bench/python_speed.py $(BUILD)

.PHONY: figures
figures: setup ## redraw what the report's figures show, in out/figures
	@$(MAKE) --no-print-directory -s build
	@scripts/figures $(BUILD)/hetab out/figures

.PHONY: study-filter
study-filter: setup ## which filter makes the report's small scale of its raw heights (3 minutes)
	@$(MAKE) --no-print-directory -s build
	@scripts/filter_study $(BUILD)/hetab

# PoCL's compiler gives the thread that loads it a signal stack, which the sanitizer would unmap.
# Freed memory is overwritten: libraries that are not instrumented then fail on using it, too.
.PHONY: asan
asan: setup ## run the tests under AddressSanitizer and UndefinedBehaviorSanitizer
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/asan \
	  CFLAGS='-O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined' \
	  build tests
	@ASAN_OPTIONS=use_sigaltstack=0:max_free_fill_size=4096:free_fill_byte=165 \
	  LSAN_OPTIONS=suppressions=$(abspath tests/lsan.supp):print_suppressions=0 \
	  scripts/run_tests $(BUILD)/asan $(T)

# clang, libFuzzer and the sanitizers come from Debian's clang-15, which nothing else needs.
FUZZ_CC ?= clang-15
SECONDS ?= 60
FUZZ_TARGET = $(or $(T),scan)
.PHONY: fuzz
fuzz: setup ## fuzz the reader T (tests/fuzz/targets.c) for SECONDS: make fuzz T=scan SECONDS=300
	@command -v $(FUZZ_CC) >/dev/null || { echo "make fuzz: install clang: apt-get install clang-15"; exit 1; }
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/fuzz CC=$(FUZZ_CC) \
	  CFLAGS='-O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined' \
	  $(BUILD)/fuzz/fuzzer
	@mkdir -p $(BUILD)/fuzz/corpus/$(FUZZ_TARGET)
	@FUZZ_TARGET=$(FUZZ_TARGET) ASAN_OPTIONS=allocator_may_return_null=1:max_free_fill_size=4096:free_fill_byte=165 \
	  $(BUILD)/fuzz/fuzzer -max_total_time=$(SECONDS) -timeout=10 -rss_limit_mb=4096 \
	  -close_fd_mask=1 $(if $(filter h5_bytes,$(T)),-detect_leaks=0) -artifact_prefix=$(BUILD)/fuzz/$(FUZZ_TARGET)- $(abspath $(BUILD)/fuzz/corpus/$(FUZZ_TARGET) tests/fuzz/corpus/$(FUZZ_TARGET))

INJECTED := malloc calloc realloc strdup strndup asprintf open_memstream write pwrite ftruncate fsync linkat \
  renameat read pread fread
.PHONY: inject
inject: setup ## fail every kind of allocation and I/O of the commands in turn: no crash, no half-written file
	@$(MAKE) --no-print-directory -s $(BUILD)/inject/hetab
	@scripts/inject $(BUILD)/inject/hetab $(FAULTS)

N ?= 200
.PHONY: kill
kill: build ## kill writers at N random moments: nothing is torn, and litter is swept
	@scripts/kill $(BUILD)/hetab $(N)
	@scripts/kill_batch $(BUILD)/hetab 30

.PHONY: valgrind
valgrind: build ## run commands that read and write tables under valgrind (apt-get install valgrind)
	@sh scripts/valgrind $(BUILD)/hetab

# The tests of code that starts threads: look-ups, RGL tables, dense tables on devices, samplers.
TSAN_TESTS := $(patsubst %,$(BUILD)/tsan/tests/test_%,lookup_threads rgl tabulate sampler)
.PHONY: coverage
coverage: $(BUILD)/tests/test_fit ## how often the 95 % intervals of fits hold the truth, of 1000 measurements each (2 minutes)
	@HETAB_TRIALS=1000 HETAB_TESTS=test_coverage $<

.PHONY: honesty
honesty: $(BUILD)/tests/test_reflectance ## whether errors of reflectances are below their estimates, of 500 surfaces (10 minutes)
	@HETAB_TRIALS=500 HETAB_TESTS=test_honesty $<

.PHONY: tsan
tsan: setup ## run the tests that start threads under ThreadSanitizer
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/tsan CFLAGS='-O1 -g -fsanitize=thread' $(TSAN_TESTS)
	@for test in $(TSAN_TESTS); do \
	  TSAN_OPTIONS=halt_on_error=1:suppressions=$(abspath tests/tsan.supp) $$test || exit 1; done

.PHONY: format
format: ## rewrite the C and OpenCL sources with clang-format
	@clang-format -i $(FORMATTED)

.PHONY: format-check
format-check: ## fail if clang-format would change anything
	@clang-format --dry-run -Werror $(FORMATTED)

.PHONY: layers-check
layers-check: build ## fail if a folder uses what src/README.md does not allow it
	@scripts/check_layers $(BUILD)

.PHONY: install
install: build ## install under PREFIX (default /usr/local), below DESTDIR
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/include/hetab \
	  $(DESTDIR)$(PREFIX)/lib/pkgconfig $(DESTDIR)$(PREFIX)/share/man/man1
	install -m 755 $(BUILD)/hetab $(DESTDIR)$(PREFIX)/bin/
	install -m 644 $(HEADERS) $(DESTDIR)$(PREFIX)/include/hetab/
	install -m 644 $(BUILD)/libhetab.a $(DESTDIR)$(PREFIX)/lib/
	install -m 755 $(BUILD)/libhetab.so $(DESTDIR)$(PREFIX)/lib/libhetab.so.$(VERSION)
	ln -sf libhetab.so.$(VERSION) $(DESTDIR)$(PREFIX)/lib/libhetab.so.$(SOVERSION)
	ln -sf libhetab.so.$(SOVERSION) $(DESTDIR)$(PREFIX)/lib/libhetab.so
	sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@VERSION@|$(VERSION)|' \
	  -e 's|@PACKAGES@|$(PACKAGES)|' -e 's|@EXR@|$(EXR_LIB)|' src/hetab.pc.in \
	  > $(DESTDIR)$(PREFIX)/lib/pkgconfig/hetab.pc
	install -D -m 644 $(BUILD)/$(PLUGIN) $(DESTDIR)$(PREFIX)/$(PLUGIN)
	install -m 644 $(BUILD)/hetab.1 $(DESTDIR)$(PREFIX)/share/man/man1/

.PHONY: wheel
wheel: $(BUILD)/libhetab.so ## a wheel of the Python package, with the library inside, in out/
	@mkdir -p $(OUT)
	@cd src/python && BUILD=$(abspath $(BUILD)) $(PYTHON) -W ignore setup.py -q egg_info -e $(abspath $(BUILD)) \
	  build -b $(abspath $(BUILD))/python bdist_wheel -d $(abspath $(OUT))
	@ls $(OUT)/*.whl

.PHONY: clean
clean: ## remove what was built; out/ stays
	rm -rf $(BUILD)

$(BUILD)/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -MMD -MP -c -o $@ $<

# Loops over blocks become vectors; its numbers carry the errors that its tests measure.
VECTORS := lookup/lattice_eval lookup/dense_load lookup/dense_source lookup/lattice lookup/half_sampler table/band_places
$(VECTORS:%=$(BUILD)/src/%.o): \
  CFLAGS_ALL += -O3 -fno-trapping-math -ffp-contract=fast

$(BUILD)/kernels_embedded.c: scripts/embed_kernels $(wildcard kernels/*)
	@mkdir -p $(@D)
	$(PYTHON) scripts/embed_kernels kernels $@

SHADERS := $(filter-out %.c src/shader/shader_parts.h,$(wildcard src/shader/*))
# The folder itself: renamed files keep their time.
$(BUILD)/shaders_embedded.c: scripts/embed_files src/shader $(SHADERS)
	@mkdir -p $(@D)
	$(PYTHON) scripts/embed_files shader/shader_parts.h hetab_shader_template hetab_shader_templates $(SHADERS) $@

$(BUILD)/%_embedded.o: $(BUILD)/%_embedded.c
	$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -c -o $@ $<

$(BUILD)/libhetab.a: $(LIB_OBJECTS)
	@rm -f $@
	ar rcs $@ $^

$(BUILD)/exports.map: scripts/exports $(HEADERS)
	@mkdir -p $(@D)
	sh scripts/exports $(HEADERS) > $@

$(BUILD)/libhetab.so: $(LIB_OBJECTS) $(BUILD)/exports.map
	$(CC) -shared -Wl,-soname,libhetab.so.$(SOVERSION) -Wl,--version-script=$(BUILD)/exports.map \
	  $(CFLAGS_ALL) $(LDFLAGS) -o $@ $(LIB_OBJECTS) $(LIBS)

$(BUILD)/hetab: $(CLI_OBJECTS) $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/$(PLUGIN): $(BUILD)/hetab
	@mkdir -p $(@D)
	$(BUILD)/hetab shader --language mitsuba --force -o $@

$(BUILD)/hetab.1: $(BUILD)/hetab src/cli/hetab.1.in scripts/make_man
	sh scripts/make_man $(BUILD)/hetab src/cli/hetab.1.in > $@

$(BUILD)/tests/%: $(BUILD)/tests/%.o $(TEST_COMMON_OBJECTS) $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ -lcmocka $(LIBS)

$(BUILD)/tests/test_fuzz: $(BUILD)/tests/test_fuzz.o $(BUILD)/tests/fuzz/targets.o $(TEST_COMMON_OBJECTS) $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ -lcmocka $(LIBS)

$(BUILD)/fuzzer: $(BUILD)/tests/fuzz/fuzz.o $(BUILD)/tests/fuzz/targets.o $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) -fsanitize=fuzzer $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/inject/hetab: $(CLI_OBJECTS) $(BUILD)/tests/fuzz/inject.o $(BUILD)/libhetab.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS_ALL) $(INJECTED:%=-Wl,--wrap=%) $(LDFLAGS) -o $@ $^ $(LIBS) -ljansson

$(BUILD)/path_tracer: tests/gallery/path_tracer.c $(BUILD)/libhetab.a
	$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -fopenmp $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/tests/bench/%: $(BUILD)/tests/bench/%.o $(BUILD)/libhetab.a
	@mkdir -p $(@D)
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/tests/exr_readback: tests/exr_readback.cc
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -O2 -Wall -Wextra -o $@ $< -ltinyexr

# NAN and INFINITY are floats, which clang minds where a double is meant, and gcc does not.
$(TEST_OBJECTS): WARNINGS += $(if $(findstring clang,$(CC)),-Wno-double-promotion)

.SECONDARY: $(TEST_OBJECTS)

-include $(LIB_OBJECTS:.o=.d) $(CLI_OBJECTS:.o=.d) $(TEST_OBJECTS:.o=.d) $(TEST_COMMON_OBJECTS:.o=.d)
