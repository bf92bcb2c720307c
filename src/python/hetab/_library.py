"""libhetab through cffi. Its declarations are the public headers themselves, so that structures,
enumerations and functions are always those of the library. cffi releases the GIL in every call."""
import os
import pathlib
import re
import threading
import types
import weakref

import cffi
import numpy

HERE = pathlib.Path(__file__).resolve().parent
CHECKOUT = HERE.parents[2]


# ---- the library -----------------------------------------------------------------------------

def find(*places):
    """The first that exists: inside the package, or in the checkout around it."""
    return next((place for place in places if place.exists()), None)


def declarations(header, seen):
    """A header after those that it includes, without what only a preprocessor reads."""
    if header in seen:
        return ""
    seen.add(header)
    text = header.read_text()
    inner = "".join(declarations(header.with_name(name), seen)
                    for name in re.findall(r"#include <hetab/(\w+\.h)>", text))
    text = re.sub(r"^HETAB_(?:BEGIN|END)$", "", text, flags=re.M)
    return inner + re.sub(r"^[ \t]*#(?:.*\\\n)*.*$", "", text, flags=re.M)


def declare():
    folder = find(HERE / "include", CHECKOUT / "include" / "hetab")
    if not folder:
        raise ImportError(f"hetab: no headers at {HERE / 'include'}: install the package with pip, "
                          "or put src/python of a checkout on PYTHONPATH")
    interface = cffi.FFI()
    interface.cdef(declarations(folder / "hetab.h", set()) + "void free(void *);")
    return interface


def load():
    path = os.environ.get("HETAB_LIBRARY") or find(
        HERE / "libhetab.so", CHECKOUT / "build" / "libhetab.so") or "libhetab.so.0"
    try:
        return ffi.dlopen(str(path))
    except OSError as error:
        raise ImportError(f"hetab: {error}: build it (make), install it (make install; ldconfig), "
                          "or set HETAB_LIBRARY to the path of libhetab.so") from error


ffi = declare()
lib = load()
libc = ffi.dlopen(None)
NULL = ffi.NULL


# ---- calls -----------------------------------------------------------------------------------

class Error(Exception):
    """What the library refuses. The text is its message: what, where, and how to mend it."""

    def __init__(self, message, status):
        super().__init__(message)
        self.status = status  #: in words: "i/o error", "cancelled"


local = threading.local()  # a context serves one thread at a time


def context():
    if not hasattr(local, "context"):
        out = ffi.new("hetab_context **")
        if lib.hetab_context_create(out):
            raise MemoryError("hetab: out of memory")
        local.context = ffi.gc(out[0], lib.hetab_context_free)
    return local.context


def call(function, *arguments, progress=None):
    """function(context, *arguments); its failure as an exception. Ctrl-C and exceptions of
    progress(done, total), which stops the work by returning a true value, come through."""
    raised = []

    def stop(kind, error, trace):
        raised.append(error)

    @ffi.callback("hetab_progress_fn", error=1, onerror=stop)
    def step(_, done, total):
        return bool(progress and progress(done, total))

    ctx = context()
    lib.hetab_set_progress(ctx, step, NULL)
    status = function(ctx, *arguments)
    lib.hetab_set_progress(ctx, NULL, NULL)
    if raised:
        raise raised[0]
    if status:
        raise Error(text(lib.hetab_error_message(ctx)), text(lib.hetab_status_name(status)))


def create(kind, function, *arguments, progress=None):
    """A handle of hetab_<kind>, freed when Python drops it; its address is the last argument."""
    out = ffi.new(f"hetab_{kind} **")
    call(function, *arguments, out, progress=progress)
    return ffi.gc(out[0], getattr(lib, f"hetab_{kind}_free"))


# ---- values ----------------------------------------------------------------------------------

def text(pointer):
    return None if pointer == NULL else ffi.string(pointer).decode()


def address(array):
    """Of a contiguous array, as long as it lives; becomes any pointer."""
    return ffi.cast("void *", ffi.from_buffer(array)) if array.size else NULL


def doubles(values):
    """(array of float64, its address)."""
    array = numpy.ascontiguousarray(values, dtype="f8")
    return array, address(array)


def view(pointer, dtype, shape):
    """A copy of what the library owns, as an array."""
    out = numpy.empty(shape, dtype)
    if pointer != NULL and out.size:
        ffi.memmove(address(out), pointer, out.nbytes)
    return out


CODES = {"double": "f8", "float": "f4", "int": "i4", "unsigned int": "u4", "size_t": "u8",
         "unsigned long long": "u8", "unsigned char": "u1"}


