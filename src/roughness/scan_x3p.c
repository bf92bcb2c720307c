/* ISO 5436-2: a ZIP of main.xml, the heights (in main.xml or a binary file beside it), and
 * checksums. Lengths are in metres, binary numbers little-endian, x the fastest index. */
#include <endian.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include <zip.h>
#include "core/input_file.h"
#include "roughness/heights.h"
#include "core/md5.h"
#include "roughness/x3p_xml.h"

static const size_t most_xml = (size_t)256 << 20;
static const size_t most_inflated = (size_t)16 << 20; /* at any rate of compression */

typedef struct x3p_file {
  hetab_context *ctx;
  const char *path;
  zip_t *zip;
  x3p_description about;
  unsigned char *points, *valid; /* the binary files, or NULL */
  size_t count[3], total;
  const hetab_heights_options *options;
  char folder[256]; /* of main.xml and all else, with its '/' */
} x3p_file;

/* ---- members of the archive ---------------------------------------------------------------- */

/* The whole of a member that has at most `most` bytes; one more byte, 0, follows it. */
static hetab_status read_member(const x3p_file *f, const char *name, size_t most, void **data,
                                size_t *size) {
  zip_stat_t about;
  char whole[512];
  *data = NULL;
  snprintf(whole, sizeof whole, "%s%s", f->folder, name);
  if (zip_stat(f->zip, whole, 0, &about) != 0 || !(about.valid & ZIP_STAT_SIZE))
    return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: no %.100s in it: is this X3P, and whole?",
                      f->path, name);
  if (about.size > most)
    return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                      "%s: %.100s has %llu bytes, more than the %zu it may", f->path, name,
                      (unsigned long long)about.size, most);
  if (about.size > most_inflated && (about.valid & ZIP_STAT_COMP_SIZE) &&
      about.size / 200 > about.comp_size)
    return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                      "%s: %.100s unpacks to more than 200 times its size: no measurement does",
                      f->path, name);
  zip_file_t *member = zip_fopen(f->zip, whole, 0);
  unsigned char *bytes = member ? hetab_alloc(f->ctx, (size_t)about.size + 1, 1) : NULL;
  zip_int64_t got = bytes ? zip_fread(member, bytes, about.size) : -1;
  /* The archive's checksum is compared on reading the end. */
  bool good = got == (zip_int64_t)about.size && zip_fread(member, bytes + about.size, 1) == 0;
  if (member)
    zip_fclose(member);
  if (!good) {
    free(bytes);
    return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: cannot unpack %.100s: is the file damaged?",
                      f->path, name);
  }
  *data = bytes;
  *size = (size_t)about.size;
  return HETAB_OK;
}

static hetab_status check_md5(const x3p_file *f, const char *name, const void *data, size_t size,
                              const char *stated) {
  char digest[33];
  hetab_md5(data, size, digest);
  if (f->options->ignore_checksums || strncasecmp(stated, digest, 32) == 0)
    return HETAB_OK;
  return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                    "%s: the checksum of %.100s is not the one stated: the file was changed or "
                    "damaged: export it again, or read it with --ignore-checksums",
                    f->path, name);
}

/* Archives of a folder have everything in it. */
static void find_folder(x3p_file *f) {
  zip_int64_t at = zip_name_locate(f->zip, "main.xml", ZIP_FL_NODIR);
  const char *name = at >= 0 ? zip_get_name(f->zip, (zip_uint64_t)at, 0) : NULL;
  size_t length = name ? strlen(name) - strlen("main.xml") : 0;
  if (length < sizeof f->folder)
    snprintf(f->folder, sizeof f->folder, "%.*s", (int)length, name ? name : "");
}

/* main.xml, checked against md5checksum.hex where there is one. */
static hetab_status read_description(x3p_file *f) {
  void *xml, *checksum = NULL;
  size_t size, checksum_size;
  find_folder(f);
  HETAB_TRY(read_member(f, "main.xml", most_xml, &xml, &size));
  hetab_status status = HETAB_OK;
  if (zip_name_locate(f->zip, "md5checksum.hex", ZIP_FL_NODIR) >= 0) {
    HETAB_GOTO(read_member(f, "md5checksum.hex", 4096, &checksum, &checksum_size));
    HETAB_GOTO(check_md5(f, "main.xml", xml, size, checksum));
  }
  status = hetab_x3p_parse(f->ctx, f->path, xml, size, &f->about);
done:
  free(checksum);
  free(xml);
  return status;
}

/* ---- sizes --------------------------------------------------------------------------------- */

