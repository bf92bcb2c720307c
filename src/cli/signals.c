#include "signals.h"

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <time.h>

static volatile sig_atomic_t pending_signal;

static double now_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* timeout(1), mpirun and schedulers send a signal to the process and to its group: what arrives
 * twice within a moment was sent once. */
static void note_signal(int number) {
  static double first_s;
  if (pending_signal != number) {
    pending_signal = number;
    first_s = now_s();
  } else if (now_s() > first_s + 0.3) {
    signal(number, SIG_DFL);
    raise(number); /* delivered when this handler returns */
  }
}

static const int caught[] = {SIGINT, SIGTERM, SIGHUP};
static bool
    ignored[sizeof caught / sizeof *caught]; /* by nohup, or a shell's background job: kept so */

static void catch_all(void) {
  for (size_t i = 0; i < sizeof caught / sizeof *caught;
       i++) /* no SA_RESTART: a blocked read must return */
    sigaction(caught[i], &(struct sigaction){.sa_handler = ignored[i] ? SIG_IGN : note_signal},
              NULL);
}

void cli_catch_signals(void) {
  for (size_t i = 0; i < sizeof caught / sizeof *caught; i++) {
    struct sigaction before;
    sigaction(caught[i], NULL, &before);
    ignored[i] = before.sa_handler == SIG_IGN;
  }
  catch_all();
  signal(SIGXFSZ, SIG_IGN); /* the write fails instead, and says so */
}

/* Caught again whenever somebody asks: with a device comes LLVM, which puts handlers of its own
 * there, whose second signal kills. */
int cli_signal(void) {
  if (!pending_signal)
    catch_all();
  return pending_signal;
}
