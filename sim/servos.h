/* Any number of simulated servos on one net: what each hears, when each answers, and their ticks.
 */
#ifndef SIM_SERVOS_H
#define SIM_SERVOS_H

#include <stdbool.h>
#include <stdint.h>

#include "ids.h"
#include "net.h"
#include "schedule.h"
#include "servo.h"
#include "uart.h"

struct servos;

/* A servo and its place on the wire. */
struct servo_node {
    struct servos *servos;
    struct servo servo;
    uint8_t id;           // when it was put there, for pictures
    uint8_t baud;         // register value that its receiver uses
    struct driver driver; // on while it talks
    struct talker talker;
    struct event answer; // the return delay is over
    struct event tick;
    uint16_t said; // bytes of the reply
};

/* What is heard at one bit rate; shared by all servos at that rate. */
struct servo_ear {
    struct servos *servos;
    struct ear ear;
    uint8_t baud;
    unsigned users;
};

struct servos {
    struct schedule *schedule;
    struct net *net;
    uint32_t clock_Hz;
    struct servo_node *node;
    unsigned count;
    bool power;
    struct servo_ear *ears[256]; // by baud register; made when first needed
    void *owner;
    void (*on_byte)(void *owner, uint64_t now, uint64_t end); // a servo's byte begins; may be 0
    void (*on_talk)(void *owner, uint64_t now, const struct servo_node *node); // or ends; may be 0
};

void servos_init(struct servos *servos, struct schedule *schedule, struct net *net,
                 uint32_t clock_Hz);
void servos_free(struct servos *servos);

/* Fresh servos in place of those there were: factory values, these IDs, powered. */
void servos_replace(struct servos *servos, uint64_t now, const uint8_t *ids, unsigned count);
void servos_power(struct servos *servos, uint64_t now, bool on);

#endif
