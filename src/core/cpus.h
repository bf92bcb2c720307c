/* The processors that this process may run on. */
#ifndef HETAB_CORE_CPUS_H
#define HETAB_CORE_CPUS_H

/* At least 1. What taskset, a cluster's scheduler or a container leave of the machine. */
int hetab_cpu_count(void);
/* Binds the calling process to the i-th of them, i modulo their count. */
void hetab_cpu_bind(int i);

#endif
