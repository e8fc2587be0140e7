/* SPDX-License-Identifier: MIT */
/* Servos behind port_fake that know only their torque: they answer PING and READ of TORQUE_ENABLE
 * and execute WRITE of it. The fake logs every packet. A byte takes 10 us; a reply begins after 2
 * us. They share no code with the library. */
#ifndef TORQUE_FAKE_H
#define TORQUE_FAKE_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "cds55xx/bus.h"
#include "port_fake.h"

#define TORQUE_SERVOS   3 // IDs 1 to 3
#define TORQUE_LOG_SIZE 64

static struct {
    struct {
        bool dead;     // no power, no answer
        bool deaf;     // hears no broadcast
        bool stubborn; // stays on, whatever it is told
        bool mute;     // status return level 0
        bool garbled;  // its replies come damaged
        uint8_t torque;
    } servo[TORQUE_SERVOS];
    struct {
        uint32_t us; // when it began
        uint8_t id, instruction, address, data;
    } log[TORQUE_LOG_SIZE];
    uint8_t count; // of `log`
    bool talking, answering;
    uint32_t end_us;
    uint8_t sender; // of the reply
} wire;

static inline void torque_hear(uint8_t index)
{
    const uint8_t *packet = port_fake.sent;
    bool mine = packet[2] == index + 1;

    if (wire.servo[index].dead || (!mine && (packet[2] != 0xFE || wire.servo[index].deaf)))
        return;
    if (packet[4] == 3 && packet[5] == 0x18 && !wire.servo[index].stubborn)
        wire.servo[index].torque = packet[6];
    wire.answering = wire.answering || (mine && (packet[4] == 1 || !wire.servo[index].mute));
}

/* Advances the clock by one microsecond. */
static inline void torque_wire(struct cds_bus *bus)
{
    const uint8_t *packet = port_fake.sent;

    port_fake.now_us++;
    if (!wire.talking && !wire.answering && bus->link.state == CDS_LINK_TALKING) {
        wire.talking = true;
        wire.end_us = port_fake.now_us + 10u * bus->request->packet.size;
        wire.log[wire.count].us = port_fake.now_us;
    }
    if (wire.talking && port_fake.now_us == wire.end_us) {
        wire.talking = false;
        port_fake_transmit(&bus->link, 0);
        wire.log[wire.count].id = packet[2];
        wire.log[wire.count].instruction = packet[4];
        wire.log[wire.count].address = packet[5];
        wire.log[wire.count].data = packet[6];
        if (wire.count < TORQUE_LOG_SIZE - 1)
            wire.count++;
        for (uint8_t i = 0; i < TORQUE_SERVOS; i++)
            torque_hear(i);
        wire.end_us = port_fake.now_us + 72 + (packet[4] == 2 ? 10 : 0);
        wire.sender = packet[2];
    }
    if (wire.answering && port_fake.now_us == wire.end_us) {
        wire.answering = false;
        if (wire.servo[wire.sender - 1].garbled)
            port_fake_hear(&bus->link, (const uint8_t *)"\xFF\xFF\x01\x02\x00\x00", 6);
        else
            port_fake_answer(&bus->link, wire.sender, 0, &wire.servo[wire.sender - 1].torque,
                             packet[4] == 2);
    }
}

/* Returns the number of logged packets from `first` on with this ID and instruction. */
static inline uint8_t torque_packets(uint8_t first, uint8_t id, uint8_t instruction)
{
    uint8_t count = 0;

    for (uint8_t i = first; i < wire.count; i++)
        if (wire.log[i].id == id && wire.log[i].instruction == instruction)
            count++;
    return count;
}

#endif
