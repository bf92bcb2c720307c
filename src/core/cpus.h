/* How many threads a job may use. */
#pragma once

/* The processors that taskset, a cluster's scheduler or a container leave this process, or fewer by
 * the calling thread's limit; at least 1. */
int hetab_cpu_count(void);
/* Of the calling thread, for what it starts itself; 0: none. Returns the one before. */
int hetab_cpu_limit(int most);
