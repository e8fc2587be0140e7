/* The port that records; see port_fake.h. */
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
    return 1;
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
    return !port_fake.low;
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

#define LAP_US (0x10000u / CDS_PORT_TICKS_PER_US)

/* A timer of 16 bits: it expires once in every wrap, and counts as expired from then on. */
uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us)
{
    uint32_t us = (uint32_t)count * each_us + more_us;
    uint16_t passed_us =
        (uint16_t)(port_fake.now_us * CDS_PORT_TICKS_PER_US - from) / CDS_PORT_TICKS_PER_US;

    (void)line(port);
    port_fake.timers[port % FAKE_PORTS] =
        (struct fake_timer){.from_us = port_fake.now_us - passed_us, .wait_us = us % LAP_US};
    return (uint8_t)(us / LAP_US);
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
    timer->wait_us += LAP_US;
    if (port_fake.now_us - timer->from_us >= timer->wait_us) // expiries in between went unnoticed
        timer->wait_us +=
            (port_fake.now_us - timer->from_us - timer->wait_us) / LAP_US * LAP_US + LAP_US;
}

void port_fake_settle(struct cds_bus *bus)
{
    for (uint16_t i = 0; i < 300 && bus->request && !cds_bus_is_in_flight_(bus); i++) {
        port_fake.now_us += 10;
        cds_bus_poll(bus);
    }
}

void port_fake_look(struct cds_bus *bus)
{
    for (uint8_t i = 0; i < 12 && cds_bus_is_in_flight_(bus) &&
                        ((uint8_t)(bus->looked_to ^ bus->link.rx.head) || bus->link.broken);
         i++)
        cds_bus_poll(bus);
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
