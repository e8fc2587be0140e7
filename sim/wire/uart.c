/* SPDX-License-Identifier: MIT */
#include "wire/uart.h"

uint32_t uart_bit_time_256(uint32_t clock_Hz, uint32_t baud)
{
    return (uint32_t)(((uint64_t)clock_Hz * 256 + baud / 2) / baud);
}

uint64_t uart_cycles_of_half_bits(uint32_t bit_time_256, unsigned half_bits)
{
    return ((uint64_t)bit_time_256 * half_bits + 256) / 512;
}

uint64_t uart_tx_bit_time(const struct uart_tx *tx, unsigned bit)
{
    return tx->start + uart_cycles_of_half_bits(tx->bit_time_256, bit * 2);
}

/* One event for each change of level saves events: a byte of 0x00 needs 3, not 10. */
static void uart_tx_next(struct uart_tx *tx)
{
    bool level = tx->frame >> tx->bit & 1;
    do {
        tx->bit++;
    } while (tx->bit < UART_FRAME_BITS && (tx->frame >> tx->bit & 1) == level);
    schedule_at(tx->schedule, &tx->event, uart_tx_bit_time(tx, tx->bit));
}

static void uart_tx_run(void *context, uint64_t now)
{
    struct uart_tx *tx = context;
    if (tx->bit == UART_FRAME_BITS) {
        tx->busy = false;
        tx->on_end(tx->context, now);
        return;
    }
    if (tx->bit == 0 && tx->on_start) {
        tx->on_start(tx->context, now);
    }
    driver_level(tx->driver, now, tx->frame >> tx->bit & 1);
    uart_tx_next(tx);
}

void uart_tx_init(struct uart_tx *tx, struct schedule *schedule, struct driver *driver,
                  void *context)
{
    *tx = (struct uart_tx){.schedule = schedule, .driver = driver, .context = context};
    event_init(&tx->event, uart_tx_run, tx);
}

void uart_tx_send(struct uart_tx *tx, uint64_t start, uint32_t bit_time_256, uint8_t byte)
{
    tx->busy = true;
    tx->start = start;
    tx->bit_time_256 = bit_time_256;
    tx->driver->bit_time_256 = bit_time_256;
    tx->frame = (uint16_t)(0x200 | byte << 1);
    tx->bit = 0;
    schedule_at(tx->schedule, &tx->event, start);
}

uint64_t uart_tx_end(const struct uart_tx *tx)
{
    return uart_tx_bit_time(tx, UART_FRAME_BITS);
}

void uart_tx_stop(struct uart_tx *tx, uint64_t now)
{
    schedule_cancel(tx->schedule, &tx->event);
    tx->busy = false;
    driver_level(tx->driver, now, true);
}

static uint64_t sample_time(const struct uart_rx *rx, unsigned sample)
{
    return rx->start + uart_cycles_of_half_bits(rx->bit_time_256, sample * 2 + 1);
}

/* Takes all samples before `time`. The net had rx->level since its latest change. */
static void catch_up(struct uart_rx *rx, uint64_t time)
{
    while (rx->samples < UART_FRAME_BITS && sample_time(rx, rx->samples) < time) {
        rx->bits = (uint16_t)(rx->bits | rx->level << rx->samples);
        rx->samples++;
    }
}

static void begin(struct uart_rx *rx, uint64_t time)
{
    if (rx->get_bit_time_256) {
        rx->bit_time_256 = rx->get_bit_time_256(rx->context);
    }
    rx->in_frame = true;
    rx->start = time;
    rx->samples = 0;
    rx->bits = 0;
    unsigned first = rx->on_start ? 0 : UART_FRAME_BITS - 1;
    schedule_at(rx->schedule, &rx->event, sample_time(rx, first));
}

static void uart_rx_level(void *context, uint64_t time, bool level)
{
    struct uart_rx *rx = context;
    if (rx->in_frame) {
        catch_up(rx, time);
        /* High in the middle of the start bit: the start bit was a glitch, and this edge may be a
         * start bit. */
        if (rx->samples && (rx->bits & 1)) {
            rx->in_frame = false;
        }
    }
    /* The net was high for 0 cycles, between two drivers: this is no falling edge. */
    if (!level && rx->enabled && !rx->in_frame && rx->level_time != time) {
        begin(rx, time);
    }
    rx->level = level;
    rx->level_time = time;
}

static void uart_rx_run(void *context, uint64_t now)
{
    struct uart_rx *rx = context;
    catch_up(rx, now + 1);
    if (rx->bits & 1) {
        rx->in_frame = false;
        return;
    }
    if (rx->samples < UART_FRAME_BITS) { // middle of the start bit; only with on_start
        schedule_at(rx->schedule, &rx->event, sample_time(rx, UART_FRAME_BITS - 1));
        rx->on_start(rx->context, now);
        return;
    }
    /* After a low stop bit the net must be high before a frame can begin. Only falling edges begin
     * frames, so no further check is needed. */
    rx->in_frame = false;
    struct uart_frame frame = {
        .byte = (uint8_t)(rx->bits >> 1),
        .framing_error = !(rx->bits & 0x200),
        .start = rx->start,
        .end = rx->start + uart_cycles_of_half_bits(rx->bit_time_256, UART_FRAME_BITS * 2),
    };
    rx->on_byte(rx->context, now, &frame);
}

void uart_rx_init(struct uart_rx *rx, struct schedule *schedule, struct net *net, void *context)
{
    *rx = (struct uart_rx){.schedule = schedule,
                           .net = net,
                           .context = context,
                           .level = net->level,
                           .level_time = SCHEDULE_NEVER};
    event_init(&rx->event, uart_rx_run, rx);
    rx->event.rank = NET_SAMPLE_RANK;
    rx->listener = (struct listener){.context = rx, .on_level = uart_rx_level};
    net_listen(net, &rx->listener);
}

void uart_rx_enable(struct uart_rx *rx, bool enabled)
{
    if (!enabled) {
        schedule_cancel(rx->schedule, &rx->event);
        rx->in_frame = false;
    }
    rx->enabled = enabled;
}
