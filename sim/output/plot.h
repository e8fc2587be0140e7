/* SPDX-License-Identifier: MIT */
/* A picture of a run, drawn by gnuplot at its end (--plot): the upper pane shows the sender at
 * each time and what went wrong, the lower pane goal and present position of the servos. Panes for
 * speed and load follow on request.
 *
 * The memory does not grow with the run: time is divided into bins, whose width doubles when all
 * are used. Single packets are kept only while they are few. */
#ifndef SIM_PLOT_H
#define SIM_PLOT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "data_path.h"
#include "servo/servos.h"
#include "wire/schedule.h"

#define PLOT_BINS        1024 // for the whole run; at least half of them are used
#define PLOT_SAMPLES     2048 // of the servos, in the whole run; at least half are used
#define PLOT_PACKETS_MAX 4000
#define PLOT_ABSENT      UINT16_MAX
#define PLOT_SETS_MAX    3 // buses

enum plot_mark { PLOT_FAULT, PLOT_COLLISION, PLOT_BREACH, PLOT_DAMAGED, PLOT_MARKS };
enum plot_sender { PLOT_WIRE, PLOT_CONTROLLER, PLOT_SERVO };

struct plot_packet {
    uint64_t from, until;
};

struct plot_sample {
    uint16_t goal, present; // positions, 0..1023
    int16_t speed, load;    // -1023..1023 in units of the registers; positive is CCW
};

/* Panes below the one of the positions. */
struct plot_panes {
    bool speed, load;
};

struct plot_lane {
    enum plot_sender sender;
    unsigned bus;
    unsigned id;        // of a servo
    unsigned duplicate; // number of servos with that ID before it
    bool sending;
    uint64_t since; // cycle at which it began to send
    struct plot_packet *packet;
    unsigned packets, capacity;
    uint64_t busy[PLOT_BINS];                // cycles of sending
    bool mark[PLOT_MARKS][PLOT_BINS];        // a mark is in the bin
    struct plot_sample sample[PLOT_SAMPLES]; // of a servo; goal PLOT_ABSENT: there was no servo
};

struct plot {
    const char *path; // 0: every call does nothing
    const char *title;
    char script[DATA_PATH_SIZE]; // gnuplot's
    struct plot_panes panes;
    struct schedule *schedule;
    uint32_t clock_Hz;
    unsigned buses;
    const char *controller; // name of what drives the bus
    struct plot_lane **lane;
    unsigned lanes;
    unsigned packets; // of all lanes; PLOT_PACKETS_MAX: no longer kept
    uint64_t bin;     // width in cycles
    struct event sample_event;
    uint64_t period; // of the samples, in cycles
    unsigned samples;
    const struct servos *set[PLOT_SETS_MAX];
};

/* `controller` is the name of what drives the bus. Returns false, with one line on stderr, if there
 * is no gnuplot or the file cannot be written. */
bool plot_open(struct plot *plot, const char *path, const char *title, const char *controller,
               struct plot_panes panes, struct schedule *schedule, uint32_t clock_Hz);

/* Adds a bus and its servos. Buses count from 0. */
void plot_bus(struct plot *plot, unsigned bus, const struct servos *servos);

/* The controller or a servo begins or ends to send. Adjacent bytes of the controller are one
 * packet. */
void plot_controller(struct plot *plot, unsigned bus, uint64_t now, bool sends);
void plot_servo(struct plot *plot, unsigned bus, uint64_t now, const struct servo_node *node);

void plot_mark(struct plot *plot, unsigned bus, enum plot_mark mark, uint64_t now);

/* Draws the picture. Returns false, with one line on stderr. Call plot_free() in any case. */
bool plot_draw(struct plot *plot, uint64_t end);
void plot_free(struct plot *plot);

#endif
