#include "core/option_size.h"

#include <string.h>

hetab_status hetab_options_take(hetab_context *ctx, const void *given, void *own, size_t size) {
  memset(own, 0, size);
  if (!given)
    return HETAB_OK;
  size_t stated = *(const size_t *)given;
  if (!stated)
    stated = size;
  for (size_t i = size; i < stated; i++)
    if (((const unsigned char *)given)[i])
      return hetab_fail(ctx, HETAB_ERR_ARGUMENT,
                        "options of %zu bytes, of which this hetab (%s) knows %zu, and more is "
                        "set: use the headers and the library of one version",
                        stated, hetab_version(), size);
  memcpy(own, given, stated < size ? stated : size);
  return HETAB_OK;
}
