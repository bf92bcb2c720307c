/* Signals that ask the program to stop. */
#pragma once

/* SIGINT, SIGTERM and SIGHUP raise a flag; the second one of a kind, a moment later, ends the
 * program at once. */
void cli_catch_signals(void);
/* The signal that asked to stop; 0: none. */
int cli_signal(void);
