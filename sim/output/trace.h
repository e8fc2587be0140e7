/* Pictures of a run: the signals of a bus as a VCD, the motion of its servos as a table. */
#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "output/plot.h"
#include "wire/schedule.h"
#include "servo/servos.h"
#include "output/vcd.h"
#include "avr/bus_circuit.h"

/* The signals of one bus. */
struct bus_trace {
    struct vcd *vcd;
    struct plot *plot; // told who talks; may be 0
    unsigned bus;
    const struct bus_circuit *circuit;
    unsigned sig, txd, rxd, tx_enable, rx_enable, controller;
    struct listener on_sig, on_txd, on_rxd;
    struct servo_signals {
        bool declared;
        unsigned talks, torque, led;
    } servo[IDS_MAX];
    const struct servos *servos;
    uint64_t period; // of torque and LED, cycles
    struct event look;
};

void bus_trace_init(struct bus_trace *trace, struct vcd *vcd, unsigned bus,
                    struct bus_circuit *circuit);
/* Without an AVR there is the signal wire and who talks. */
void bus_trace_sig(struct bus_trace *trace, struct vcd *vcd, unsigned bus, struct net *sig);
void bus_trace_controller(struct bus_trace *trace, uint64_t now, bool talks);
/* An enable or the controller's transmitter has changed. */
void bus_trace_circuit(struct bus_trace *trace, uint64_t now);
void bus_trace_servo(struct bus_trace *trace, uint64_t now, const struct servo_node *node);

/* Torque and LED of the servos go into the VCD too, every 4 ms; and all of it into the plot, if
 * there is one. */
void bus_trace_servos(struct bus_trace *trace, struct plot *plot, const struct servos *servos);
/* The servos are others now. */
void bus_trace_new_servos(struct bus_trace *trace, uint64_t now);

/* `time_ms,goal_1,present_1,...`, a line every 4 ms, positions as the registers have them
 * (0..1023); `bus1_goal_1` where there are several buses. New servos begin a new block with a head
 * of its own, two empty lines behind the previous one: what gnuplot calls an index. */
struct motion {
    const char *path;
    FILE *file; // 0: none
    struct schedule *schedule;
    const struct servos *bus[BOARD_BUSES_MAX];
    unsigned buses;
    uint32_t clock_Hz;
    struct event sample;
    unsigned blocks;
};

bool motion_open(struct motion *motion, const char *path, struct schedule *schedule,
                 const struct servos *servos, uint32_t clock_Hz);
/* The servos of one more bus. */
void motion_bus(struct motion *motion, const struct servos *servos);
bool motion_close(struct motion *motion);
/* The servos are others now. */
void motion_new_servos(struct motion *motion, uint64_t now);

#endif
