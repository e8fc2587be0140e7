/* SPDX-License-Identifier: MIT */
/* A net: one copper wire with a pull-up and the drivers that are connected to it.
 *
 * The level of a net is the AND of the levels of its enabled drivers. Without an enabled driver it
 * is 1. A net calls its listeners at each change, in the order in which they joined. A chain of
 * nets (pin, buffer, bus, buffer, pin) is therefore up to date when the call that changed its first
 * net returns.
 *
 * A fault may override the level (script/faults.h). The state of the drivers stays as it is. */
#ifndef SIM_NET_H
#define SIM_NET_H

#include <stdbool.h>
#include <stdint.h>

struct net;

struct driver {
    struct net *net;
    bool enabled;
    bool level;
    bool exempt;           // a fault causes what it does: the rules of the wire ignore it
    uint32_t bit_time_256; // bit time of the sender behind it, in 1/256 cycle
};

struct listener {
    void *context;
    /* The level has changed to `level`. May be 0. */
    void (*on_level)(void *context, uint64_t time, bool level);
    /* A driver was enabled or disabled. Called before on_level. May be 0. */
    void (*on_driver)(void *context, uint64_t time, struct driver *driver);
    struct listener *next;
};

#define NET_OVERRIDE_RANK 1 // rank of override events: drivers change before them
#define NET_SAMPLE_RANK   2 // rank of sample events: a sample on an edge reads the new level

enum net_override { NET_AS_DRIVEN, NET_INVERTED, NET_HIGH, NET_LOW };

struct net {
    bool level;
    unsigned enabled; // number of enabled drivers
    unsigned exempt;  // number of enabled drivers that are exempt from the rules
    unsigned low;     // number of enabled drivers at level 0
    uint64_t time;    // of the latest change of level
    struct listener *listeners;
    void *context;
    /* Returns the override at `time`. Called at each change of a driver. May be 0: no override. */
    enum net_override (*get_override)(void *context, uint64_t time);
};

void net_init(struct net *net);
void net_listen(struct net *net, struct listener *listener);
/* Call it when the override may change at `time`, from an event of rank NET_OVERRIDE_RANK: a driver
 * that changes in the same cycle then makes no glitch. */
void net_update(struct net *net, uint64_t time);

/* A new driver is disabled and has level 1. */
void driver_init(struct driver *driver, struct net *net);
void driver_set(struct driver *driver, uint64_t time, bool enabled, bool level);
void driver_enable(struct driver *driver, uint64_t time, bool enabled);
void driver_level(struct driver *driver, uint64_t time, bool level);
void driver_exempt(struct driver *driver, bool exempt);

#endif
