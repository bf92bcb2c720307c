/* The clock that durations are measured with. */
#ifndef HETAB_CORE_CLOCK_H
#define HETAB_CORE_CLOCK_H

/* Seconds, monotonic, from an arbitrary start. */
double hetab_seconds(void);

#endif
