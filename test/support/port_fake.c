/* SPDX-License-Identifier: MIT */
/* A port that records its calls; see port_fake.h. */
#include "port_fake.h"

#include "cds55xx/port.h" // what is implemented here

struct port_fake port_fake;

void port_fake_reset(void)
{
    port_fake = (struct port_fake){.now_us = 0}; // a direction of FAKE_OPEN: not opened yet
}

void port_fake_forget(void)
{
    port_fake.verbs = 0;
    port_fake.sent_size = 0;
    port_fake.clock_reads = 0;
}

static void record(uint8_t verb, uint8_t port, uint8_t byte)
{
    if (port_fake.verbs < FAKE_LOG_SIZE)
        port_fake.log[port_fake.verbs] = (struct fake_entry){verb, port, byte};
    port_fake.verbs++;
}

static void breach_unless(bool allowed)
{
    if (!allowed)
        port_fake.breaches++;
}

static uint8_t *line(uint8_t port)
{
    breach_unless(port < FAKE_PORTS);
    return &port_fake.lines[port % FAKE_PORTS];
}

void cds_port_open(uint8_t port, uint8_t baud)
{
    record(FAKE_OPEN, port, baud);
    *line(port) = FAKE_HIGH_Z;
    port_fake.bauds[port % FAKE_PORTS] = baud;
}

void cds_port_high_z(uint8_t port)
{
    record(FAKE_HIGH_Z, port, 0);
    *line(port) = FAKE_HIGH_Z;
}

void cds_port_listen(uint8_t port)
{
    record(FAKE_LISTEN, port, 0);
    breach_unless(*line(port) != FAKE_TALK); // that would cut a packet short
    *line(port) = FAKE_LISTEN;
}

static void put_on_the_line(uint8_t byte)
{
    if (port_fake.sent_size < FAKE_SENT_SIZE)
        port_fake.sent[port_fake.sent_size] = byte;
    port_fake.sent_size++;
}

uint8_t cds_port_talk(uint8_t port, uint8_t byte)
{
    cds_port_high_z(port);
    record(FAKE_TALK, port, 0);
    *line(port) = FAKE_TALK;
    record(FAKE_TX, port, byte);
    port_fake.sent_size = 0;
    port_fake.followed = false;
    put_on_the_line(byte);
    if (!port_fake.takes_two)
        return 1;
    record(FAKE_TX, port, byte);
    put_on_the_line(byte);
    return 2;
}

void cds_port_follow(uint8_t port)
{
    breach_unless(*line(port) == FAKE_TALK && !port_fake.followed);
    port_fake.followed = true;
    if (port_fake.eager)
        breach_unless(port_fake_transmit(port_fake.eager, port));
}

void cds_port_tx(uint8_t port, uint8_t byte)
{
    record(FAKE_TX, port, byte);
    breach_unless(*line(port) == FAKE_TALK && port_fake.followed);
    put_on_the_line(byte);
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    record(FAKE_TX_LAST, port, byte);
    breach_unless(*line(port) == FAKE_TALK && port_fake.followed);
    *line(port) = FAKE_TX_LAST;
    put_on_the_line(byte);
    port_fake.packets++;
}

bool cds_port_line_is_high(uint8_t port)
{
    breach_unless(*line(port) == FAKE_LISTEN);
    if (!port_fake.low && !port_fake.low_looks)
        return true;
    port_fake.low_seen++;
    if (port_fake.low_looks)
        port_fake.low_looks--;
    return false;
}

uint32_t cds_port_now_us(void)
{
    port_fake.clock_reads++;
    port_fake.now_us += port_fake.us_per_reading;
    return port_fake.now_us;
}

uint16_t cds_port_ticks(void)
{
    return (uint16_t)(cds_port_now_us() * CDS_PORT_TICKS_PER_US);
}

#define WRAP_US (0x10000u / CDS_PORT_TICKS_PER_US)

