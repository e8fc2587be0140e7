/* SPDX-License-Identifier: MIT */
#include "output/vcd.h"

#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "output/files.h"

#define TICKS_PER_SECOND 10000000000u // 100 ps: one cycle at 16 MHz (62.5 ns) has 625
#define COPY_SIZE        4096

bool vcd_open(struct vcd *vcd, const char *path, uint32_t clock_Hz)
{
    *vcd = (struct vcd){.path = path, .clock_Hz = clock_Hz};
    vcd->file = files_create(path);
    if (!vcd->file) {
        return false;
    }
    vcd->body = tmpfile();
    if (!vcd->body) {
        files_complain(path, strerror(errno));
        fclose(vcd->file);
        vcd->file = 0;
        return false;
    }
    fputs("#0\n", vcd->body);
    return true;
}

static char code(unsigned signal, unsigned digit)
{
    return (char)('!' + (digit ? signal / 90 : signal % 90));
}

static void write_value(const struct vcd *vcd, unsigned signal)
{
    const struct vcd_signal *s = &vcd->signal[signal];
    if (s->bits == 1) {
        fputc(s->value ? '1' : '0', vcd->body);
    } else {
        fputc('b', vcd->body);
        for (unsigned bit = s->bits; bit-- > 0;) {
            fputc(s->value >> bit & 1 ? '1' : '0', vcd->body);
        }
        fputc(' ', vcd->body);
    }
    fprintf(vcd->body, "%c%c\n", code(signal, 0), code(signal, 1));
}

static void write_time(struct vcd *vcd, uint64_t now)
{
    if (now > vcd->time) {
        vcd->time = now;
        uint64_t seconds = now / vcd->clock_Hz;
        uint64_t rest = now % vcd->clock_Hz;
        uint64_t ticks = seconds * TICKS_PER_SECOND + rest * TICKS_PER_SECOND / vcd->clock_Hz;
        fprintf(vcd->body, "#%" PRIu64 "\n", ticks);
    }
}

unsigned vcd_signal(struct vcd *vcd, const char *name, unsigned bits)
{
    for (unsigned i = 0; i < vcd->count; i++) {
        if (strcmp(vcd->signal[i].name, name) == 0) {
            return i;
        }
    }
    if (!vcd->file || vcd->count == VCD_SIGNALS_MAX) {
        return VCD_SIGNALS_MAX;
    }
    struct vcd_signal *s = &vcd->signal[vcd->count];
    snprintf(s->name, sizeof(s->name), "%s", name);
    s->bits = (uint8_t)bits;
    write_value(vcd, vcd->count);
    return vcd->count++;
}

void vcd_change(struct vcd *vcd, unsigned signal, uint64_t now, uint32_t value)
{
    if (!vcd->file || signal >= vcd->count || vcd->signal[signal].value == value) {
        return;
    }
    write_time(vcd, now);
    vcd->signal[signal].value = value;
    write_value(vcd, signal);
}

bool vcd_close(struct vcd *vcd)
{
    if (!vcd->file || !vcd->body) {
        return true;
    }
    fputs("$timescale 100 ps $end\n$scope module cds55xx $end\n", vcd->file);
    for (unsigned i = 0; i < vcd->count; i++) {
        fprintf(vcd->file, "$var wire %u %c%c %s $end\n", vcd->signal[i].bits, code(i, 0),
                code(i, 1), vcd->signal[i].name);
    }
    fputs("$upscope $end\n$enddefinitions $end\n", vcd->file);
    char block[COPY_SIZE];
    size_t got = 0;
    bool good = fflush(vcd->body) == 0 && !ferror(vcd->body);
    rewind(vcd->body); // clears the error flag
    while ((got = fread(block, 1, sizeof(block), vcd->body)) > 0) {
        fwrite(block, 1, got, vcd->file);
    }
    good = !ferror(vcd->body) && good;
    fclose(vcd->body);
    if (!good) {
        fprintf(stderr, "%s: its temporary file could not be written: is the disk full?\n",
                vcd->path);
    }
    good = files_close(vcd->file, vcd->path) && good;
    vcd->file = 0;
    return good;
}
