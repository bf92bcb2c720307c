/* MD5 (RFC 1321): checksums of X3P files and of batches, which nobody attacks. */
#pragma once

#include <stddef.h>

/* 32 lower-case hexadecimal digits and a NUL. */
void hetab_md5(const void *data, size_t size, char digest[33]);