static size_t bytes_of(char type) {
  return type == 'I' ? 2 : type == 'L' || type == 'F' ? 4 : type == 'D' ? 8 : 0;
}

static hetab_status find_sizes(x3p_file *f) {
  const x3p_description *d = &f->about;
  double total = 1;
  for (int i = 0; i < 3; i++) {
    double size = d->size[0] != 0 ? d->size[i] : i == 0 ? d->list_size : 1;
    if (!(size >= 1 && size <= (double)HETAB_MOST_HEIGHTS && size == floor(size)))
      return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                        "%s: MatrixDimension %c is %g: it has to be a count", f->path, "XYZ"[i],
                        size);
    f->count[i] = (size_t)size;
    total *= size;
  }
  if (total > (double)HETAB_MOST_HEIGHTS)
    return hetab_fail(f->ctx, HETAB_ERR_RANGE, "%s: %g points: at most 2^27", f->path, total);
  f->total = (size_t)total;
  return HETAB_OK;
}

/* Profiles and surfaces on a grid; profiles may have an x of their own for each point. */
static hetab_status check_description(const x3p_file *f) {
  const x3p_description *d = &f->about;
  bool profile = strcmp(d->feature, "PRF") == 0;
  if (!profile && strcmp(d->feature, "SUR") != 0)
    return hetab_fail(f->ctx, HETAB_ERR_UNSUPPORTED,
                      "%s: FeatureType '%s': only profiles (PRF) and surfaces (SUR) have scans",
                      f->path, d->feature);
  if (!d->axis[2].absolute || f->count[2] != 1)
    return hetab_fail(f->ctx, HETAB_ERR_UNSUPPORTED,
                      "%s: heights in several layers, or without values: export one layer",
                      f->path);
  if (profile ? f->count[1] != 1 : d->axis[0].absolute || d->axis[1].absolute)
    return hetab_fail(f->ctx, HETAB_ERR_UNSUPPORTED,
                      "%s: points that lie on no grid: resample the surface evenly", f->path);
  for (int i = 0; i < 3; i++)
    if (d->axis[i].absolute && d->points[0] && !bytes_of(d->axis[i].type))
      return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: DataType of C%c is none of I, L, F, D",
                        f->path, "XYZ"[i]);
  if (!d->axis[0].absolute && !(d->axis[0].increment > 0))
    return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: the Increment of CX has to be above 0",
                      f->path);
  if (!profile && !(d->axis[1].increment > 0))
    return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: the Increment of CY has to be above 0",
                      f->path);
  return HETAB_OK;
}

/* ---- points -------------------------------------------------------------------------------- */

static size_t point_bytes(const x3p_description *d) {
  size_t bytes = 0;
  for (int i = 0; i < 3; i++)
    bytes += d->axis[i].absolute ? bytes_of(d->axis[i].type) : 0;
  return bytes;
}

static hetab_status read_binary(x3p_file *f) {
  const x3p_description *d = &f->about;
  size_t size, wanted = f->total * point_bytes(d), mask = (f->total + 7) / 8;
  void *data;
  HETAB_TRY(read_member(f, d->points, wanted, &data, &size));
  f->points = data;
  if (size != wanted)
    return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                      "%s: %s has %zu bytes, where %zu points need %zu: is it cut off?", f->path,
                      d->points, size, f->total, wanted);
  if (d->points_md5[0])
    HETAB_TRY(check_md5(f, d->points, data, size, d->points_md5));
  if (!d->valid[0])
    return HETAB_OK;
  HETAB_TRY(read_member(f, d->valid, mask + 8, &data, &size));
  f->valid = data;
  if (size < mask)
    return hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: %s has %zu bytes, where %zu points need %zu",
                      f->path, d->valid, size, f->total, mask);
  return d->valid_md5[0] ? check_md5(f, d->valid, data, size, d->valid_md5) : HETAB_OK;
}

/* A number of the file in um; integers count in increments. */
static double decode(const x3p_axis *axis, const unsigned char *bytes) {
  union {
    uint16_t u16;
    int16_t i16;
    uint32_t u32;
    int32_t i32;
    float f32;
    uint64_t u64;
    double f64;
  } raw = {0};
  memcpy(&raw, bytes, bytes_of(axis->type));
  double unit = axis->has_increment ? axis->increment : 1;
  switch (axis->type) {
  case 'I':
    raw.u16 = le16toh(raw.u16);
    return 1e6 * (raw.i16 * unit + axis->offset);
  case 'L':
    raw.u32 = le32toh(raw.u32);
    return 1e6 * (raw.i32 * unit + axis->offset);
  case 'F':
    raw.u32 = le32toh(raw.u32);
    return 1e6 * ((double)raw.f32 + axis->offset);
  default:
    raw.u64 = le64toh(raw.u64);
    return 1e6 * (raw.f64 + axis->offset);
  }
}

