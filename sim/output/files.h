/* Files that the user names: texts are read whole, results are written whole, and each failure is
 * one line on stderr with the file's name.
 */
#ifndef SIM_FILES_H
#define SIM_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define FILES_TEXT_MIB 16 // the longest text that is read

/* A text file, ending in a NUL; the caller frees it. 0, with one line on stderr, for a folder, a
 * longer file, or a file with a NUL in it. A pipe is read to its end. */
char *files_read_text(const char *path);

/* Closes an output stream. False, with one line on stderr, if not all that was written to it since
 * it was opened has reached the file: a full disk. A stream of 0 is none, and no error. */
bool files_close(FILE *file, const char *path);

/* As files_close(), for stdout, which stays open. */
bool files_flush_stdout(void);

/* Puts `bytes` into the file at `path`, so that at any moment the file has the old or the new
 * content: writes a new file beside it and renames that. If `path` is a symbolic link, the link is
 * replaced, never followed. The file keeps its permissions and, where the system allows that, its
 * owner and group; a new file gets the permissions of the umask. `durable`: also after a loss of
 * power, which takes the time of two fsync(). False, with one line on stderr: the file is as
 * before. */
bool files_replace(const char *path, const void *bytes, size_t size, bool durable);

/* Is files_replace() possible? The folder of `path` must be writable, and what is at `path`, if
 * anything, must be a regular file. False, with one line on stderr. */
bool files_check_replaceable(const char *path);

#endif
