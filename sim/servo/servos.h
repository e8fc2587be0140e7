/* Any number of simulated servos on one net: what each hears, when each answers, and their ticks.
 */
#ifndef SIM_SERVOS_H
#define SIM_SERVOS_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/ids.h"
#include "wire/net.h"
#include "wire/schedule.h"
#include "servo/servo.h"
#include "wire/uart.h"

#define SERVOS_NEVER UINT16_MAX

struct servos;

/* A servo and its place on the wire. */
struct servo_node {
    struct servos *servos;
    struct servo servo;
    uint8_t id;           // when it was put there, for pictures
    uint8_t baud;         // register value that its receiver uses
    struct driver driver; // on while it talks
    struct uart_tx tx;
    struct event reply_delay; // the return delay is over
    struct event tick;
    struct event power_return; // a brown-out is over
    uint16_t bytes_sent;       // bytes of the reply
    uint16_t power_loss_after; // that many bytes of it, or SERVOS_NEVER
    uint64_t off_cycles;       // cycles without power that follow; 0: it is there again at once
    uint32_t reply;            // number of the reply; on_due's to count
    uint32_t extra_delay_us;   // that every reply comes later than the return delay says
    bool has_wrong_baud;       // by a fault: its rate is not what anybody set
    bool
        has_partial_packet; // held part of an earlier packet when the controller's latest one began
};

/* What is heard at one bit rate; shared by all servos at that rate. */
struct servo_receiver {
    struct servos *servos;
    struct uart_rx rx;
    uint8_t baud;
    unsigned users;
    uint64_t end; // of the stop bit of the latest byte
};

struct servos {
    struct schedule *schedule;
    struct net *net;
    uint32_t clock_Hz;
    struct servo_node *node;
    unsigned count;
    struct servo_receiver *receivers[256]; // by baud register; made when first needed
    uint32_t seed;                         // of the jitter, besides the ID
    bool duplicates;                       // several may have one ID: their collisions are excused
    void *context;
    void (*on_byte)(void *context, uint64_t now, const struct servo_node *node); // begins; may be 0
    void (*on_drive)(void *context, uint64_t now,
                     const struct servo_node *node); // or ends; may be 0
    void *fault_context;
    void (*fault_on_reply)(void *fault_context,
                           struct servo_node *node); // a reply may still be changed; may be 0
    void (*fault_on_byte)(void *fault_context, uint64_t now,
                          const struct servo_node *node); // begins; may be 0
};

void servos_init(struct servos *servos, struct schedule *schedule, struct net *net,
                 uint32_t clock_Hz);
void servos_free(struct servos *servos);

/* Fresh servos in place of those there were: factory values, these IDs, powered. */
void servos_replace(struct servos *servos, uint64_t now, const uint8_t *ids, unsigned count);
/* Of one servo, or of all. */
void servo_node_power(struct servo_node *node, uint64_t now, bool on);
void servos_power(struct servos *servos, uint64_t now, bool on);
/* Without power for so long; nothing happens to one that has none. */
void servo_node_brown_out(struct servo_node *node, uint64_t now, uint64_t cycles);
/* It is at another rate, until it is told or powered up anew. */
void servo_node_baud(struct servo_node *node, uint8_t baud);

/* What one of them keeps without power, as servo_eeprom_set() has it. */
bool servos_set_eeprom(struct servos *servos, unsigned index,
                       const uint8_t bytes[SERVO_EEPROM_SIZE]);

#endif
