/* A net: one copper wire with a pull-up and the drivers that hang on it.
 *
 * Its level is the AND of what its drivers put on it; nobody driving reads as 1. Listeners are told
 * of every change, in the order in which they joined, so a net of nets (pin, buffer, bus, buffer,
 * pin) settles within the call that started the change.
 *
 * A fault may override what the drivers give (faults.h): the level is then another one, but who
 * drives, and what, is as it was.
 */
#ifndef SIM_NET_H
#define SIM_NET_H

#include <stdbool.h>
#include <stdint.h>

struct net;

struct driver {
    struct net *net;
    bool enabled;
    bool level;
    bool exempt;      // a fault is behind what it does: the rules of the wire look away
    uint32_t bit_256; // bit time of the one who talks through it, in 1/256 cycle: for onlookers
};

struct listener {
    void *context;
    /* The level has changed to `level`; may be 0. */
    void (*on_level)(void *context, uint64_t time, bool level);
    /* A driver was enabled or disabled; called before on_level; may be 0. */
    void (*on_driver)(void *context, uint64_t time, struct driver *driver);
    struct listener *next;
};

#define NET_OVERRIDE_RANK 1 // of events: drivers change before,
#define NET_SAMPLE_RANK   2 // and who samples on an edge sees what comes after it

enum net_override { NET_AS_DRIVEN, NET_INVERTED, NET_HIGH, NET_LOW };

struct net {
    bool level;
    unsigned enabled; // drivers that are enabled
    unsigned exempt;  // and how many of those are excused
    unsigned low;     // drivers that pull it low
    uint64_t time;    // of the latest change of level
    struct listener *listeners;
    void *context;
    /* What overrides the drivers at `time`, asked at each of their changes; may be 0. */
    enum net_override (*get_override)(void *context, uint64_t time);
};

void net_init(struct net *net);
void net_listen(struct net *net, struct listener *listener);
/* The override may be another one from `time` on. Its event has the rank NET_OVERRIDE_RANK: then a
 * driver that changes in the same cycle makes no glitch with it. */
void net_update(struct net *net, uint64_t time);

/* A driver begins disabled, at level 1. */
void driver_init(struct driver *driver, struct net *net);
void driver_set(struct driver *driver, uint64_t time, bool enabled, bool level);
void driver_enable(struct driver *driver, uint64_t time, bool enabled);
void driver_level(struct driver *driver, uint64_t time, bool level);
void driver_exempt(struct driver *driver, bool exempt);

#endif
