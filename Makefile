# hetab: `make help` lists what can be made.

VERSION := 0.1.0
PREFIX  ?= /usr/local
DESTDIR ?=
BUILD   ?= build
CC      ?= cc
CFLAGS  ?= -O2 -g
PYTHON  ?= /usr/bin/python3

WARNINGS := -Wall -Wextra -Wconversion -Wdouble-promotion -Wno-unused-parameter
PACKAGES := OpenCL hdf5 yaml-0.1
CPPFLAGS_ALL = -Iinclude -Isrc -I. -DHETAB_VERSION='"$(VERSION)"' -D_GNU_SOURCE \
  -DCL_TARGET_OPENCL_VERSION=120 $(shell pkg-config --cflags $(PACKAGES) 2>/dev/null) $(CPPFLAGS)
# No contraction: host values must not depend on what the compiler fuses.
CFLAGS_ALL = -std=c11 -fPIC -ffp-contract=off -fvisibility=default -pthread $(WARNINGS) $(CFLAGS)
LIBS = $(shell pkg-config --libs-only-L hdf5 2>/dev/null) -lhdf5_hl \
  $(shell pkg-config --libs $(PACKAGES) 2>/dev/null) -lm -pthread

LIB_SOURCES := $(filter-out src/cli/%,$(wildcard src/*/*.c))
CLI_SOURCES := $(wildcard src/cli/*.c)
TEST_SOURCES := $(wildcard tests/test_*.c)
TEST_COMMON := $(filter-out $(TEST_SOURCES),$(wildcard tests/*.c))
HEADERS := $(wildcard include/hetab/*.h)

LIB_OBJECTS := $(LIB_SOURCES:%.c=$(BUILD)/%.o) $(BUILD)/kernels_embedded.o
CLI_OBJECTS := $(CLI_SOURCES:%.c=$(BUILD)/%.o)
TEST_COMMON_OBJECTS := $(TEST_COMMON:%.c=$(BUILD)/%.o)
TESTS := $(TEST_SOURCES:tests/%.c=$(BUILD)/tests/%)

.PHONY: all
all: setup $(BUILD)/hetab $(BUILD)/libhetab.so ## build the program and the library (default)

$(BUILD)/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -MMD -MP -c -o $@ $<

$(BUILD)/kernels_embedded.c: scripts/embed_kernels $(wildcard kernels/*)
	@mkdir -p $(@D)
	$(PYTHON) scripts/embed_kernels kernels $@

$(BUILD)/kernels_embedded.o: $(BUILD)/kernels_embedded.c
	$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -c -o $@ $<

$(BUILD)/libhetab.a: $(LIB_OBJECTS)
	@rm -f $@
	ar rcs $@ $^

$(BUILD)/libhetab.so: $(LIB_OBJECTS)
	$(CC) -shared -Wl,-soname,libhetab.so.0 $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/hetab: $(CLI_OBJECTS) $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/tests/%: $(BUILD)/tests/%.o $(TEST_COMMON_OBJECTS) $(BUILD)/libhetab.a
	$(CC) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $^ -lcmocka $(LIBS)

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
