/* SPDX-License-Identifier: MIT */
/* Draws a recorded plot with gnuplot: data files in a temporary folder, scripts/plot.gp, one SVG.
 */
#ifndef SIM_PLOT_DRAWING_H
#define SIM_PLOT_DRAWING_H

#include "output/plot.h"

/* Draws the picture of a run that ends at `end`. Returns false, with one line on stderr. */
bool plot_drawing_make(const struct plot *plot, uint64_t end);

/* Returns gnuplot's exit status; 127: gnuplot does not run. */
int plot_drawing_run_gnuplot(char *const arguments[], bool quiet);

#endif
