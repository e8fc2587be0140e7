/* SPDX-License-Identifier: MIT */
#include "output/transcript.h"

#include <inttypes.h>

#define IDLE_BYTES 3 // a packet ends after so many byte times without a start bit

enum { HEADER = 0xFF, OVERHEAD = 4 }; // two header bytes, ID, LENGTH

/* Returns the position of the ID: any number of 0xFF may come before it. */
static unsigned header_end(const struct transcript *t)
{
    unsigned at = 0;
    while (at < t->size && t->bytes[at] == HEADER) {
        at++;
    }
    return at;
}

/* Returns the size of the packet, or 0 while it is not known. */
static unsigned whole_size(const struct transcript *t)
{
    unsigned id = header_end(t);
    if (id < 2 || id + 1 >= t->size) {
        return 0;
    }
    return id + 2u + t->bytes[id + 1];
}

static bool is_packet(const struct transcript *t)
{
    unsigned size = whole_size(t);
    if (size == 0 || size != t->size || t->bytes[header_end(t) + 1] < 2) {
        return false;
    }
    unsigned sum = 0;
    for (unsigned i = header_end(t); i < size; i++) {
        if (t->bad[i]) {
            return false;
        }
        sum += t->bytes[i];
    }
    return (sum & 0xFF) == 0xFF; // the checksum is the complement of the sum of the others
}

static void write_line(const struct transcript *t, FILE *out, const char *note)
{
    if (!out) {
        return;
    }
    fprintf(out, "%10" PRIu64 "%s %s:", t->start, t->label ? t->label : "",
            t->packet_from_controller ? "->in" : "<-out");
    for (unsigned i = 0; i < t->size; i++) {
        fprintf(out, " %02X%s", t->bytes[i], t->bad[i] ? "!" : "");
    }
    fprintf(out, " (LEN:%03u)%s\n", t->size, note);
}

static void finish(struct transcript *t, const char *note)
{
    schedule_cancel(t->schedule, &t->idle);
    write_line(t, t->file, note);
    write_line(t, t->echo, note);
    if (t->on_line) {
        t->on_line(t->context, t);
    }
    t->size = 0;
}

static void end_packet(struct transcript *t)
{
    if (!t->size) {
        return;
    }
    t->good = is_packet(t);
    t->packets_in += t->good && t->packet_from_controller;
    t->packets_out += t->good && !t->packet_from_controller;
    t->damaged += !t->good;
    finish(t, t->good ? "" : " no packet");
}

void transcript_end(struct transcript *t)
{
    if (t->size) {
        t->good = true; // the bytes so far are not wrong
        finish(t, " unfinished");
    }
}

static void fell_idle(void *context, uint64_t now)
{
    (void)now;
    end_packet(context);
}

static void driver_changed(void *context, uint64_t now, struct driver *driver)
{
    (void)now;
    struct transcript *t = context;
    if (driver->enabled && driver != t->controller) {
        t->servo = driver;
    }
}

/* Finds the sender of a start bit and its bit time. */
static uint32_t get_bit_time_256(void *context)
{
    struct transcript *t = context;
    t->byte_from_controller = t->controller && t->controller->enabled && !t->controller->level;
    const struct driver *tx = t->byte_from_controller ? t->controller_tx : t->servo;
    return tx && tx->bit_time_256 ? tx->bit_time_256 : t->rx.bit_time_256;
}

static void byte_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    (void)now;
    struct transcript *t = context;
    t->busy += frame->end - frame->start;
    if (t->size == TRANSCRIPT_SIZE ||
        (t->size && t->packet_from_controller != t->byte_from_controller)) {
        end_packet(t);
    }
    if (!t->size) {
        t->start = frame->start;
        t->packet_from_controller = t->byte_from_controller;
    }
    t->bytes[t->size] = frame->byte;
    t->bad[t->size] = frame->framing_error;
    t->size++;
    if (t->size == whole_size(t)) {
        end_packet(t);
    } else {
        uint64_t patience = IDLE_BYTES * (frame->end - frame->start);
        /* A byte that starts within the idle time is complete one byte time later. */
        schedule_at(t->schedule, &t->idle, frame->end + patience + (frame->end - frame->start));
    }
}

void transcript_init(struct transcript *transcript, struct schedule *schedule, struct net *net,
                     const struct driver *controller)
{
    *transcript = (struct transcript){
        .schedule = schedule, .controller = controller, .controller_tx = controller};
    transcript->listener = (struct listener){.context = transcript, .on_driver = driver_changed};
    net_listen(net, &transcript->listener);
    uart_rx_init(&transcript->rx, schedule, net, transcript);
    transcript->rx.bit_time_256 = 16 * 256;
    transcript->rx.get_bit_time_256 = get_bit_time_256;
    transcript->rx.on_byte = byte_received;
    uart_rx_enable(&transcript->rx, true);
    event_init(&transcript->idle, fell_idle, transcript);
}
