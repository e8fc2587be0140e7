/* SPDX-License-Identifier: MIT */
#include "output/plot_drawing.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PLOT_WIDTH   1000 // pixels, as in plot.gp
#define FEW_PACKETS  200  // so few packets are always drawn one by one
#define THIN_PIXELS  1.5  // width of the thinnest bar
#define OVERLAID_MAX 6    // up to so many servos share one pair of axes

extern char **environ;

/* --- gnuplot --- */

int plot_drawing_run_gnuplot(char *const arguments[], bool quiet)
{
    posix_spawn_file_actions_t files;
    pid_t pid = 0;
    int status = 0;
    setenv("LC_ALL", "C.UTF-8", 1); // else gnuplot warns of each character that is not ASCII
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (quiet) {
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    }
    int wrong = posix_spawnp(&pid, "gnuplot", &files, 0, arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    if (wrong || waitpid(pid, &status, 0) != pid || !WIFEXITED(status)) {
        return 127;
    }
    return WEXITSTATUS(status);
}

/* --- drawing: one data file for each kind of thing, parameters in params.gp --- */

/* The layers of the upper pane, in the order of the legend, with the names in plot.gp. */
enum layer {
    LAYER_CONTROLLER,
    LAYER_SERVO,
    LAYER_1_PERCENT,
    LAYER_10_PERCENT,
    LAYER_50_PERCENT,
    LAYER_100_PERCENT,
    LAYER_FAULT,
    LAYER_COLLISION,
    LAYER_BREACH,
    LAYER_DAMAGED,
    LAYERS
};

static const char *const layer_names[LAYERS] = {
    "controller", "servo", "bin1",      "bin10",  "bin50",
    "bin100",     "fault", "collision", "breach", "damaged",
};

/* The data of one drawing. */
struct drawing {
    const struct plot *plot;
    char folder[64];
    uint64_t end;
    double unit_s; // unit of the time axis in seconds
    const char *unit;
    FILE *layer[LAYERS]; // opened on first use
    bool failed;
};

static FILE *open_data(struct drawing *drawing, const char *name)
{
    char path[128];
    snprintf(path, sizeof(path), "%s/%s", drawing->folder, name);
    FILE *file = fopen(path, "w");
    if (!file) {
        drawing->failed = true;
        return fopen("/dev/null", "w");
    }
    return file;
}

/* gnuplot draws a file that a full disk has cut without an error. This detects it. */
static void close_data(struct drawing *drawing, FILE *file)
{
    drawing->failed |= ferror(file) != 0;
    drawing->failed |= fclose(file) != 0;
}

static FILE *layer_file(struct drawing *drawing, enum layer layer)
{
    if (!drawing->layer[layer]) {
        drawing->layer[layer] = open_data(drawing, layer_names[layer]);
    }
    return drawing->layer[layer];
}

static double time_on_axis(const struct drawing *drawing, uint64_t cycle)
{
    return (double)cycle / drawing->plot->clock_Hz / drawing->unit_s;
}

static void draw_bar(struct drawing *drawing, enum layer layer, unsigned row, uint64_t from,
                     uint64_t until)
{
    uint64_t thinnest = (uint64_t)(THIN_PIXELS * (double)drawing->end / PLOT_WIDTH);
    if (until - from < thinnest) {
        until = from + thinnest;
    }
    if (until > drawing->end) {
        until = drawing->end;
    }
    fprintf(layer_file(drawing, layer), "%.9g %.9g %u\n", time_on_axis(drawing, from),
            time_on_axis(drawing, until), row);
}

static void draw_packets(struct drawing *drawing, const struct plot_lane *lane, unsigned row)
{
    enum layer layer = lane->sender == PLOT_SERVO ? LAYER_SERVO : LAYER_CONTROLLER;
    for (unsigned i = 0; i < lane->packets; i++) {
        draw_bar(drawing, layer, row, lane->packet[i].from, lane->packet[i].until);
    }
}

static enum layer bin_layer(uint64_t busy, uint64_t bin)
{
    static const unsigned percent[] = {1, 10, 50};
    unsigned layer = 0;
    while (layer < 3 && busy * 100 > bin * percent[layer]) {
        layer++;
    }
    return LAYER_1_PERCENT + layer;
}

/* Adjacent bins of one shade are one bar. */
static void draw_bins(struct drawing *drawing, const struct plot_lane *lane, unsigned row)
{
    uint64_t bin = drawing->plot->bin;
    for (unsigned b = 0; b < PLOT_BINS;) {
        if (!lane->busy[b]) {
            b++;
            continue;
        }
        enum layer layer = bin_layer(lane->busy[b], bin);
        unsigned first = b++;
        while (b < PLOT_BINS && lane->busy[b] && bin_layer(lane->busy[b], bin) == layer) {
            b++;
        }
        draw_bar(drawing, layer, row, first * bin, b * bin);
    }
}

static void draw_marks(struct drawing *drawing, const struct plot_lane *lane, unsigned row)
{
    for (unsigned m = 0; m < PLOT_MARKS; m++) {
        for (unsigned b = 0; b < PLOT_BINS; b++) {
            uint64_t middle = b * drawing->plot->bin + drawing->plot->bin / 2;
            if (lane->mark[m][b]) {
                fprintf(layer_file(drawing, LAYER_FAULT + m), "%.9g %u\n",
                        time_on_axis(drawing, middle < drawing->end ? middle : drawing->end), row);
            }
        }
    }
}

/* Returns true if packets can be drawn as bars: they are not too many and not too thin. */
static bool bars_will_do(const struct plot *plot, uint64_t end)
{
    uint64_t length = 0;
    for (unsigned i = 0; i < plot->lanes; i++) {
        for (unsigned p = 0; p < plot->lane[i]->packets; p++) {
            length += plot->lane[i]->packet[p].until - plot->lane[i]->packet[p].from;
        }
    }
    bool wide = length * PLOT_WIDTH >= plot->packets * end;
    return plot->packets < PLOT_PACKETS_MAX && (wide || plot->packets <= FEW_PACKETS);
}

static double degrees(uint16_t position)
{
    return position * 300.0 / 1023.0;
}

/* A block of lines `time goal present speed load` for each servo, in degrees, RPM and percent. A
 * time without the servo has NaN. */
static void draw_samples(struct drawing *drawing)
{
    const struct plot *plot = drawing->plot;
    FILE *file = open_data(drawing, "samples");
    for (unsigned i = 0; i < plot->lanes; i++) {
        const struct plot_lane *lane = plot->lane[i];
        if (lane->sender != PLOT_SERVO) {
            continue;
        }
        for (unsigned s = 0; s <= plot->samples; s++) {
            uint64_t time = s < plot->samples ? s * plot->period : drawing->end;
            const struct plot_sample *sample = &lane->sample[s];
            if (sample->goal == PLOT_ABSENT) {
                fprintf(file, "%.9g NaN NaN NaN NaN\n", time_on_axis(drawing, time));
            } else {
                fprintf(file, "%.9g %.5g %.5g %.4g %.4g\n", time_on_axis(drawing, time),
                        degrees(sample->goal), degrees(sample->present),
                        sample->speed * 62 / 1023.0, sample->load * 100 / 1023.0);
            }
        }
        fputs("\n\n", file);
    }
    close_data(drawing, file);
}

static void write_name(const struct plot *plot, const struct plot_lane *lane, FILE *file)
{
    if (plot->buses > 1) {
        fprintf(file, "bus %u ", lane->bus);
    }
    switch (lane->sender) {
    case PLOT_WIRE: fputs("wire", file); break;
    case PLOT_CONTROLLER: fputs(plot->controller, file); break;
    case PLOT_SERVO:
        fprintf(file, lane->duplicate ? "servo %u (%u)" : "servo %u", lane->id,
                lane->duplicate + 1);
        break;
    }
}

/* Writes a gnuplot array with the names of all lanes, or of the servos' lanes. */
static void write_names(const struct plot *plot, const char *what, bool servos, FILE *file)
{
    unsigned count = 0;
    for (unsigned i = 0; i < plot->lanes; i++) {
        count += !servos || plot->lane[i]->sender == PLOT_SERVO;
    }
    fprintf(file, "%ss = %u\narray %s[%u]\n", what, count, what, count ? count : 1);
    for (unsigned i = 0, row = 1; i < plot->lanes; i++) {
        if (!servos || plot->lane[i]->sender == PLOT_SERVO) {
            fprintf(file, "%s[%u] = '", what, row++);
            write_name(plot, plot->lane[i], file);
            fputs("'\n", file);
        }
    }
}

static void write_text(FILE *file, const char *name, const char *text)
{
    fprintf(file, "%s = '", name);
    for (const char *c = text; *c; c++) {
        fprintf(file, *c == '\'' ? "''" : "%c", *c);
    }
    fputs("'\n", file);
}

static void write_parameters(struct drawing *drawing)
{
    const struct plot *plot = drawing->plot;
    FILE *file = open_data(drawing, "params.gp");
    write_text(file, "svg", plot->path);
    write_text(file, "name", plot->title);
    write_text(file, "talker", plot->controller);
    write_text(file, "unit", drawing->unit);
    fprintf(file, "end = %.9g\nwidth = %d\noverlaid = %d\n", time_on_axis(drawing, drawing->end),
            PLOT_WIDTH, OVERLAID_MAX);
    fprintf(file, "panes = 'position%s%s'\n", plot->panes.speed ? " speed" : "",
            plot->panes.load ? " load" : "");
    fprintf(file, "bin = '%.3g ms'\n", (double)plot->bin * 1000.0 / plot->clock_Hz);
    fprintf(file, "layers = '");
    for (unsigned i = 0; i < LAYERS; i++) {
        if (drawing->layer[i]) {
            fprintf(file, "%s ", layer_names[i]);
        }
    }
    fputs("'\n", file);
    write_names(plot, "lane", false, file);
    write_names(plot, "servo", true, file);
    close_data(drawing, file);
}

static void write_sheet(struct drawing *drawing)
{
    const struct plot *plot = drawing->plot;
    bool bars = bars_will_do(plot, drawing->end);
    for (unsigned i = 0; i < plot->lanes; i++) {
        const struct plot_lane *lane = plot->lane[i];
        unsigned row = plot->lanes - i;
        if (bars) {
            draw_packets(drawing, lane, row);
        } else {
            draw_bins(drawing, lane, row);
        }
        draw_marks(drawing, lane, row);
    }
    draw_samples(drawing);
    write_parameters(drawing);
    for (unsigned i = 0; i < LAYERS; i++) {
        if (drawing->layer[i]) {
            close_data(drawing, drawing->layer[i]);
        }
    }
}

static void remove_folder(const char *folder)
{
    static const char *const others[] = {"samples", "params.gp"};
    char path[128];
    for (unsigned i = 0; i < LAYERS + 2; i++) {
        snprintf(path, sizeof(path), "%s/%s", folder,
                 i < LAYERS ? layer_names[i] : others[i - LAYERS]);
        unlink(path);
    }
    rmdir(folder);
}

static void choose_unit(struct drawing *drawing)
{
    double seconds = (double)drawing->end / drawing->plot->clock_Hz;
    drawing->unit = seconds < 0.002 ? "us" : seconds < 2 ? "ms" : "s";
    drawing->unit_s = seconds < 0.002 ? 1e-6 : seconds < 2 ? 1e-3 : 1;
}

/* gnuplot does not report a full disk: checks that the picture is complete. */
static bool is_whole(const char *path)
{
    char tail[16] = "";
    FILE *file = fopen(path, "r");
    if (!file) {
        return false;
    }
    fseek(file, -(long)(sizeof(tail) - 1), SEEK_END);
    size_t got = fread(tail, 1, sizeof(tail) - 1, file);
    fclose(file);
    return got == sizeof(tail) - 1 && strstr(tail, "</svg>");
}

bool plot_drawing_make(const struct plot *plot, uint64_t end)
{
    struct drawing drawing = {.plot = plot, .end = end};
    char set_folder[128];
    char *arguments[] = {"gnuplot", "-e", set_folder, (char *)plot->script, 0};
    choose_unit(&drawing);
    snprintf(drawing.folder, sizeof(drawing.folder), "/tmp/cds55xx-plot.XXXXXX");
    if (!mkdtemp(drawing.folder)) {
        fprintf(stderr, "%s: %s\n", drawing.folder, strerror(errno));
        return false;
    }
    write_sheet(&drawing);
    snprintf(set_folder, sizeof(set_folder), "folder = '%s'", drawing.folder);
    bool good =
        !drawing.failed && plot_drawing_run_gnuplot(arguments, false) == 0 && is_whole(plot->path);
    remove_folder(drawing.folder);
    if (!good) {
        fprintf(stderr, "%s: gnuplot could not draw it: is the disk full?\n", plot->path);
    }
    return good;
}
