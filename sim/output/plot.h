/* A picture of a run, drawn by gnuplot when it is over: above who talks when and what went wrong,
 * below the goal and present position of the servos, on one time axis.
 *
 * Its memory does not grow with the run: time is kept in bins whose width doubles whenever they are
 * used up. Packets are kept one by one only while they are few.
 */
#ifndef SIM_PLOT_H
#define SIM_PLOT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/schedule.h"
#include "servo/servos.h"

#define PLOT_BINS        1024 // over the whole run; half of them used at least
#define PLOT_SAMPLES     2048 // likewise, of the positions
#define PLOT_PACKETS_MAX 4000
#define PLOT_SETS_MAX    3 // of servos: buses

enum plot_mark { PLOT_FAULT, PLOT_COLLISION, PLOT_BREACH, PLOT_DAMAGED, PLOT_MARKS };
enum plot_sender { PLOT_WIRE, PLOT_CONTROLLER, PLOT_SERVO };

struct plot_packet {
    uint64_t from, until;
};

struct plot_position {
    uint16_t goal, present; // 0..1023
};

struct plot_lane {
    enum plot_sender sender;
    unsigned bus;
    unsigned id;        // of a servo
    unsigned duplicate; // how many servos of that ID come before it
    bool sending;
    uint64_t since; // it talks
    struct plot_packet *packet;
    unsigned packets, capacity;
    uint64_t busy[PLOT_BINS];                    // cycles of talking
    bool mark[PLOT_MARKS][PLOT_BINS];            // seen in the bin
    struct plot_position position[PLOT_SAMPLES]; // of a servo; PLOT_ABSENT: there was none
};

struct plot {
    const char *path; // 0: there is no plot, and every call does nothing
    const char *title;
    const char *script; // of gnuplot
    struct schedule *schedule;
    uint32_t clock_Hz;
    unsigned buses;
    const char *controller; // what it is called
    struct plot_lane **lane;
    unsigned lanes;
    unsigned packets; // of all lanes; PLOT_PACKETS_MAX: too many, and no longer kept
    uint64_t bin;     // cycles
    struct event sample_event;
    uint64_t period; // of the positions, cycles
    unsigned samples;
    const struct servos *set[PLOT_SETS_MAX];
};

/* False, with one line on stderr: there is no gnuplot, or the file cannot be written. `controller`:
 * what drives the bus. */
bool plot_open(struct plot *plot, const char *path, const char *title, const char *controller,
               struct schedule *schedule, uint32_t clock_Hz);

/* One more bus, and the servos on it. Buses count from 0. */
void plot_bus(struct plot *plot, unsigned bus, const struct servos *servos);

/* A lane for every servo that is there, in their order. */
void plot_servos(struct plot *plot, unsigned bus);

/* It begins or ends to talk. Bytes of the controller one behind the other make one packet. */
void plot_controller(struct plot *plot, unsigned bus, uint64_t now, bool sends);
void plot_servo(struct plot *plot, unsigned bus, uint64_t now, const struct servo_node *node);

void plot_mark(struct plot *plot, unsigned bus, enum plot_mark mark, uint64_t now);

/* Draws it. False, with one line on stderr, when that failed. plot_free() is due all the same. */
bool plot_draw(struct plot *plot, uint64_t end);
void plot_free(struct plot *plot);

#endif
