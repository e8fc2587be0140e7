/* SPDX-License-Identifier: MIT */
/* Checks the files that the command line names. An output must not be an input, the EEPROM file, a
 * file of the state folder or another output: opening it would destroy its content.
 *
 * Two names are the same file if they have the same device and inode (hard and symbolic links), or,
 * for a file that does not exist yet, the same folder and name. Character devices, pipes and
 * sockets lose nothing: they may be named several times. */
#ifndef SIM_NAMED_FILES_H
#define SIM_NAMED_FILES_H

#include <stdbool.h>

#include "testbench.h"

/* Call it before an output is opened. It opens and changes no file. Returns false, with one line on
 * stderr that names both options. */
bool named_files_check(const struct testbench_options *options);

#endif
