/* SPDX-License-Identifier: MIT */
#include "data_path.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

void data_path(char path[DATA_PATH_SIZE], const char *name)
{
    static const char *const folders[] = {"/../share/cds55xx", "/../.."};
    char program[DATA_PATH_SIZE - 64];
    struct stat what;
    ssize_t size = readlink("/proc/self/exe", program, sizeof(program) - 1);
    program[size > 0 ? size : 0] = 0;
    char *slash = strrchr(program, '/');
    if (slash) {
        *slash = 0;
    }
    for (unsigned i = 0; i < sizeof(folders) / sizeof(folders[0]); i++) {
        snprintf(path, DATA_PATH_SIZE, "%s%s/%s", program, folders[i], name);
        if (stat(path, &what) == 0) {
            return;
        }
    }
}