def dtype(ctype):
    """The numpy type of a C type: structures become structured types; pointers are left out."""
    ctype = ffi.typeof(ctype) if isinstance(ctype, str) else ctype
    if ctype.kind == "enum":
        return numpy.dtype("u4")
    if ctype.kind == "array":
        if ctype.item.cname == "char":
            return numpy.dtype(f"S{ctype.length}")
        return numpy.dtype((dtype(ctype.item), (ctype.length,)))
    if ctype.kind == "primitive":
        return numpy.dtype(CODES[ctype.cname])
    fields = [(name, field) for name, field in ctype.fields if field.type.kind != "pointer"]
    return numpy.dtype({"names": [name for name, _ in fields],
                        "formats": [dtype(field.type) for _, field in fields],
                        "offsets": [field.offset for _, field in fields],
                        "itemsize": ffi.sizeof(ctype)})


# ---- enumerations, options, records ----------------------------------------------------------

def words(ctype):
    """{"energy": 0, ...} of an enumeration: its names in lower case without what all begin with."""
    names = ctype.relements
    start = os.path.commonprefix(list(names)).rfind("_") + 1
    return {name[start:].lower(): value for name, value in names.items()}


def choice(kind, word):
    """The number of a word of an enumeration."""
    known = words(ffi.typeof(kind) if isinstance(kind, str) else kind)
    if word not in known:
        raise ValueError(f"'{word}' is not one of {', '.join(sorted(known, key=known.get))}")
    return known[word]


kept = weakref.WeakKeyDictionary()  # what structures point into


def options(kind, **values):
    """A new structure of options: enumerations as words, arrays and texts as pointers (the count
    beside them is filled in), None is the default."""
    struct = ffi.new(f"{kind} *")
    fields, kept[struct] = dict(ffi.typeof(kind).fields), []
    if "size" in fields:
        struct.size = ffi.sizeof(kind)
    for name, value in values.items():
        if name not in fields:
            raise TypeError(f"no option '{name}'; there are {', '.join(fields)}")
        if value is not None:
            assign(struct, name, fields, value)
    return struct


def assign(struct, name, fields, value):
    ctype = fields[name].type
    if ctype.kind == "enum" and isinstance(value, str):
        value = choice(ctype, value)
    elif ctype.kind == "pointer" and isinstance(value, str):
        value = ffi.new("char[]", value.encode())
    elif ctype.kind == "pointer" and not isinstance(value, ffi.CData):
        array, value = doubles(numpy.atleast_1d(value))
        kept[struct].append(array)
        counter = re.sub(r"_um$", "", name) + "_count"
        if counter in fields:
            setattr(struct, counter, len(array))
    kept[struct].append(value)
    setattr(struct, name, value)


class Record(types.SimpleNamespace):
    """A result: the fields of the library's structure, which its header describes."""


def record(struct, counts):
    """A structure as a Record. counts: {pointer's name: names of what it is as long as}; pointers
    that are not in it are texts, or left out. One that is True points to one structure."""
    if ffi.typeof(struct).kind == "pointer":
        struct = struct[0]
    fields = {name: field.type for name, field in ffi.typeof(struct).fields}
    values = {name: converted(getattr(struct, name), ctype, counts.get(name), struct, counts)
              for name, ctype in fields.items()
              if ctype.kind != "pointer" or name in counts or ctype.item.cname == "char"}
    return Record(**values)


def converted(value, ctype, count, struct, counts):
    if ctype.kind == "enum":
        return {number: word for word, number in words(ctype).items()}[int(ffi.cast("int", value))]
    if ctype.kind == "struct":
        return record(value, counts)
    if ctype.kind == "array" and ctype.item.cname == "char":
        return ffi.string(value).decode()
    if ctype.kind == "array":
        length = getattr(struct, count) if count else ctype.length
        return several(value, ctype.item, (length,), counts)
    if ctype.kind != "pointer":
        return value
    if value == NULL:
        return None
    if ctype.item.cname == "char":
        return text(value)
    if count is True:
        return record(value, counts)
    names = (count,) if isinstance(count, str) else count
    return several(value, ctype.item, [n if isinstance(n, int) else getattr(struct, n)
                                       for n in names], counts)


def numeric(ctype):
    """Whether a C type is numbers through and through."""
    if ctype.kind == "struct":
        return all(numeric(field.type) for _, field in ctype.fields)
    return ctype.kind == "primitive" and ctype.cname != "char" or (
        ctype.kind == "array" and numeric(ctype.item))


def several(pointer, item, shape, counts):
    """Numbers as an array, structures of numbers as a structured one; else a list."""
    if numeric(item):
        return view(pointer, dtype(item), tuple(shape))
    return [record(pointer[i], counts) if item.kind == "struct" else text(pointer[i])
            for i in range(int(numpy.prod(shape)))]
