/* A progress bar with rate and time left, on standard error, if that is a terminal. */
#pragma once

#include <hetab/status.h>

/* From now on the context's jobs stop on a signal, and show what they are told to. */
void cli_progress_watch(hetab_context *ctx);
/* From now on they show as `label`, unless quiet. */
void cli_progress_begin(const char *label, int quiet);
/* The same, of other things than entries. */
void cli_progress_count(const char *label, const char *unit, int quiet);
/* Whether a bar is drawn: other lines on standard error would break it. */
int cli_progress_visible(void);
/* Clear the bar; fine without one. */
void cli_progress_end(void);
