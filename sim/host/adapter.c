/* SPDX-License-Identifier: MIT */
#include "host/adapter.h"

#define BAUD_MAX 4000000 // the FT232 in a USB2Dynamixel allows 3 000 000

static void set_driving(struct adapter *adapter, uint64_t now, bool driving)
{
    driver_enable(&adapter->to_rxd, now, !driving);
    driver_enable(&adapter->driver, now, driving);
    if (adapter->on_drive) {
        adapter->on_drive(adapter->context, now, driving);
    }
}

static void send_next(struct adapter *adapter, uint64_t now)
{
    const struct adapter_byte *next = &adapter->queue[adapter->head];
    adapter->head = (adapter->head + 1) % ADAPTER_SIZE;
    adapter->waiting--;
    uart_tx_send(&adapter->tx, now, next->bit_time_256, next->byte);
}

static void byte_begins(void *context, uint64_t now)
{
    struct adapter *adapter = context;
    if (adapter->on_start) {
        adapter->on_start(adapter->context, now);
    }
}

static void byte_sent(void *context, uint64_t now)
{
    struct adapter *adapter = context;
    if (adapter->waiting) {
        send_next(adapter, now);
    } else if (adapter->half_duplex) {
        set_driving(adapter, now, false);
    }
}

static void level_changed(void *context, uint64_t now, bool level)
{
    struct adapter *adapter = context;
    driver_level(&adapter->to_rxd, now, level);
}

static void byte_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    struct adapter *adapter = context;
    adapter->framing_errors += frame->framing_error;
    if (adapter->on_byte) {
        adapter->on_byte(adapter->context, now, frame->byte);
    }
}

static uint32_t get_bit_time_256(void *context)
{
    const struct adapter *adapter = context;
    return adapter->follow ? adapter->follow(adapter->follow_context) : adapter->bit_time_256;
}

void adapter_init(struct adapter *adapter, struct schedule *schedule, struct net *to,
                  struct net *from, uint32_t clock_Hz, uint32_t baud)
{
    *adapter =
        (struct adapter){.schedule = schedule, .clock_Hz = clock_Hz, .half_duplex = to == from};
    adapter_baud(adapter, baud);
    driver_init(&adapter->driver, to);
    driver_enable(&adapter->driver, schedule->now, !adapter->half_duplex);
    uart_tx_init(&adapter->tx, schedule, &adapter->driver, adapter);
    adapter->tx.on_start = byte_begins;
    adapter->tx.on_end = byte_sent;
    net_init(&adapter->rxd);
    driver_init(&adapter->to_rxd, &adapter->rxd);
    driver_set(&adapter->to_rxd, schedule->now, true, from->level);
    adapter->listener = (struct listener){.context = adapter, .on_level = level_changed};
    net_listen(from, &adapter->listener);
    uart_rx_init(&adapter->rx, schedule, &adapter->rxd, adapter);
    adapter->rx.get_bit_time_256 = get_bit_time_256;
    adapter->rx.on_byte = byte_received;
    uart_rx_enable(&adapter->rx, true);
}

void adapter_baud(struct adapter *adapter, uint32_t baud)
{
    if (baud == 0 || baud == adapter->baud) {
        return;
    }
    adapter->baud = baud;
    adapter->bit_time_256 = uart_bit_time_256(adapter->clock_Hz, baud < BAUD_MAX ? baud : BAUD_MAX);
}

void adapter_follow(struct adapter *adapter, uint32_t (*follow)(void *context), void *context)
{
    adapter->follow = follow;
    adapter->follow_context = context;
}

size_t adapter_space(const struct adapter *adapter)
{
    return ADAPTER_SIZE - adapter->waiting;
}

void adapter_send(struct adapter *adapter, uint64_t now, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size && adapter->waiting < ADAPTER_SIZE; i++) {
        size_t end = (adapter->head + adapter->waiting++) % ADAPTER_SIZE;
        adapter->queue[end] = (struct adapter_byte){get_bit_time_256(adapter), bytes[i]};
    }
    if (!adapter->waiting || adapter->tx.busy) {
        return;
    }
    if (adapter->half_duplex && !adapter->driver.enabled) {
        set_driving(adapter, now, true);
    }
    send_next(adapter, now);
}

uint64_t adapter_end(const struct adapter *adapter)
{
    uint64_t end = uart_tx_end(&adapter->tx);
    for (size_t i = 0; i < adapter->waiting; i++) {
        const struct adapter_byte *byte = &adapter->queue[(adapter->head + i) % ADAPTER_SIZE];
        end += uart_cycles_of_half_bits(byte->bit_time_256, UART_FRAME_BITS * 2);
    }
    return end;
}
