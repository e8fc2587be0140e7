/* SPDX-License-Identifier: MIT */
/* The controller on this machine: demultiplexer, bridge, device and console as main.c joins them,
 * on a port that records, over servos that answer whatever they are asked. A test program says
 * bytes to it as the host, and looks at what it sends to servos and host. */
#ifndef CONTROLLER_RIG_H
#define CONTROLLER_RIG_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "host/bridge.h"
#include "console/console.h"
#include "ring_input.h"
#include "port_fake.h"
#include "host/device_registers.h"

#define ROOM 2048

static struct cds_bus bus;
static struct cds_ring input, text, output;
static struct host_demux host;
static struct bridge bridge;
static struct device device;
static struct device_registers registers;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static struct failsafe failsafe;
static struct console console;
static uint8_t packets[2][STATUS_PACKET_HEAD + HOST_PACKET_MAX];
static uint16_t lost;
static bool broken; // a byte was lost: hear() drops bytes until the ring is empty

static uint32_t seed = 1;
static uint8_t said[ROOM]; // to the host, the latest
static size_t said_size;
static void (*on_packet)(const uint8_t *bytes, size_t size); // that the controller sent to servos

static uint32_t any(uint32_t count)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)(seed >> 8) * count >> 24);
}

static void open_all(void)
{
    port_fake_reset();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    host_demux_open(&host, &input, &text, packets[0] + STATUS_PACKET_HEAD);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    settings_default(&settings);
    settings.echo = SETTINGS_ECHO_OFF; // mode program: the tests compare bare replies
    failsafe = (struct failsafe){.settings = &settings,
                                 .store = &store,
                                 .robot = &robot,
                                 .damaged_stops = &host.counters.stops};
    device_registers_open(&registers, &failsafe, &host, &bridge, &lost);
    device.ops = command_set.device;
    device.context = &registers;
    bridge_open(&bridge, &bus, &host, &device, &output, packets[1] + STATUS_PACKET_HEAD);
    console_open(&console, &failsafe, &text, &output);
    robot.moves = command_set.moves;
    command_set.store->load(command_set.store->motions, &store);
    command_set.store->begin(&failsafe, command_set.store->motions);
}

/* Each servo whose ID is no multiple of 3 answers the packet. A READ with a wrong number of
 * parameters gets a reply without data. */
static void answer(void)
{
    static const uint8_t table[UINT8_MAX + CDS_REPLY_MAX] = {[0x10] = 2}; // all is answered
    const uint8_t *sent = port_fake.sent, *data = table + sent[5];
    bool reads = sent[3] == CDS_LENGTH_MIN + 2 && sent[4] == CDS_READ;
    uint8_t count = reads && sent[6] <= CDS_REPLY_MAX ? sent[6] : 0;

    if (sent[2] < CDS_BROADCAST_ID && sent[2] % 3)
        port_fake_answer(&bus.link, sent[2], 0, data, count);
}

static void turn(void)
{
    static uint8_t heard;

    port_fake.now_us += 20;
    if (heard != input.head)
        failsafe_heard(&failsafe);
    heard = input.head;
    failsafe_poll(&failsafe);
    failsafe.counts_stack = false; // as main does when it has counted
    if (bus.link.state == CDS_LINK_TALKING && port_fake_transmit(&bus.link, 0)) {
        if (on_packet)
            on_packet(port_fake.sent, port_fake.sent_size);
        answer();
    }
    cds_bus_poll(&bus);
    host_demux_poll(&host);
    if (broken && cds_ring_count(&input) == 0) {
        broken = false;
        host_demux_gap(&host);
    }
    if (host.stop)
        console_stop(&console);
    host.stop = false;
    robot_poll(&robot);
    if (!robot_is_exclusive(&robot) || bridge_goes_on(&bridge))
        bridge_poll(&bridge);
    if (robot_is_exclusive(&robot) && host.has_packet)
        robot_abort(&robot);
    if (!bridge_talks(&bridge))
        console_poll(&console);
    for (; cds_ring_count(&output); ring_drop(&output, 1)) {
        if (said_size == ROOM) {
            memmove(said, said + ROOM / 2, ROOM / 2);
            said_size = ROOM / 2;
        }
        said[said_size++] = ring_peek(&output, 0);
    }
}

/* Builds an instruction packet; returns its size. */
static size_t build(uint8_t *to, uint8_t id, uint8_t instruction, const uint8_t *parameters,
                    size_t count)
{
    uint8_t sum = (uint8_t)(id + instruction + count + 2);

    to[0] = to[1] = 0xFF;
    to[2] = id;
    to[3] = (uint8_t)(count + 2);
    to[4] = instruction;
    for (size_t i = 0; i < count; i++) {
        to[5 + i] = parameters[i];
        sum = (uint8_t)(sum + parameters[i]);
    }
    to[5 + count] = (uint8_t)~sum;
    return count + 6;
}

/* As the receive handler and main.c do it. */
static void hear(uint8_t byte)
{
    if (broken || !cds_ring_put(&input, byte)) {
        broken = true;
        lost++;
    }
}

static void say(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        while (cds_ring_count(&input) > 40)
            turn();
        hear(bytes[i]);
    }
}

static void wait_us(uint32_t us)
{
    uint32_t start = port_fake.now_us;

    while (port_fake.now_us - start < us)
        turn();
}

#endif
