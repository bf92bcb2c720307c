#include "signals.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t pending_signal;

static void note_signal(int signal) {
  pending_signal = signal;
}

void cli_catch_signals(void) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
    struct sigaction action = {0}, old;
    sigaction(signals[i], NULL, &old);
    if (old.sa_handler == SIG_IGN) /* nohup, or a shell's background job: keep it so */
      continue;
    action.sa_handler = note_signal;
    action.sa_flags = (int)SA_RESETHAND; /* and no SA_RESTART: a blocked read must return */
    sigaction(signals[i], &action, NULL);
  }
  signal(SIGXFSZ, SIG_IGN); /* the write fails instead, and says so */
}

int cli_signal(void) {
  return pending_signal;
}
