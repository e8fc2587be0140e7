/* SPDX-License-Identifier: MIT */
/* Bridge, virtual device and demux over one bus on a port that records. A suite says packets as the
 * host, answers as a servo, and compares what the host has heard:
 *
 *     SAY(9, CDS_PING);
 *     assert_sent(9, CDS_PING, NULL, 0);
 *     answer(9, 0, NULL, 0);
 *     assert_heard(9, 0, NULL, 0);
 */
#ifndef BRIDGE_RIG_H
#define BRIDGE_RIG_H

#include <string.h>

#include "host/bridge.h"
#include "cds55xx/control_table.h"
#include "eeprom_fake.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"
#include "host/device_registers.h"

#define DEVICE_IS 253

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
static uint8_t buffers[2][STATUS_PACKET_HEAD + HOST_PACKET_MAX];
static uint16_t gaps;
static bool is_exclusive; // an operation has the bus to itself

/* Bytes that the host has received. */
static uint8_t heard[300];
static uint16_t heard_size;

static inline void attach(const struct cds_bus_hooks *hooks)
{
    bus.hooks = NULL;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, hooks));
}

/* setUp() */
static inline void open_all(void)
{
    port_fake_reset();
    memset(&input, 0, sizeof input);
    memset(&text, 0, sizeof text);
    memset(&output, 0, sizeof output);
    memset(&device, 0, sizeof device);
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    host_demux_open(&host, &input, &text, buffers[0] + STATUS_PACKET_HEAD);
    eeprom_fake_reset();
    memset(&store, 0, sizeof store);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    attach(&robot.queue.hooks); // no permit: the replies here contradict each other
    settings_default(&settings);
    failsafe = (struct failsafe){.settings = &settings, .store = &store, .robot = &robot};
    device_registers_open(&registers, &failsafe, &host, &bridge, &gaps);
    device.ops = &device_registers_ops;
    device.context = &registers;
    bridge_open(&bridge, &bus, &host, &device, &output, buffers[1] + STATUS_PACKET_HEAD);
    heard_size = 0;
    is_exclusive = false;
}

static inline void turn(void)
{
    port_fake.now_us += 2;
    cds_bus_poll(&bus);
    host_demux_poll(&host);
    if (!is_exclusive || bridge_goes_on(&bridge))
        bridge_poll(&bridge);
    for (; cds_ring_count(&output); ring_drop(&output, 1))
        if (heard_size < sizeof heard)
            heard[heard_size++] = ring_peek(&output, 0);
}

static inline void turns(uint16_t count)
{
    while (count--)
        turn();
}

/* The host sends a packet. */
static inline void say(uint8_t id, uint8_t instruction, const uint8_t *parameters, uint8_t count)
{
    uint8_t head[5] = {0xFF, 0xFF, id, (uint8_t)(count + 2), instruction};
    uint8_t sum = (uint8_t)(id + head[3] + instruction);

    heard_size = 0;
    for (uint16_t i = 0; i < count + 6u; i++) {
        uint8_t byte = i < 5 ? head[i] : i < count + 5u ? parameters[i - 5] : (uint8_t)~sum;

        if (i >= 5)
            sum = (uint8_t)(sum + byte);
        while (!cds_ring_put(&input, byte))
            turn();
    }
    turns(60);
}

#define SAY(id, instruction, ...)                                                                  \
    do {                                                                                           \
        const uint8_t parameters_[] = {__VA_ARGS__};                                               \
        say(id, instruction, parameters_, sizeof parameters_);                                     \
    } while (0)

/* True if the bus sends a packet; the packet has then left. */
static inline bool sent(void)
{
    for (uint16_t i = 0; i < 1200 && bus.link.state != CDS_LINK_TALKING; i++)
        turn();
    return port_fake_transmit(&bus.link, 0);
}

static inline void assert_sent(uint8_t id, uint8_t instruction, const uint8_t *parameters,
                               uint8_t count)
{
    TEST_ASSERT_TRUE(sent());
    TEST_ASSERT_EQUAL_UINT16(count + 6u, port_fake.sent_size);
    TEST_ASSERT_EQUAL_UINT8(id, port_fake.sent[2]);
    TEST_ASSERT_EQUAL_UINT8(count + 2, port_fake.sent[3]);
    TEST_ASSERT_EQUAL_UINT8(instruction, port_fake.sent[4]);
    if (count)
        TEST_ASSERT_EQUAL_UINT8_ARRAY(parameters, &port_fake.sent[5], count);
}

static inline void answer(uint8_t id, uint8_t error, const uint8_t *parameters, uint8_t count)
{
    port_fake_answer(&bus.link, id, error, parameters, count);
    turns(20);
}

/* The host has received this status packet and no other byte. */
static inline void assert_heard(uint8_t id, uint8_t error, const uint8_t *parameters, uint8_t count)
{
    uint8_t sum = (uint8_t)(id + count + 2 + error);

    for (uint8_t i = 0; i < count; i++)
        sum = (uint8_t)(sum + parameters[i]);
    TEST_ASSERT_EQUAL_UINT16(count + 6u, heard_size);
    TEST_ASSERT_EQUAL_HEX8(0xFF, heard[0]);
    TEST_ASSERT_EQUAL_HEX8(0xFF, heard[1]);
    TEST_ASSERT_EQUAL_UINT8(id, heard[2]);
    TEST_ASSERT_EQUAL_UINT8(count + 2, heard[3]);
    TEST_ASSERT_EQUAL_HEX8(error, heard[4]);
    if (count)
        TEST_ASSERT_EQUAL_HEX8_ARRAY(parameters, &heard[5], count);
    TEST_ASSERT_EQUAL_HEX8((uint8_t)~sum, heard[5 + count]);
    heard_size = 0;
}

static inline void wait_for_deadline(void)
{
    turns(1500); // 3 ms
    TEST_ASSERT_TRUE(bridge_idle(&bridge));
}

static uint8_t data[255];

static inline void fill(uint8_t count, uint8_t from)
{
    for (uint8_t i = 0; i < count; i++)
        data[i] = (uint8_t)(from + i);
}

static const struct cds_bus_lock lock;

/* An operation begins: it has the bus to itself. */
static inline void begin_operation(void)
{
    is_exclusive = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_lock(&bus, &lock));
}

static inline void end_operation(void)
{
    is_exclusive = false;
    cds_bus_unlock(&bus, &lock);
}

#endif
