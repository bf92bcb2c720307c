#include "plan/record.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <hetab/output_file.h>

#include "core/context.h"
#include "core/md5.h"
#include "plan/plan_key.h"
#include "plan/scene.h"

char *hetab_batch_path(hetab_context *ctx, const char *folder, const char *name,
                       const char *ending) {
  char *path;
  if (asprintf(&path, "%s/%s%s", folder, name, ending) >= 0)
    return path;
  hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  return NULL;
}

const char *hetab_batch_ending(hetab_consumer consumer) {
  return consumer == HETAB_CONSUMER_MERL   ? ".binary"
         : consumer == HETAB_CONSUMER_EXR  ? ".exr"
         : consumer == HETAB_CONSUMER_HDF5 ? ".h5"
                                           : ".bsdf";
}

/* ---- files --------------------------------------------------------------------------------- */

static double modified(const struct stat *about) {
  return (double)about->st_mtim.tv_sec + 1e-9 * (double)about->st_mtim.tv_nsec;
}

static bool file_md5(const char *path, char digest[HETAB_KEY]) {
  struct stat about;
  int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    return false;
  bool good = fstat(fd, &about) == 0 && about.st_size > 0;
  void *data = good ? mmap(NULL, (size_t)about.st_size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
  close(fd);
  if (data == MAP_FAILED)
    return false;
  hetab_md5(data, (size_t)about.st_size, digest);
  munmap(data, (size_t)about.st_size);
  return true;
}

json_t *hetab_record_file(hetab_context *ctx, const char *folder, const char *name,
                          const char *ending) {
  char digest[HETAB_KEY], *file = hetab_batch_path(ctx, folder, name, ending);
  struct stat about;
  json_t *json = NULL;
  if (file && stat(file, &about) == 0 && file_md5(file, digest))
    json = json_pack("{ss+ sI sf ss}", "path", name, ending, "bytes", (json_int_t)about.st_size,
                     "modified", modified(&about), "md5", digest);
  free(file);
  return json;
}

static bool file_is_there(hetab_context *ctx, const json_t *file, const char *folder, bool verify) {
  const char *name, *md5;
  char digest[HETAB_KEY] = "";
  json_int_t bytes;
  double time;
  struct stat about;
  if (json_unpack((json_t *)file, "{ss sI sF ss}", "path", &name, "bytes", &bytes, "modified",
                  &time, "md5", &md5) != 0 ||
      strchr(name, '/'))
    return false;
  HETAB_FREED char *path = hetab_batch_path(ctx, folder, name, "");
  bool good =
      path && stat(path, &about) == 0 && about.st_size == (off_t)bytes &&
      (verify ? file_md5(path, digest) && strcmp(digest, md5) == 0 : modified(&about) == time);
  return good;
}

/* ---- texts --------------------------------------------------------------------------------- */

hetab_status hetab_folder_text(hetab_context *ctx, hetab_folder_file *file) {
  *file = (hetab_folder_file){0};
  file->stream = open_memstream(&file->bytes, &file->size);
  return file->stream ? HETAB_OK : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
}

hetab_status hetab_folder_save(hetab_context *ctx, hetab_folder_file *file, const char *folder,
                               const char *name) {
  char *path = hetab_batch_path(ctx, folder, name, "");
  int failed = fclose(file->stream);
  hetab_status status = path && !failed ? hetab_text_save(ctx, path, file->bytes, file->size, 1)
                                        : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  free(path);
  free(file->bytes);
  return status;
}

const char *hetab_record_text(const json_t *record, const char *key) {
  const char *found = json_string_value(json_object_get(record, key));
  return found ? found : "";
}

double hetab_record_number(const json_t *record, const char *key) {
  return json_number_value(json_object_get(record, key));
}

/* ---- records ------------------------------------------------------------------------------- */

json_t *hetab_record_load(hetab_context *ctx, const hetab_scene *scene, size_t i,
                          const char *folder) {
  HETAB_FREED char *path =
      hetab_batch_path(ctx, folder, hetab_surface_name(scene->surfaces[i]), ".json");
  return path ? json_load_file(path, 0, NULL) : NULL;
}

hetab_status hetab_record_save(hetab_context *ctx, const hetab_scene *scene, size_t i,
                               const char *folder, json_t *record) {
  char *path = hetab_batch_path(ctx, folder, hetab_surface_name(scene->surfaces[i]), ".json");
  char *text = record ? json_dumps(record, JSON_INDENT(2)) : NULL;
  hetab_status status = path && text ? hetab_text_save(ctx, path, text, strlen(text), 1)
                                     : hetab_fail(ctx, HETAB_ERR_MEMORY, "out of memory");
  free(text);
  free(path);
  json_decref(record);
  return status;
}

static bool is_current(hetab_context *ctx, const json_t *record, const char *key,
                       const char *folder, bool verify, hetab_batch_result *r) {
  const char *found;
  json_t *files, *file;
  size_t n;
  if (json_unpack((json_t *)record, "{ss so sF sF sF sF sF sb}", "key", &found, "files", &files,
                  "bytes", &r->bytes, "seconds", &r->seconds, "error_l1", &r->error_l1, "bias",
                  &r->bias, "energy", &r->energy, "fits", &r->fits) != 0 ||
      strcmp(found, key) != 0 || !json_is_array(files))
    return false;
  r->table_bytes = (double)json_integer_value(json_object_get(json_array_get(files, 0), "bytes"));
  json_array_foreach(files, n, file) if (!file_is_there(ctx, file, folder, verify)) return false;
  return true;
}

int hetab_batch_done(hetab_context *ctx, const hetab_scene *scene, const hetab_plan *plan, size_t i,
                     const char *folder, int verify, hetab_batch_result *result) {
  char key[HETAB_KEY];
  hetab_batch_result own;
  json_t *record = hetab_record_load(ctx, scene, i, folder);
  bool done = record && hetab_item_key(ctx, scene, plan, i, key) == HETAB_OK &&
              is_current(ctx, record, key, folder, verify, result ? result : &own);
  json_decref(record);
  return done;
}
