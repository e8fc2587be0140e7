/* SPDX-License-Identifier: MIT */
/* Packets and text on the host link; see host_demux.h. */
#include "host/host_demux.h"

#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "compiler.h"     // OPTIMIZER_BARRIER(), NOINLINE
#include "ring_input.h"   // ring_peek(), ring_drop()

/* Bounds of a poll, since the bus must not wait. */
#define BYTES_PER_POLL   3  // bytes examined one by one
#define CUT_OFF_PER_POLL 16 // bytes examined one by one after a silence: Ctrl-X must be found soon
#define COUNTED_PER_POLL 32 // bytes that LENGTH counts

void host_demux_open(struct host_demux *demux, struct cds_ring *input, struct cds_ring *text,
                     uint8_t *bytes)
{
    OPTIMIZER_BARRIER(demux);
    *demux = (struct host_demux){.input = input, .text = text, .bytes = bytes};
}

NOINLINE bool host_is_late(uint32_t from_us)
{
    return cds_port_now_us() - from_us >= HOST_SILENCE_US;
}

static bool is_open(const struct host_demux *demux)
{
    return demux->count != 0;
}

/* Puts a byte of text into its ring. False: the ring has no room. */
static bool put(struct host_demux *demux, uint8_t byte)
{
    if (demux->lost) {
        if (!cds_ring_put(demux->text, HOST_MARK_LOST))
            return false;
        demux->lost = false;
        demux->typing = false;
    }
    return cds_ring_put(demux->text, byte);
}

#define STOP 0x18 // Ctrl-X

static bool ends_line(uint8_t byte)
{
    return byte == '\r' || byte == '\n';
}

/* Notes Ctrl-X outside a good packet. */
static void find_stop(struct host_demux *demux, uint8_t byte, bool damaged)
{
    if (byte != STOP)
        return;
    demux->stop = true;
    if (damaged)
        demux->counters.stops++;
}

static void take_text(struct host_demux *demux, uint8_t byte)
{
    find_stop(demux, byte, demux->suspect);
    if (demux->skipping) {
        demux->skipping = !ends_line(byte);
    } else if (byte != HOST_MARK_DROPPED && byte != HOST_MARK_LOST) {
        if (!put(demux, byte))
            host_demux_gap(demux);
        else
            demux->typing = !ends_line(byte);
        demux->suspect = demux->suspect && demux->typing;
    }
}

/* Drops the line that is being typed. */
static void drop_line(struct host_demux *demux)
{
    if (!demux->typing)
        return;
    if (put(demux, HOST_MARK_DROPPED))
        demux->typing = false;
    else
        demux->lost = true; // the next text must not join the half line in the ring
}

/* Empties the buffer. If `count` is 1, a 0xFF stands there. */
static NOINLINE void restart(struct host_demux *demux, uint16_t count)
{
    demux->bytes[0] = CDS_HEADER;
    demux->from = demux->end = 0;
    demux->count = demux->seen = count;
    demux->is_cut_off = demux->searched_again = false;
}

/* 0xFF: a packet may begin. */
static void begin(struct host_demux *demux, bool late)
{
    demux->late = late;
    demux->begun_us = cds_port_now_us();
    restart(demux, 1);
}

/* No good packet begins at `from`: drops the bytes from there to the next 0xFF, and searches on. */
static void reject(struct host_demux *demux)
{
    uint16_t from = demux->from;

    do {
        find_stop(demux, demux->bytes[from], true);
        from++;
    } while (from < demux->count && demux->bytes[from] != CDS_HEADER);
    demux->from = from;
    demux->seen = (uint16_t)(from + 1);
    demux->end = 0;
    if (demux->seen >= demux->count)
        restart(demux, from < demux->count);
    else
        demux->searched_again = true;
}

/* If a packet has begun, its bytes are from now on only searched for Ctrl-X. A packet that waits
 * for the bridge stays. */
NOINLINE void host_demux_gap(struct host_demux *demux)
{
    demux->counters.gaps++;
    demux->is_cut_off = is_open(demux);
    if (is_open(demux) && !demux->has_packet)
        reject(demux);
    demux->lost = true;
    demux->skipping = true;
}

static void reject_malformed(struct host_demux *demux)
{
    demux->counters.malformed++;
    demux->suspect = true;
    reject(demux);
}

