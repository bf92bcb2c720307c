/* An output file that appears whole or not at all.
 *
 * The data go to an unnamed file (O_TMPFILE) in the target's directory, which vanishes with the
 * process, and get their name only when they are complete and on the disk. Replacing an existing
 * file takes a second name for the instant between linkat and rename: linkat never overwrites.
 * File systems without unnamed files get a hidden temporary name instead, removed on abort. What a
 * killed process leaves under a hidden name is removed by the next one that writes to the target.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <hetab/status.h>

typedef struct hetab_atomic_file hetab_atomic_file;

/* Files that are complete, without their names: see core/held_files.h. */
typedef struct hetab_held_files {
  hetab_atomic_file **files;
  size_t count, published; /* published: those that have their names, from the first on */
  struct hetab_held_files *outer;
} hetab_held_files;

/* Refuses at once what could not be published later: HETAB_ERR_EXISTS for an existing file without
 * overwrite; HETAB_ERR_IO for directories, devices, and directories missing or not writable.
 * Symbolic links are followed: the file they lead to is the one replaced. A new file's permissions
 * are 0666 less the umask; a replaced file's are kept. */
hetab_status hetab_atomic_create(hetab_context *ctx, const char *path, int overwrite,
                                 hetab_atomic_file **out);

/* Open for reading and writing, empty; owned by file. */
int hetab_atomic_fd(const hetab_atomic_file *file);

/* The path that was asked for, for messages; owned by file. */
const char *hetab_atomic_path(const hetab_atomic_file *file);

/* Appends, at the descriptor's position. */
hetab_status hetab_atomic_write(hetab_context *ctx, hetab_atomic_file *file, const void *data,
                                size_t size);

/* Sets disk space aside, so that a full disk is found before the work rather than after it. Does
 * nothing where the file system cannot tell. */
hetab_status hetab_atomic_reserve(hetab_context *ctx, hetab_atomic_file *file,
                                  unsigned long long bytes);

/* Asks the system to begin putting on the disk what has been written so far, without waiting: the
 * sync at the end is then short. */
void hetab_atomic_start_sync(const hetab_atomic_file *file);

/* HETAB_ERR_IO naming the file, for a write that failed with the errno value `error`. */
hetab_status hetab_atomic_fail(hetab_context *ctx, const hetab_atomic_file *file, int error);

/* Syncs and publishes, or hands over to a hold; frees the file, whatever the outcome. */
hetab_status hetab_atomic_commit(hetab_context *ctx, hetab_atomic_file *file);

/* Drops the data; NULL is fine. */
void hetab_atomic_abort(hetab_atomic_file *file);
