#include "host/adapter.h"

#define BAUD_MAX 4000000 // of the FT232 in a USB2Dynamixel it is 3 000 000

static void set_driving(struct adapter *adapter, uint64_t now, bool driving)
{
    driver_enable(&adapter->to_rx, now, !driving);
    driver_enable(&adapter->driver, now, driving);
    if (adapter->on_talk) {
        adapter->on_talk(adapter->owner, now, driving);
    }
}

static void say_next(struct adapter *adapter, uint64_t now)
{
    const struct adapter_byte *next = &adapter->queue[adapter->head];
    adapter->head = (adapter->head + 1) % ADAPTER_ROOM;
    adapter->waiting--;
    talker_say(&adapter->talker, now, next->bit_256, next->byte);
}

static void byte_begins(void *owner, uint64_t now)
{
    struct adapter *adapter = owner;
    if (adapter->on_start) {
        adapter->on_start(adapter->owner, now);
    }
}

static void byte_said(void *owner, uint64_t now)
{
    struct adapter *adapter = owner;
    if (adapter->waiting) {
        say_next(adapter, now);
    } else if (adapter->half_duplex) {
        set_driving(adapter, now, false);
    }
}

static void level_changed(void *owner, uint64_t now, bool level)
{
    struct adapter *adapter = owner;
    driver_level(&adapter->to_rx, now, level);
}

static void byte_heard(void *owner, uint64_t now, const struct heard *heard)
{
    struct adapter *adapter = owner;
    adapter->framing_errors += heard->framing_error;
    if (adapter->on_byte) {
        adapter->on_byte(adapter->owner, now, heard->byte);
    }
}

static uint32_t ask_bit(void *owner)
{
    const struct adapter *adapter = owner;
    return adapter->bit_256;
}

void adapter_init(struct adapter *adapter, struct schedule *schedule, struct net *to,
                  struct net *from, uint32_t clock_Hz, uint32_t baud)
{
    *adapter =
        (struct adapter){.schedule = schedule, .clock_Hz = clock_Hz, .half_duplex = to == from};
    adapter_baud(adapter, baud);
    driver_init(&adapter->driver, to);
    driver_enable(&adapter->driver, schedule->now, !adapter->half_duplex);
    talker_init(&adapter->talker, schedule, &adapter->driver, adapter);
    adapter->talker.on_start = byte_begins;
    adapter->talker.on_end = byte_said;
    net_init(&adapter->rx);
    driver_init(&adapter->to_rx, &adapter->rx);
    driver_set(&adapter->to_rx, schedule->now, true, from->level);
    adapter->listener = (struct listener){.owner = adapter, .on_level = level_changed};
    net_listen(from, &adapter->listener);
    ear_init(&adapter->ear, schedule, &adapter->rx, adapter);
    adapter->ear.ask_bit = ask_bit;
    adapter->ear.on_byte = byte_heard;
    ear_enable(&adapter->ear, true);
}

void adapter_baud(struct adapter *adapter, uint32_t baud)
{
    if (baud == 0 || baud == adapter->baud) {
        return;
    }
    adapter->baud = baud;
    adapter->bit_256 = uart_bit_256(adapter->clock_Hz, baud < BAUD_MAX ? baud : BAUD_MAX);
}

size_t adapter_room(const struct adapter *adapter)
{
    return ADAPTER_ROOM - adapter->waiting;
}

void adapter_say(struct adapter *adapter, uint64_t now, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size && adapter->waiting < ADAPTER_ROOM; i++) {
        size_t end = (adapter->head + adapter->waiting++) % ADAPTER_ROOM;
        adapter->queue[end] = (struct adapter_byte){adapter->bit_256, bytes[i]};
    }
    if (!adapter->waiting || adapter->talker.busy) {
        return;
    }
    if (adapter->half_duplex && !adapter->driver.enabled) {
        set_driving(adapter, now, true);
    }
    say_next(adapter, now);
}

uint64_t adapter_end(const struct adapter *adapter)
{
    uint64_t end = talker_end(&adapter->talker);
    for (size_t i = 0; i < adapter->waiting; i++) {
        const struct adapter_byte *byte = &adapter->queue[(adapter->head + i) % ADAPTER_ROOM];
        end += uart_half_bits(byte->bit_256, UART_FRAME_BITS * 2);
    }
    return end;
}
