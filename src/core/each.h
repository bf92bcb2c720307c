/* Many pieces of one job, on all of the processors that it may use. */
#pragma once

#include "core/context.h"

enum { HETAB_MOST_WORKERS = 16 };

/* Piece i of the job; what is kept for a worker has no other user meanwhile. Not the context's. */
typedef void (*hetab_piece_fn)(void *user, size_t i, int worker);

/* Below HETAB_MOST_WORKERS: how many workers hetab_each() takes. */
int hetab_worker_count(void);

/* Every piece once, in about their order. Progress is told between the calling thread's own;
 * HETAB_ERR_CANCELLED: not all were done. */
hetab_status hetab_each(hetab_context *ctx, size_t count, hetab_piece_fn piece, void *user);
/* The same for one step of a longer job, whose progress its caller tells: only asked is whether to
 * stop. */
hetab_status hetab_each_within(hetab_context *ctx, size_t count, hetab_piece_fn piece, void *user);