static void move_to_front(struct host_demux *demux)
{
    uint16_t from = demux->from;

    if (from == 0)
        return;
    memmove(demux->bytes, demux->bytes + from, (uint16_t)(demux->count - from));
    demux->count = (uint16_t)(demux->count - from);
    demux->seen = (uint16_t)(demux->seen - from);
    if (demux->end)
        demux->end = (uint16_t)(demux->end - from);
    demux->from = 0;
}

/* Drops the good packet at `from`, and searches on after its end. */
static void drop_late(struct host_demux *demux)
{
    demux->counters.late++;
    demux->has_packet = false;
    demux->from = demux->end;
    demux->seen = (uint16_t)(demux->from + 1);
    demux->end = 0;
    if (demux->from >= demux->count)
        restart(demux, 0);
    else if (demux->bytes[demux->from] != CDS_HEADER)
        reject(demux);
}

/* The whole packet is there. With a good checksum its bytes add up to 0xFF. */
static void check_packet(struct host_demux *demux)
{
    if (demux->sum != UINT8_MAX) {
        reject_malformed(demux);
        return;
    }
    if (demux->is_cut_off || demux->late ||
        (demux->searched_again && host_is_late(demux->begun_us))) {
        drop_late(demux);
        return;
    }
    demux->counters.packets++;
    demux->packet_us = cds_port_now_us();
    demux->has_packet = true;
    demux->searched = cds_ring_begin(demux->input);
}

/* Examines the next byte. */
static void examine(struct host_demux *demux)
{
    uint8_t byte = demux->bytes[demux->seen];
    uint16_t at = (uint16_t)(demux->seen++ - demux->from);

    demux->sum = (uint8_t)(demux->sum + byte);
    if (at == 1) {
        bool is_header = byte == CDS_HEADER;

        if (!is_header && demux->count > 2) {
            reject(demux);
            return;
        }
        demux->skipping = !is_header && (demux->skipping || demux->typing);
        drop_line(demux); // 0xFF may stand in place of another byte of the line
        if (!is_header) { // after one 0xFF: the byte is text
            demux->count = demux->seen = 0;
            take_text(demux, byte);
        }
    } else if (at == CDS_AT_ID) {
        demux->sum = byte;
        if (byte == CDS_HEADER) // R27: more than two 0xFF; the last two are the header
            demux->from++;
    } else if (at == CDS_AT_LENGTH) {
        demux->end = (uint16_t)(demux->seen + byte);
        if (byte < CDS_LENGTH_MIN || byte > CDS_LENGTH_MAX)
            reject_malformed(demux);
        else if (demux->is_cut_off && demux->end > demux->count)
            reject(demux); // the end of the packet will not come
    }
}

/* LENGTH is known: adds up bytes of the packet that stand in the buffer. Returns their number. */
static uint8_t examine_counted(struct host_demux *demux)
{
    uint16_t to = demux->end < demux->count ? demux->end : demux->count;
    const uint8_t *from = demux->bytes + demux->seen;
    uint8_t sum = demux->sum;
    uint8_t count = COUNTED_PER_POLL;

    if (count > to - demux->seen)
        count = (uint8_t)(to - demux->seen);
    for (uint8_t left = count; left; left--)
        sum = (uint8_t)(sum + *from++);
    demux->sum = sum;
    demux->seen = (uint16_t)(demux->seen + count);
    if (demux->seen == demux->end)
        check_packet(demux);
    return count;
}

/* LENGTH is known: takes bytes of the packet from the ring and adds them up. Returns their number.
 * Most bytes of the host come this way, one each 160 cycles at 1 Mbps, so it is written for few
 * cycles. */
static uint8_t take_counted(struct host_demux *demux)
{
    const volatile uint8_t *ring = demux->input->bytes;
    uint8_t tail = demux->input->tail, sum = demux->sum;
    uint8_t count = cds_ring_count(demux->input);
    uint8_t *to;

    if (demux->end > HOST_PACKET_MAX)
        move_to_front(demux);
    if (count > COUNTED_PER_POLL)
        count = COUNTED_PER_POLL;
    if (count > demux->end - demux->count)
        count = (uint8_t)(demux->end - demux->count);
    to = demux->bytes + demux->count;
    for (uint8_t left = count; left; left--) {
        uint8_t byte = ring[tail++ & (CDS_RING_SIZE - 1)];

        *to++ = byte;
        sum = (uint8_t)(sum + byte);
    }
    demux->input->tail = tail; // only when the bytes are copied
    demux->old = demux->old > count ? (uint8_t)(demux->old - count) : 0;
    demux->sum = sum;
    demux->count = demux->seen = (uint16_t)(demux->count + count);
    if (demux->count == demux->end)
        check_packet(demux);
    return count;
}

