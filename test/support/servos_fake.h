/* SPDX-License-Identifier: MIT */
/* A few servos behind port_fake. They answer sent packets at their own baud rate. A test chooses
 * the packet at which a fault happens. They know only what set-up needs: PING, READ, WRITE, RESET.
 * They share no code with the library. */
#ifndef SERVOS_FAKE_H
#define SERVOS_FAKE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "cds55xx/bus.h"
#include "port_fake.h"

enum servos_fault {
    FAULT_NONE,
    LOSE_PACKET, // no servo hears it
    LOSE_REPLY,
    SPOIL_REPLY,
    CUT_BEFORE, // power is cut before the packet is carried out
    CUT_AFTER,  // power is cut after the packet is carried out, before the reply
    FAULTS,
};

#define SERVOS_FAKE    3
#define SERVOS_FOREVER 0xFF

struct servo_fake {
    bool there;
    uint8_t table[0x32]; // by address
    uint8_t kept_baud;   // the last listed one, back after power-up (R24)
    uint8_t error;       // bits of every reply
    uint8_t neighbours;  // it also hears at rates so near to its own; the reply is damaged there
};

/* A fault at packet `at`, counted from 1. */
struct servos_plan {
    uint8_t at;
    uint8_t fault;  // enum servos_fault
    uint8_t absent; // power cut: number of further packets without power, or SERVOS_FOREVER
};

static struct {
    struct servo_fake servo[SERVOS_FAKE];
    struct servos_plan plan[2];
    uint16_t packets; // received so far
    uint16_t writes;  // received WRITEs and RESETs
    uint8_t dark;     // number of packets for which servo 0 still has no power
} servos;

static inline void servo_fake_put(uint8_t index, uint8_t id, uint8_t baud)
{
    struct servo_fake *servo = &servos.servo[index];

    memset(servo, 0, sizeof *servo);
    servo->there = true;
    servo->table[0x01] = (uint8_t)(index + 1);
    servo->table[0x03] = id;
    servo->table[0x04] = servo->kept_baud = baud;
    servo->table[0x10] = 2;
}

static void servo_fake_power_up(struct servo_fake *servo)
{
    servo->table[0x04] = servo->kept_baud;
    servo->table[0x2F] = 0;
}

static bool servo_fake_is_listed(uint8_t baud)
{
    return baud == 1 || baud == 3 || baud == 7 || baud == 16 || baud == 34 || baud == 103;
}

/* Carries out the packet. Returns its ERROR; `out` gets the data of a READ. */
static uint8_t servo_fake_obey(struct servo_fake *servo, const uint8_t *packet, const uint8_t **out,
                               uint8_t *count)
{
    uint8_t first = packet[5];

    if (packet[4] == 2) {
        *out = &servo->table[first];
        *count = packet[6];
    }
    if (packet[4] == 3 && servo->table[0x2F])
        return 0x08;
    if (packet[4] == 3)
        memcpy(&servo->table[first], &packet[6], (uint8_t)(packet[3] - 3));
    if (packet[4] == 6) {
        servo->table[0x03] = servo->table[0x04] = 1;
        servo->table[0x10] = 2;
    }
    if (servo_fake_is_listed(servo->table[0x04]))
        servo->kept_baud = servo->table[0x04];
    return servo->error;
}

static uint8_t servos_fault_now(void)
{
    for (uint8_t i = 0; i < 2; i++) {
        if (servos.plan[i].fault && servos.plan[i].at == servos.packets) {
            if (servos.plan[i].fault >= CUT_BEFORE)
                servos.dark = servos.plan[i].absent;
            return servos.plan[i].fault;
        }
    }
    return FAULT_NONE;
}

/* How far the rate of the bus is from that of the servo. */
static uint8_t servo_fake_distance(const struct servo_fake *servo)
{
    int16_t distance = (int16_t)(servo->table[0x04] - port_fake.bauds[0]);

    return (uint8_t)(distance < 0 ? -distance : distance);
}

/* The servos receive the packet on the line and answer. */
static void servos_hear(struct cds_bus *bus)
{
    const uint8_t *packet = port_fake.sent, *data = NULL;
    uint8_t answers = 0, count = 0, level, fault;
    uint8_t sender = 0, error = 0;

    bool dark = servos.dark != 0;

    servos.packets++;
    servos.writes = (uint16_t)(servos.writes + (packet[4] == 3 || packet[4] == 6));
    fault = servos_fault_now();
    for (uint8_t i = 0; i < SERVOS_FAKE; i++) {
        struct servo_fake *servo = &servos.servo[i];
        uint8_t id = servo->table[0x03];

        if (!servo->there || servo_fake_distance(servo) > servo->neighbours ||
            fault == LOSE_PACKET || (packet[2] != id && packet[2] != 0xFE) ||
            (i == 0 && (dark || fault == CUT_BEFORE)))
            continue;
        if (servo_fake_distance(servo))
            fault = SPOIL_REPLY;
        level = servo->table[0x10];
        sender = id;
        error = servo_fake_obey(servo, packet, &data, &count);
        if (packet[4] == 1 || (packet[2] != 0xFE && level > (packet[4] != 2)))
            answers = (uint8_t)(answers + !(i == 0 && fault == CUT_AFTER));
    }
    if (fault >= CUT_BEFORE)
        servo_fake_power_up(&servos.servo[0]);
    if (dark && servos.dark != SERVOS_FOREVER)
        servos.dark--;
    if (!answers || fault == LOSE_REPLY)
        return;
    port_fake.now_us += (uint32_t)(6 + count) * (port_fake.bauds[0] + 1u) * 5;
    if (answers > 1 || fault == SPOIL_REPLY) {
        port_fake_hear(&bus->link, (const uint8_t *)"\xFF\xFF\x01\x02\x00\x00", 6);
        return;
    }
    port_fake_answer(&bus->link, sender, error, data, count);
}

/* One turn of the main loop but for polling: what is being sent leaves and is heard, or 20 us pass;
 * 200 us if a request waits for the end of a rest. */
static inline void servos_turn(struct cds_bus *bus)
{
    bool rests = cds_bus_is_resting(bus) && bus->state == CDS_BUS_WAITING_FOR_LINE;

    port_fake.now_us += rests ? 200 : 20;
    if (bus->link.state != CDS_LINK_TALKING || !port_fake_transmit(&bus->link, 0))
        return;
    port_fake.now_us += (uint32_t)port_fake.sent_size * (port_fake.bauds[0] + 1u) * 5;
    servos_hear(bus);
    port_fake_forget();
}

#endif
