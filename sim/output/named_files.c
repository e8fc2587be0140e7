/* SPDX-License-Identifier: MIT */
#include "output/named_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINKS_MAX 40 // links in a chain of symbolic links, as in Linux
#define FILES_MAX 16

/* Identifies a file: its device and inode, or device and inode of its folder and its name. */
struct place {
    bool known;  // false: a device, a pipe, or a path that cannot be opened
    bool exists; // false: device and inode are those of the folder
    dev_t device;
    ino_t inode;
    char name[NAME_MAX + 1]; // in the folder; "" if the file exists
};

struct named_file {
    const char *option;
    const char *path;
    bool written; // opened for writing, or replaced at the end of the run
    struct place place;
};

struct named_files {
    struct named_file file[FILES_MAX];
    unsigned count;
};

/* --- where a file is --- */

static size_t folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

static void set_place(struct place *place, const struct stat *found)
{
    place->known =
        !S_ISCHR(found->st_mode) && !S_ISFIFO(found->st_mode) && !S_ISSOCK(found->st_mode);
    place->device = found->st_dev;
    place->inode = found->st_ino;
}

/* The file does not exist: uses its folder. */
static void find_folder(struct place *place, const char *path)
{
    char folder[PATH_MAX];
    struct stat found;
    size_t length = folder_length(path);
    size_t name_length = strlen(path + length);
    memcpy(folder, path, length);
    strcpy(folder + length, length ? "" : ".");
    if (name_length == 0 || name_length > NAME_MAX || stat(folder, &found) != 0) {
        return;
    }
    set_place(place, &found);
    memcpy(place->name, path + length, name_length + 1);
}

/* Replaces the name of a symbolic link by its target. Returns false if `path` is no link, or too
 * long. */
static bool follow_link(char path[PATH_MAX])
{
    char target[PATH_MAX];
    ssize_t size = readlink(path, target, sizeof(target) - 1);
    size_t length = size > 0 && target[0] != '/' ? folder_length(path) : 0;
    if (size <= 0 || length + (size_t)size >= PATH_MAX) {
        return false;
    }
    memcpy(path + length, target, (size_t)size);
    path[length + (size_t)size] = 0;
    return true;
}

/* stat() does not resolve a link whose target does not exist; fopen() would create the target. */
static struct place find_place(const char *name)
{
    struct place place = {.known = false};
    struct stat found;
    char path[PATH_MAX];
    if ((size_t)snprintf(path, sizeof(path), "%s", name) >= sizeof(path)) {
        return place;
    }
    for (unsigned links = 0; links < LINKS_MAX; links++) {
        if (stat(path, &found) == 0) {
            set_place(&place, &found);
            place.exists = true;
            return place;
        }
        if (!follow_link(path)) {
            find_folder(&place, path);
            return place;
        }
    }
    return place;
}

static bool is_same(const struct place *a, const struct place *b)
{
    return a->known && b->known && a->exists == b->exists && a->device == b->device &&
           a->inode == b->inode && strcmp(a->name, b->name) == 0;
}

/* --- the files of a run --- */

static void add(struct named_files *files, const char *option, const char *path, bool written)
{
    if (path) {
        files->file[files->count++] = (struct named_file){
            .option = option, .path = path, .written = written, .place = find_place(path)};
    }
}

/* The simulator does not open stdout and stderr, which may be the same file: 2>&1. */
static void add_stream(struct named_files *files, const char *option, int descriptor)
{
    struct stat found;
    struct named_file *file = &files->file[files->count];
    if (fstat(descriptor, &found) == 0) {
        *file = (struct named_file){.option = option, .place = {.exists = true}};
        set_place(&file->place, &found);
        files->count++;
    }
}

static bool refuse(const struct named_file *output, const char *option, const char *path)
{
    fprintf(stderr, "cds55xx-sim: %s %s and %s%s%s are the same file: name another file for %s\n",
            output->option, output->path, option, path ? " " : "", path ? path : "",
            output->option);
    return false;
}

static bool check_pairs(const struct named_files *files)
{
    for (unsigned i = 0; i < files->count; i++) {
        for (unsigned j = i + 1; j < files->count; j++) {
            const struct named_file *a = &files->file[i];
            const struct named_file *b = &files->file[j];
            if ((a->written || b->written) && is_same(&a->place, &b->place)) {
                return a->written ? refuse(a, b->option, b->path) : refuse(b, a->option, a->path);
            }
        }
    }
    return true;
}

/* A scenario may put servos of any ID on the bus, so each file whose name fits a servo is checked.
 */
static bool find_in_state(const char *folder, const struct place *place, char path[PATH_MAX])
{
    struct place whole = find_place(folder);
    if (!place->exists) {
        snprintf(path, PATH_MAX, "%s/%s", folder, place->name);
        return whole.known && whole.exists && whole.device == place->device &&
               whole.inode == place->inode && fnmatch(SERVO_EEPROM_FILES, place->name, 0) == 0;
    }
    DIR *listing = opendir(folder);
    struct dirent *entry = 0;
    bool found = false;
    while (listing && !found && (entry = readdir(listing))) {
        if (fnmatch(SERVO_EEPROM_FILES, entry->d_name, 0) == 0 &&
            (size_t)snprintf(path, PATH_MAX, "%s/%s", folder, entry->d_name) < PATH_MAX) {
            struct place servo = find_place(path);
            found = is_same(place, &servo);
        }
    }
    if (listing) {
        closedir(listing);
    }
    return found;
}

static bool check_state(const struct named_files *files, const char *folder)
{
    char path[PATH_MAX];
    for (unsigned i = 0; i < files->count && folder; i++) {
        const struct named_file *file = &files->file[i];
        if (file->written && file->place.known && find_in_state(folder, &file->place, path)) {
            return refuse(file, "--state", path);
        }
    }
    return true;
}

bool named_files_check(const struct testbench_options *options)
{
    struct named_files files = {.count = 0};
    char board[BOARD_PATH_SIZE];
    char chip[BOARD_PATH_SIZE];
    add(&files, "--transcript", options->transcript, true);
    add(&files, "--vcd", options->vcd, true);
    add(&files, "--csv", options->csv, true);
    add(&files, "--times", options->cycles.times, true);
    add(&files, "--plot", options->plot, true);
    add(&files, "--eeprom", options->eeprom, true);
    add(&files, "--poke", options->poke, true);
    add(&files, "the ELF", options->elf, false);
    add(&files, "--script", options->script, false);
    add(&files, "--host", options->pc, false);
    add(&files, "--state", options->state, false);
    if (options->board) {
        board_paths(options->boards, options->board, board, chip);
        add(&files, "--board", board, false);
        add(&files, "--board", chip, false);
    }
    add_stream(&files, "stdout", STDOUT_FILENO);
    add_stream(&files, "stderr", STDERR_FILENO);
    return check_pairs(&files) && check_state(&files, options->state);
}