/* Where point i is, and how high; NaN: missing. */
static void point_at(const x3p_file *f, size_t i, double *x_um, double *z_um) {
  const x3p_description *d = &f->about;
  const x3p_axis *x = &d->axis[0], *y = &d->axis[1], *z = &d->axis[2];
  if (f->points) {
    const unsigned char *at = f->points + i * point_bytes(d);
    *x_um = x->absolute ? decode(x, at) : 1e6 * (x->offset + (double)i * x->increment);
    at += (x->absolute ? bytes_of(x->type) : 0) + (y->absolute ? bytes_of(y->type) : 0);
    *z_um = decode(z, at);
  } else {
    const double *at = d->datum + i * (size_t)(1 + x->absolute + y->absolute);
    double unit = z->has_increment && (z->type == 'I' || z->type == 'L') ? z->increment : 1;
    *x_um = 1e6 * (x->absolute ? at[0] + x->offset : x->offset + (double)i * x->increment);
    *z_um = 1e6 * (at[x->absolute + y->absolute] * unit + z->offset);
  }
  if (!isfinite(*z_um) || (f->valid && !(f->valid[i / 8] >> (i % 8) & 1)))
    *z_um = (double)NAN;
}

/* Missing points of such a profile have no place either; they show as gaps. */
static hetab_status from_places(const x3p_file *f, hetab_heights **out) {
  HETAB_FREED double *x_um = hetab_alloc(f->ctx, f->total, sizeof *x_um);
  HETAB_FREED double *z_um = hetab_alloc(f->ctx, f->total, sizeof *z_um);
  hetab_status status = HETAB_ERR_MEMORY;
  size_t count = 0;
  for (size_t i = 0; x_um && z_um && i < f->total; i++) {
    point_at(f, i, &x_um[count], &z_um[count]);
    count += isfinite(x_um[count]) && !isnan(z_um[count]);
  }
  if (x_um && z_um)
    status = count < 2 ? hetab_fail(f->ctx, HETAB_ERR_PARSE, "%s: no valid points", f->path)
                       : hetab_heights_from_places(f->ctx, f->path, x_um, z_um, count, 1,
                                                   f->options->resample_um, out);
  return status;
}

static hetab_status from_grid(const x3p_file *f, hetab_heights **out) {
  double x_um;
  HETAB_TRY(hetab_heights_new(f->ctx, f->path, f->count[0], f->count[1], out));
  hetab_heights *h = *out;
  h->kind = f->count[1] > 1 ? HETAB_HEIGHTS_MAP : HETAB_HEIGHTS_SCANS;
  h->spacing_um = 1e6 * f->about.axis[0].increment;
  h->spacing_y_um = f->count[1] > 1 ? 1e6 * f->about.axis[1].increment : 0;
  for (size_t i = 0; i < f->total; i++)
    point_at(f, i, &x_um, &h->z_um[i]);
  return HETAB_OK;
}

static hetab_status read_open(x3p_file *f, hetab_heights **out) {
  HETAB_TRY(read_description(f));
  HETAB_TRY(find_sizes(f));
  HETAB_TRY(check_description(f));
  if (f->about.points[0])
    HETAB_TRY(read_binary(f));
  else if (f->about.datum_count != f->total)
    return hetab_fail(f->ctx, HETAB_ERR_PARSE,
                      "%s: %zu points in its DataList, where MatrixDimension says %zu", f->path,
                      f->about.datum_count, f->total);
  return f->about.axis[0].absolute ? from_places(f, out) : from_grid(f, out);
}

hetab_status hetab_scan_x3p(hetab_context *ctx, const char *path,
                            const hetab_heights_options *options, hetab_heights **out) {
  x3p_file f = {.ctx = ctx, .path = path, .options = options};
  int code, fd;
  HETAB_TRY(hetab_input_open(ctx, path, HETAB_INPUT_TABLE, &fd));
  f.zip = zip_fdopen(fd, 0, &code);
  if (!f.zip) {
    close(fd);
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    hetab_fail(ctx, HETAB_ERR_PARSE, "%s: %s: is the file cut off?", path,
               zip_error_strerror(&error));
    zip_error_fini(&error);
    return HETAB_ERR_PARSE;
  }
  hetab_status status = read_open(&f, out);
  zip_discard(f.zip);
  free(f.points);
  free(f.valid);
  free(f.about.datum);
  return status;
}
