/* SPDX-License-Identifier: MIT */
#include "output/files.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define BLOCK       65536u
#define TEXT_MAX    (FILES_TEXT_MIB * 1024u * 1024u)
#define SUFFIX      ".XXXXXX"
#define PERMISSIONS 0777

bool files_complain(const char *path, const char *what)
{
    fprintf(stderr, "%s: %s\n", path, what);
    return false;
}

/* --- reading --- */

/* Returns 0, with errno, if the file cannot be read. Stops after one byte more than TEXT_MAX. */
static char *read_all(FILE *file, size_t *size)
{
    char *text = 0;
    size_t got = 0;
    *size = 0;
    do {
        char *bigger = realloc(text, *size + BLOCK + 1);
        if (!bigger) {
            break;
        }
        text = bigger;
        got = fread(text + *size, 1, BLOCK, file);
        *size += got;
        text[*size] = 0;
    } while (got > 0 && *size <= TEXT_MAX);
    if (text && !ferror(file)) {
        return text;
    }
    free(text);
    return 0;
}

char *files_read_text(const char *path)
{
    FILE *file = fopen(path, "r");
    size_t size = 0;
    char *text = file ? read_all(file, &size) : 0;
    const char *wrong = !text                  ? strerror(errno)
                        : size > TEXT_MAX      ? "longer than 16 MiB"
                        : strlen(text) != size ? "is no text: there is a NUL in it"
                                               : 0;
    if (file) {
        fclose(file);
    }
    if (!wrong) {
        return text;
    }
    files_complain(path, wrong);
    free(text);
    return 0;
}

/* --- output streams --- */

bool files_complain_of_output(const char *path)
{
    char what[160];
    snprintf(what, sizeof(what), "%s%s", strerror(errno),
             errno == ENOENT   ? "; make its folder first, or name another folder"
             : errno == EACCES ? "; name a file in a folder that you may write to"
                               : "");
    return files_complain(path, what);
}

FILE *files_create(const char *path)
{
    FILE *file = fopen(path, "w");
    if (!file) {
        files_complain_of_output(path);
    }
    return file;
}

bool files_close(FILE *file, const char *path)
{
    if (!file) {
        return true;
    }
    bool good = !ferror(file);
    good = fclose(file) == 0 && good;
    return good || files_complain(path, "not everything could be written: is the disk full?");
}

bool files_flush_stdout(void)
{
    bool good = fflush(stdout) == 0 && !ferror(stdout);
    return good ||
           files_complain("stdout", "not everything could be written: is the disk full, or has "
                                    "its reader left?");
}

/* --- replacing --- */

/* Writes "." for a name without a slash. */
static bool find_folder(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    size_t size = slash ? (size_t)(slash - path) + 1 : 0;
    if (size >= PATH_MAX) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(folder, path, size);
    strcpy(folder + size, slash ? "" : ".");
    return true;
}

static bool write_all(int file, const uint8_t *bytes, size_t size)
{
    while (size) {
        ssize_t put = write(file, bytes, size);
        if (put < 0 && errno != EINTR) {
            return false;
        }
        bytes += put > 0 ? put : 0;
        size -= put > 0 ? (size_t)put : 0;
    }
    return true;
}

/* Copies permissions and owner of the existing file. The owner comes first, because a change of
 * owner clears permissions. Only root may change an owner, so a failure of fchown() is no error. */
static bool copy_access(int file, const char *path)
{
    struct stat old;
    if (lstat(path, &old) == 0 && S_ISREG(old.st_mode)) {
        bool kept = fchown(file, old.st_uid, old.st_gid) == 0;
        (void)kept;
        return fchmod(file, old.st_mode & PERMISSIONS) == 0;
    }
    mode_t mask = umask(0);
    umask(mask);
    return fchmod(file, 0666 & ~mask) == 0;
}

static bool sync_folder(const char *path)
{
    char folder[PATH_MAX];
    int file = find_folder(path, folder) ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    bool good = file >= 0 && fsync(file) == 0;
    if (file >= 0) {
        close(file);
    }
    return good || errno == EINVAL; // the file system has no fsync() for folders
}

bool files_replace(const char *path, const void *bytes, size_t size, bool durable)
{
    char fresh[PATH_MAX];
    if ((size_t)snprintf(fresh, sizeof(fresh), "%s" SUFFIX, path) >= sizeof(fresh)) {
        return files_complain(path, strerror(ENAMETOOLONG));
    }
    int file = mkostemp(fresh, O_NOFOLLOW | O_CLOEXEC); // and O_EXCL: never an existing file
    if (file < 0) {
        return files_complain(path, strerror(errno));
    }
    bool good =
        write_all(file, bytes, size) && copy_access(file, path) && (!durable || fsync(file) == 0);
    int error = errno;
    if (close(file) != 0 && good) {
        error = errno;
        good = false;
    }
    if (!good || rename(fresh, path) != 0) {
        error = good ? errno : error;
        unlink(fresh);
        return files_complain(path, strerror(error));
    }
    return !durable || sync_folder(path) || files_complain(path, strerror(errno));
}

bool files_check_replaceable(const char *path)
{
    struct stat found;
    char folder[PATH_MAX];
    if (lstat(path, &found) == 0 && !S_ISREG(found.st_mode)) {
        return files_complain(path,
                              S_ISLNK(found.st_mode)
                                  ? "is a symbolic link, which the simulator does not follow: name "
                                    "the file itself"
                                  : "is no regular file");
    }
    return (find_folder(path, folder) && access(folder, W_OK | X_OK) == 0) ||
           files_complain_of_output(path);
}
