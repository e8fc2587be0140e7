/* Servos on a bus without a controller of ours: what drives it is a program behind a pty, as
 * through a USB2Dynamixel, or a scenario.
 */
#ifndef SIM_TESTBENCH_BUS_H
#define SIM_TESTBENCH_BUS_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host/adapter.h"
#include "testbench.h"
#include "script/faults.h"
#include "output/live_view.h"
#include "wire/net.h"
#include "host/realtime.h"
#include "output/plot.h"
#include "host/pty.h"
#include "wire/rules.h"
#include "wire/schedule.h"
#include "script/script.h"
#include "servo/servos.h"
#include "servo/servo_eeprom.h"
#include "output/trace.h"
#include "output/transcript.h"
#include "output/vcd.h"

#define BUS_CLOCK_HZ 16000000 // the unit of time, as with a controller: nothing else runs at it
#define BUS_BAUD     1000000  // of the adapter, until a client or a scenario sets it

struct bus {
    const struct bench_options *options;
    struct schedule schedule;
    struct net sig;
    struct adapter adapter;
    struct servos servos;
    struct faults faults;
    struct servo_eeprom state;
    struct rules rules;
    struct script script;
    struct script_ops ops;
    struct pty pty;
    struct realtime realtime; // with a pty
    struct transcript transcript;
    struct vcd vcd;
    struct bus_trace trace;
    struct motion motion;
    struct plot plot;
    struct live_view live_view;
    struct event limit;
    volatile sig_atomic_t stop; // may be set by a signal handler
};

/* False, with one line on stderr. bus_free() is due all the same. */
bool bus_init(struct bus *bus, const struct bench_options *options);

/* False when the scenario failed. */
bool bus_run(struct bus *bus);
void bus_report(const struct bus *bus, FILE *out);

/* False when a file could not be written. */
bool bus_free(struct bus *bus);

#endif