/* A compare register of 16 bits: it matches once in every wrap, and stays expired. */
uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us)
{
    uint32_t us = (uint32_t)count * each_us + more_us;
    uint16_t passed_us =
        (uint16_t)(port_fake.now_us * CDS_PORT_TICKS_PER_US - from) / CDS_PORT_TICKS_PER_US;

    (void)line(port);
    port_fake.timers[port % FAKE_PORTS] =
        (struct fake_timer){.from_us = port_fake.now_us - passed_us, .wait_us = us % WRAP_US};
    return (uint8_t)(us / WRAP_US);
}

bool cds_port_timer_expired(uint8_t port)
{
    const struct fake_timer *timer = &port_fake.timers[port % FAKE_PORTS];

    if (port_fake.late)
        cds_link_on_tx_complete(port_fake.late, port);
    port_fake.late = NULL;
    port_fake.clock_reads++;
    (void)line(port);
    port_fake.now_us += port_fake.us_per_reading;
    return port_fake.now_us - timer->from_us >= timer->wait_us;
}

void cds_port_restart_timer(uint8_t port)
{
    struct fake_timer *timer = &port_fake.timers[port % FAKE_PORTS];

    (void)line(port);
    timer->wait_us += WRAP_US;
    if (port_fake.now_us - timer->from_us >= timer->wait_us) // matches in between went unseen
        timer->wait_us +=
            (port_fake.now_us - timer->from_us - timer->wait_us) / WRAP_US * WRAP_US + WRAP_US;
}

bool port_fake_is_in_flight(const struct cds_bus *bus)
{
    return bus->state >= CDS_BUS_SENDING;
}

void port_fake_settle(struct cds_bus *bus)
{
    for (uint16_t i = 0; i < 300 && bus->request && !port_fake_is_in_flight(bus); i++) {
        port_fake.now_us += 10;
        cds_bus_poll(bus);
    }
}

/* What a poll that does something changes of a transaction in flight, but for the poll that sees
 * the deadline pass. */
static uint32_t progress(const struct cds_bus *bus)
{
    return (uint32_t)bus->state << 24 | (uint32_t)(bus->link.broken != 0) << 16 |
           (uint32_t)bus->parser.position << 8 | bus->link.rx.tail;
}

void port_fake_look(struct cds_bus *bus)
{
    uint16_t sent = bus->stats.sent;

    for (uint8_t idle = 0; idle < 2;) {
        uint32_t before = progress(bus);

        if (!port_fake_is_in_flight(bus) || bus->stats.sent != sent)
            return;
        cds_bus_poll(bus);
        idle = progress(bus) == before ? (uint8_t)(idle + 1) : 0;
    }
}

bool port_fake_drain(struct cds_link *link, uint8_t port)
{
    for (uint16_t i = 0; i <= FAKE_SENT_SIZE && link->state == CDS_LINK_TALKING; i++)
        cds_link_on_tx_ready(link, port);
    return link->state == CDS_LINK_DRAINING;
}

bool port_fake_transmit(struct cds_link *link, uint8_t port)
{
    if (!port_fake_drain(link, port))
        return false;
    cds_link_on_tx_complete(link, port);
    return true;
}

void port_fake_hear(struct cds_link *link, const uint8_t *bytes, uint16_t count)
{
    for (uint16_t i = 0; i < count; i++)
        cds_link_on_rx(link, bytes[i], 0);
}

void port_fake_answer(struct cds_link *link, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count)
{
    uint8_t head[5] = {0xFF, 0xFF, id, (uint8_t)(count + 2), error};
    uint8_t checksum = (uint8_t)(0xFF - id - head[3] - error);

    for (uint8_t i = 0; i < count; i++)
        checksum = (uint8_t)(checksum - parameters[i]);
    port_fake_hear(link, head, sizeof head);
    port_fake_hear(link, parameters, count);
    port_fake_hear(link, &checksum, 1);
}
