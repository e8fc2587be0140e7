/* SPDX-License-Identifier: MIT */
/* What a suite of the core needs before each of its tests: `bus`, opened at 1 Mbps on a port that
 * records, and after each: no rule of port.h broken, every packet accounted for. Between them the
 * suite submits a request, and says what the line does with it:
 *
 *     cds_servo_ping(&bus, &request, 7);
 *     rig_answer(7, 0, NULL, 0);
 *     TEST_ASSERT_EQUAL(CDS_OK, request.result);
 */
#ifndef BUS_RIG_H
#define BUS_RIG_H

#include <string.h>

#include "cds55xx/queue.h"
#include "port_fake.h"
#include "unity.h"

static struct cds_bus bus;

/* For setUp(): resets the fake and the bus; the clock stands at `now_us`. */
static inline void rig_open_at_us(uint8_t port, uint32_t now_us)
{
    port_fake_reset();
    port_fake.now_us = now_us;
    memset(&bus, 0, sizeof bus);
    cds_bus_open(&bus, port, CDS_BAUD_1M);
    port_fake_forget();
}

static inline void rig_open(uint8_t port)
{
    rig_open_at_us(port, 0);
}

static inline void rig_open_with_queue(uint8_t port, struct cds_queue *queue)
{
    rig_open(port);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(queue, &bus));
}

static inline struct cds_stats rig_stats(void)
{
    struct cds_stats count;

    cds_bus_stats(&bus, &count);
    return count;
}

/* tearDown() */
static inline void rig_check(void)
{
    struct cds_stats count = rig_stats();

    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(count.sent - port_fake_is_in_flight(&bus)),
                             (uint16_t)(count.ok + count.timeouts + count.corrupt));
}

/* One poll, so long after the one before. */
static inline void rig_poll_after(uint32_t us)
{
    port_fake.now_us += us;
    cds_bus_poll(&bus);
}

/* The packet of the request leaves, also one that has to wait for a quiet line. */
static inline void rig_transmit(void)
{
    port_fake_settle(&bus);
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, bus.port));
}

/* The packet leaves, and a servo replies. */
static inline void rig_answer(uint8_t id, uint8_t error, const uint8_t *data, uint8_t length)
{
    rig_transmit();
    port_fake_answer(&bus.link, id, error, data, length);
    port_fake_look(&bus);
}

/* The packet leaves, and nothing comes back for longer than any servo takes. */
static inline void rig_stay_silent(void)
{
    rig_transmit();
    port_fake.now_us += 10000;
    port_fake_look(&bus);
}

/* True while the driver is on. */
static inline bool rig_is_sending(void)
{
    return port_fake.lines[bus.port] == FAKE_TALK;
}

/* A packet without a reply takes the bus. */
static inline void rig_occupy(struct cds_request *request)
{
    request->reply_parameters = CDS_REPLY_NONE;
    TEST_ASSERT_EQUAL(CDS_OK, cds_packet_action(&request->packet, CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, request));
}

static inline void rig_free(void)
{
    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, bus.port));
    port_fake_look(&bus);
}

/* Returns the result of the check, which for a broadcast comes while the request waits. */
static inline enum cds_result rig_result_of_check(struct cds_request *request,
                                                  enum cds_result submitted)
{
    if (submitted != CDS_OK || request->packet.bytes[CDS_AT_ID] != CDS_BROADCAST_ID)
        return submitted;
    port_fake_settle(&bus);
    return bus.request ? CDS_OK : (enum cds_result)request->result;
}

static inline void rig_assert_sent(const uint8_t *bytes, uint16_t size)
{
    TEST_ASSERT_EQUAL_UINT16(size, port_fake.sent_size);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes, port_fake.sent, size);
}

#endif
