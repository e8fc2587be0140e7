/* SPDX-License-Identifier: MIT */
/* Files that the user names. Texts are read as a whole, results are written as a whole. Each
 * failure prints one line on stderr with the file's name. */
#ifndef SIM_FILES_H
#define SIM_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define FILES_TEXT_MIB 16 // longest text

/* Prints `path: what` on stderr. Returns false. */
bool files_complain(const char *path, const char *what);

/* Does the same for an output that cannot be made, for the reason in errno, and names the remedy.
 */
bool files_complain_of_output(const char *path);

/* Reads a text file and adds a NUL. The caller frees the text. Reads a pipe to its end. Returns 0,
 * with one line on stderr, for a folder, for a longer file, or if the file contains a NUL. */
char *files_read_text(const char *path);

/* Creates an output stream. Returns 0, with one line on stderr, if the file cannot be written. */
FILE *files_create(const char *path);

/* Closes an output stream; 0: no stream. Returns false, with one line on stderr, if not all bytes
 * have reached the file, as on a full disk. */
bool files_close(FILE *file, const char *path);

/* Does the same for stdout, which stays open. */
bool files_flush_stdout(void);

/* Replaces the content of the file at `path`. At any moment the file has the old or the new
 * content, because a new file is written beside it and renamed. A symbolic link at `path` is
 * replaced, not followed. The file keeps its permissions and, if the system allows it, its owner
 * and group. A new file has the permissions of the umask. `durable`: the content survives a loss of
 * power; takes two fsync(). Returns false, with one line on stderr; the file is then unchanged. */
bool files_replace(const char *path, const void *bytes, size_t size, bool durable);

/* Checks that files_replace() is possible: the folder of `path` is writable, and `path` is a
 * regular file or does not exist. Returns false, with one line on stderr. */
bool files_check_replaceable(const char *path);

#endif
