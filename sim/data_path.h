/* SPDX-License-Identifier: MIT */
/* Where the simulator's own data are: the boards, and the script of gnuplot. */
#ifndef SIM_DATA_PATH_H
#define SIM_DATA_PATH_H

#define DATA_PATH_SIZE 1024

/* Writes the path of `name`, for example "boards", into `path`: below ../share/cds55xx beside the
 * folder of this program (installed), or else below the source tree, whose build/host/ has the
 * program. */
void data_path(char path[DATA_PATH_SIZE], const char *name);

#endif
