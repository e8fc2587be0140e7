/* SPDX-License-Identifier: MIT */
/* A value change dump (IEEE 1364) for waveform viewers such as GTKWave.
 *
 * Signals may be declared during the run: a temporary file keeps the changes until vcd_close().
 * Time stamps never decrease. The same run gives the same file, byte by byte. */
#ifndef SIM_VCD_H
#define SIM_VCD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define VCD_SIGNALS_MAX 2400 // more than three for each servo on three buses
#define VCD_NAME_SIZE   48

struct vcd_signal {
    char name[VCD_NAME_SIZE];
    uint8_t bits;
    uint32_t value;
};

struct vcd {
    const char *path;
    FILE *file; // 0: every call does nothing
    FILE *body;
    uint32_t clock_Hz;
    uint64_t time; // cycle of the latest change
    unsigned count;
    struct vcd_signal signal[VCD_SIGNALS_MAX];
};

/* Returns false, with one line on stderr, if the file cannot be written. */
bool vcd_open(struct vcd *vcd, const char *path, uint32_t clock_Hz);

/* Returns false, with one line on stderr, if not all bytes could be written. */
bool vcd_close(struct vcd *vcd);

/* Returns the signal with that name, and declares it with value 0 if it is new. */
unsigned vcd_signal(struct vcd *vcd, const char *name, unsigned bits);
void vcd_change(struct vcd *vcd, unsigned signal, uint64_t now, uint32_t value);

#endif
