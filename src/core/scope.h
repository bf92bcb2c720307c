/* How functions end: at their first failure, with what they hold let go. */
#pragma once

#include <stdlib.h>
#include <hetab/status.h>

/* The first failure ends the function. */
#define HETAB_TRY(expression)                                                                      \
  do {                                                                                             \
    hetab_status try_status_ = (expression);                                                       \
    if (try_status_ != HETAB_OK)                                                                   \
      return try_status_;                                                                          \
  } while (0)

/* So does memory that hetab_alloc() did not get, which it has said. */
#define HETAB_NEED(memory) HETAB_TRY((memory) ? HETAB_OK : HETAB_ERR_MEMORY)

/* Where something has to be released otherwise: jumps to `done` with `status` set. */
#define HETAB_GOTO(expression)                                                                     \
  do {                                                                                             \
    status = (expression);                                                                         \
    if (status != HETAB_OK)                                                                        \
      goto done;                                                                                   \
  } while (0)

/* Of a variable: end(&variable) is called where its scope ends, however it is left. */
#define HETAB_ENDS(end) __attribute__((cleanup(end)))

/* Memory that is freed so: HETAB_FREED double *x = ...; */
#define HETAB_FREED HETAB_ENDS(hetab_freed)
static inline void hetab_freed(void *pointer) {
  free(*(void **)pointer);
}

/* Handles: HETAB_HANDLE(hetab_grid) above, HETAB_ENDS(hetab_grid_end) hetab_grid *grid = NULL; */
#define HETAB_HANDLE(type)                                                                         \
  static inline void type##_end(type **handle) {                                                   \
    type##_free(*handle);                                                                          \
  }

/* Ends the function that makes a handle in *out, by its last step: whole, or freed and NULL. */
#define HETAB_MADE(type, out, step)                                                                \
  do {                                                                                             \
    hetab_status made_status_ = (step);                                                            \
    if (made_status_ != HETAB_OK) {                                                                \
      type##_free(*(out));                                                                         \
      *(out) = NULL;                                                                               \
    }                                                                                              \
    return made_status_;                                                                           \
  } while (0)
