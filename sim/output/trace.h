/* SPDX-License-Identifier: MIT */
/* Signals of a run for pictures: each bus as a VCD and in the plot, the motion of the servos as a
 * table. */
#ifndef SIM_TRACE_H
#define SIM_TRACE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "avr/bus_circuit.h"
#include "board.h"
#include "output/plot.h"
#include "output/vcd.h"
#include "servo/servos.h"
#include "wire/schedule.h"

/* The signals of one bus. */
struct bus_trace {
    struct vcd *vcd;
    struct plot *plot; // gets the senders too; may be 0
    unsigned bus;
    const struct bus_circuit *circuit;
    unsigned sig, txd, rxd, tx_enable, rx_enable, controller;
    struct listener on_sig, on_txd, on_rxd;
    struct servo_signals {
        bool declared;
        unsigned sending, torque, led;
    } servo[IDS_MAX];
    const struct servos *servos;
    uint64_t period; // of torque and LED, in cycles
    struct event look;
};

void bus_trace_init(struct bus_trace *trace, struct vcd *vcd, unsigned bus,
                    struct bus_circuit *circuit);
/* Declares the signals of a bus without an AVR: the wire and the senders. */
void bus_trace_sig(struct bus_trace *trace, struct vcd *vcd, unsigned bus, struct net *sig);
void bus_trace_controller(struct bus_trace *trace, uint64_t now, bool sending);
/* An enable or the controller's transmitter has changed. */
void bus_trace_circuit(struct bus_trace *trace, uint64_t now);
void bus_trace_servo(struct bus_trace *trace, uint64_t now, const struct servo_node *node);

/* Records torque and LED of the servos in the VCD every 4 ms, and all signals in the plot, if there
 * is one. */
void bus_trace_servos(struct bus_trace *trace, struct plot *plot, const struct servos *servos);
/* Call it after the servos were replaced. */
void bus_trace_new_servos(struct bus_trace *trace, uint64_t now);

/* A table `time_ms,goal_1,present_1,...` with a line every 4 ms. Positions are in units of the
 * registers (0..1023). With several buses the names are `bus1_goal_1`. New servos begin a new block
 * with its own head, two empty lines after the block before: gnuplot calls it an index. */
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
/* Adds the servos of a further bus. */
void motion_bus(struct motion *motion, const struct servos *servos);
bool motion_close(struct motion *motion);
/* Call it after the servos were replaced. */
void motion_new_servos(struct motion *motion, uint64_t now);

#endif
