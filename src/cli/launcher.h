/* Which part of a batch this process is to do, by the launcher that started it. */
#pragma once

#include <stddef.h>

typedef struct launcher_share {
  size_t number, count; /* 1 to count */
  char source[96];      /* what it was taken from; "": nobody launched this process */
} launcher_share;

/* "3/8"; 0 if it is not that. */
int launcher_parse(const char *text, launcher_share *share);
/* From the innermost of Open MPI's, PMI's and Slurm's variables: a step's tasks, or an array's. The
 * exit status after saying what does not fit; -1 to go on. */
int launcher_find(launcher_share *share);