/* Takes a byte out of the input ring. *late: it is too old for a packet. */
static uint8_t next_byte(struct host_demux *demux, bool *late)
{
    uint8_t byte = ring_peek(demux->input, 0);

    ring_drop(demux->input, 1);
    *late = demux->old != 0;
    if (*late)
        demux->old--;
    return byte;
}

static void take_byte(struct host_demux *demux)
{
    bool late;
    uint8_t byte = next_byte(demux, &late);

    if (is_open(demux)) {
        if (demux->count == HOST_PACKET_MAX)
            move_to_front(demux);
        demux->bytes[demux->count++] = byte;
        examine(demux);
    } else if (byte == CDS_HEADER) {
        begin(demux, late);
    } else {
        take_text(demux, byte);
    }
}

/* All bytes were taken. Ends line and packet when the host has been silent for HOST_SILENCE_US. */
static void check_silence(struct host_demux *demux)
{
    if (!is_open(demux) && !demux->skipping && !demux->suspect)
        return;
    if (!host_is_late(demux->heard_us))
        return;
    demux->skipping = false;
    if (demux->suspect)
        drop_line(demux);
    demux->suspect = false;
    if (is_open(demux)) {
        if (demux->count > 1) // a single 0xFF counts as no packet
            demux->counters.silent++;
        demux->is_cut_off = true;
        reject(demux);
    }
}

/* True if text follows the packet that waits for the bridge: Ctrl-X must not wait with it. */
static bool text_follows(const struct host_demux *demux)
{
    return demux->count == demux->end && cds_ring_count(demux->input) &&
           ring_peek(demux->input, 0) != CDS_HEADER;
}

static void take_following(struct host_demux *demux)
{
    bool late;
    uint8_t byte = next_byte(demux, &late);

    if (byte == STOP)
        drop_late(demux); // it may be a release, which must not act after the stop
    take_text(demux, byte);
}

/* Returns the size of what begins at `position` in the input ring: of a good packet, else 1. 0: it
 * may be a packet, but its end has not come yet. */
static uint8_t size_at(const struct cds_ring *input, uint8_t position)
{
    uint8_t left = cds_ring_distance(position, cds_ring_end(input)), size, sum = 0;

    for (uint8_t at = 0; at < CDS_AT_LENGTH; at++) {
        if (at == left)
            return 0;
        if ((cds_ring_at(input, cds_ring_after(position, at)) == CDS_HEADER) != (at < CDS_AT_ID))
            return 1; // text, or more than two 0xFF (R27)
    }
    if (left == CDS_AT_LENGTH)
        return 0;
    size = cds_ring_at(input, cds_ring_after(position, CDS_AT_LENGTH));
    if (size < CDS_LENGTH_MIN || size > CDS_LENGTH_MAX)
        return 1;
    if (size >= left - CDS_AT_LENGTH) // LENGTH counts the bytes after it
        return 0;
    size = (uint8_t)(size + CDS_AT_LENGTH + 1);
    for (uint8_t at = CDS_AT_ID; at < size; at++)
        sum = (uint8_t)(sum + cds_ring_at(input, cds_ring_after(position, at)));
    return sum == UINT8_MAX ? size : 1;
}

/* Ctrl-X stands at `position` in the input ring, behind the packet that waits: drops all that came
 * before it, since a packet may be a release. */
static void stop_at(struct host_demux *demux, uint8_t position)
{
    uint8_t at = cds_ring_begin(demux->input), size;

    for (; at != position; at = cds_ring_after(at, size)) {
        size = size_at(demux->input, at);
        if (size > 1)
            demux->counters.late++;
    }
    size = (uint8_t)(cds_ring_distance(cds_ring_begin(demux->input), position) + 1);
    demux->old = demux->old > size ? (uint8_t)(demux->old - size) : 0;
    ring_drop(demux->input, size);
    drop_late(demux);
    demux->stop = true;
}

