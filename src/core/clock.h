/* The clock that durations are measured with. */
#pragma once

/* Seconds, monotonic, from an arbitrary start. */
double hetab_seconds(void);
