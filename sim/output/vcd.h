/* A value change dump (IEEE 1364), as waveform viewers such as GTKWave read it.
 *
 * Signals may be declared while the run goes on: the changes are kept in a temporary file until
 * vcd_close() knows all names. Time stamps never go back, and one run gives one file, byte by byte.
 */
#ifndef SIM_VCD_H
#define SIM_VCD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define VCD_SIGNALS_MAX 2400 // three of each servo on three buses, and more
#define VCD_NAME_SIZE   48

struct vcd_signal {
    char name[VCD_NAME_SIZE];
    uint8_t bits;
    uint32_t value;
};

struct vcd {
    const char *path;
    FILE *file; // 0: there is none, and every call does nothing
    FILE *body;
    uint32_t clock_Hz;
    uint64_t time; // of the latest change written, cycles
    unsigned count;
    struct vcd_signal signal[VCD_SIGNALS_MAX];
};

/* False, with one line on stderr, when the file cannot be written. */
bool vcd_open(struct vcd *vcd, const char *path, uint32_t clock_Hz);

/* False, with one line on stderr, when not everything could be written. */
bool vcd_close(struct vcd *vcd);

/* The signal of that name; declared, at value 0, when it is new. */
unsigned vcd_signal(struct vcd *vcd, const char *name, unsigned bits);
void vcd_change(struct vcd *vcd, unsigned signal, uint64_t now, uint32_t value);

#endif
