/* SPDX-License-Identifier: MIT */
/* Any number of simulated servos on one net: their receivers, their replies and their ticks. */
#ifndef SIM_SERVOS_H
#define SIM_SERVOS_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/ids.h"
#include "servo/servo.h"
#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define SERVOS_NEVER UINT16_MAX

struct servos;

/* A servo and its connection to the wire. */
struct servo_node {
    struct servos *servos;
    struct servo servo;
    uint8_t id;           // under which it was put there; for outputs
    uint8_t baud;         // value of the baud register that its receiver uses
    struct driver driver; // enabled while the servo sends
    struct uart_tx tx;
    struct event reply_delay; // the return delay ends
    struct event tick;
    struct event power_return; // a brown-out ends
    uint16_t bytes_sent;       // of the reply
    uint16_t power_loss_after; // number of bytes after which power is cut, or SERVOS_NEVER
    uint64_t off_cycles;       // duration of that power loss; 0: power returns at once
    uint32_t reply;            // number of the reply; fault_on_reply counts
    uint32_t extra_delay_us;   // added to the return delay of every reply
    bool has_wrong_baud;       // a fault has changed its bit rate
    bool has_partial_packet;   // had part of an earlier packet when the controller's latest packet
                               // began
};

/* The receiver of one bit rate. All servos with that bit rate share it. */
struct servo_receiver {
    struct servos *servos;
    struct uart_rx rx;
    uint8_t baud;
    unsigned users;
    uint64_t end; // end of the latest stop bit
};

struct servos {
    struct schedule *schedule;
    struct net *net;
    uint32_t clock_Hz;
    struct servo_node *node;
    unsigned count;
    struct servo_receiver *receivers[256]; // index: baud register; created on first use
    uint32_t seed;                         // of the jitter, together with the ID
    bool duplicates; // servos may share an ID: their collisions are exempt from the rules
    void *context;
    void (*on_byte)(void *context, uint64_t now,
                    const struct servo_node *node); // a byte of a reply begins; may be 0
    void (*on_drive)(void *context, uint64_t now,
                     const struct servo_node *node); // a servo begins or ends to send; may be 0
    void *fault_context;
    void (*fault_on_reply)(
        void *fault_context,
        struct servo_node *node); // a reply may be changed before it is sent; may be 0
    void (*fault_on_byte)(void *fault_context, uint64_t now,
                          const struct servo_node *node); // a byte of a reply begins; may be 0
};

void servos_init(struct servos *servos, struct schedule *schedule, struct net *net,
                 uint32_t clock_Hz);
void servos_free(struct servos *servos);

/* Replaces all servos by new, powered ones with these IDs and factory values. */
void servos_replace(struct servos *servos, uint64_t now, const uint8_t *ids, unsigned count);
/* Powers one servo, or all servos, on or off. */
void servo_node_power(struct servo_node *node, uint64_t now, bool on);
void servos_power(struct servos *servos, uint64_t now, bool on);
/* Cuts the power for `cycles`. A servo without power ignores it. */
void servo_node_brown_out(struct servo_node *node, uint64_t now, uint64_t cycles);
/* Changes the bit rate until a packet sets another rate or the servo powers up again. */
void servo_node_baud(struct servo_node *node, uint8_t baud);

/* As servo_set_eeprom(). */
bool servos_set_eeprom(struct servos *servos, unsigned index,
                       const uint8_t bytes[SERVO_EEPROM_SIZE]);

/* True if a servo has this ID now. */
bool servos_have(const struct servos *servos, uint8_t id);

#endif