/* Searches the input ring for Ctrl-X: it must wait neither with the packet that waits for the
 * bridge nor with packets behind that. Goes on where the last call has ended. */
static void search_ring(struct host_demux *demux)
{
    uint8_t end = cds_ring_end(demux->input), size;

    if (demux->count != demux->end || text_follows(demux))
        return; // the ring begins within a packet; or take_following() takes the text first
    if (cds_ring_distance(cds_ring_begin(demux->input), demux->searched) > CDS_RING_SIZE)
        demux->searched = cds_ring_begin(demux->input); // text was taken
    while (demux->searched != end && (size = size_at(demux->input, demux->searched))) {
        if (size == 1 && cds_ring_at(demux->input, demux->searched) == STOP) {
            stop_at(demux, demux->searched);
            return;
        }
        demux->searched = cds_ring_after(demux->searched, size);
    }
}

static void work(struct host_demux *demux)
{
    uint8_t left = demux->is_cut_off ? CUT_OFF_PER_POLL : BYTES_PER_POLL;

    while (!demux->has_packet || text_follows(demux)) {
        uint8_t done = 1;

        if (demux->has_packet)
            take_following(demux);
        else if (demux->seen < demux->count && demux->end)
            done = examine_counted(demux);
        else if (demux->seen < demux->count)
            examine(demux);
        else if (demux->is_cut_off)
            reject(demux); // the end of the packet will not come; do so before taking another byte
        else if (cds_ring_count(demux->input) == 0)
            break;
        else if (demux->end)
            done = take_counted(demux);
        else
            take_byte(demux);
        if (done >= left)
            break;
        left = (uint8_t)(left - done);
        if (left > BYTES_PER_POLL && !demux->is_cut_off)
            left = BYTES_PER_POLL; // the cut-off bytes are examined
    }
}

/* Puts one mark, unless the last byte of the text is such a mark: the console answers each of them
 * with a line. */
static bool mark_lost(struct cds_ring *text)
{
    if (cds_ring_count(text) &&
        text->bytes[(text->head - 1u) & (CDS_RING_SIZE - 1)] == HOST_MARK_LOST)
        return true;
    return cds_ring_put(text, HOST_MARK_LOST);
}

/* Notes when the last byte came. Drops a packet that has waited too long for the bridge; the bytes
 * that came meanwhile are then too old for a packet, too. */
static void watch_time(struct host_demux *demux)
{
    uint8_t head = demux->input->head;

    if (head != demux->head) {
        demux->head = head;
        demux->heard_us = cds_port_now_us();
    }
    if (demux->has_packet)
        search_ring(demux);
    if (demux->has_packet && host_is_late(demux->packet_us)) {
        demux->old = cds_ring_count(demux->input);
        drop_late(demux);
    }
}

bool host_demux_poll(struct host_demux *demux)
{
    uint8_t tail;

    OPTIMIZER_BARRIER(demux);
    tail = demux->input->tail;
    watch_time(demux);
    if (demux->lost && !demux->skipping &&
        mark_lost(demux->text)) { // the end of the line may be lost, too
        demux->lost = false;
        demux->typing = false;
    }
    work(demux);
    if (tail != demux->input->tail)
        return !demux->has_packet &&
               (demux->end || cds_ring_count(demux->text) < CDS_RING_SIZE / 2);
    if (!demux->has_packet && demux->seen == demux->count)
        check_silence(demux);
    return false;
}

uint8_t *host_demux_take(struct host_demux *demux, uint8_t *other)
{
    uint8_t *packet = demux->bytes;
    uint16_t size;

    move_to_front(demux);
    size = (uint16_t)(packet[CDS_AT_LENGTH] + CDS_AT_LENGTH + 1);
    demux->count = (uint16_t)(demux->count - size);
    memcpy(other, packet + size, demux->count);
    demux->bytes = other;
    demux->seen = demux->count ? 1 : 0;
    demux->end = 0;
    demux->has_packet = false;
    if (demux->count && other[0] != CDS_HEADER)
        reject(demux); // bytes within a damaged packet are no text
    return packet;
}

bool host_demux_idle(const struct host_demux *demux)
{
    return !demux->has_packet && !is_open(demux) && !demux->lost && !demux->skipping &&
           cds_ring_count(demux->input) == 0;
}
