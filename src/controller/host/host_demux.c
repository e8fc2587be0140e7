/* Packets and text on the host link; see host_demux.h. */
#include "host/host_demux.h"

#include <string.h>

#include "cds55xx/port.h"  // cds_port_now_us()
#include "compiler.h"      // OPTIMIZER_BARRIER(), NOINLINE
#include "console/input.h" // input_peek(), input_drop()

/* Examined at the most in a poll, one by one, or those that LENGTH counts: the bus must not wait.
 */
#define BYTES_PER_POLL   3
#define STALE_PER_POLL   16 // after a silence: a stop among them must be found soon
#define COUNTED_PER_POLL 32

void host_demux_open(struct host_demux *demux, struct cds_ring *input, struct cds_ring *text,
                     uint8_t *bytes)
{
    OPTIMIZER_BARRIER(demux);
    *demux = (struct host_demux){.input = input, .text = text, .bytes = bytes};
}

static bool is_open(const struct host_demux *demux)
{
    return demux->count != 0;
}

/* False: there is no room for it. */
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

/* A Ctrl-X that is no part of a good packet. */
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

/* What was typed of this line is gone. */
static void drop_line(struct host_demux *demux)
{
    if (!demux->typing)
        return;
    if (put(demux, HOST_MARK_DROPPED))
        demux->typing = false;
    else
        demux->lost = true; // there is half a line in the ring, which must not be joined
}

/* Nothing stands there, or, if `count` is 1, a 0xFF. */
static void restart(struct host_demux *demux, uint16_t count)
{
    demux->bytes[0] = CDS_HEADER;
    demux->from = demux->end = 0;
    demux->count = demux->seen = count;
    demux->stale = demux->searched_again = false;
}

/* 0xFF: a packet may begin. */
static void begin(struct host_demux *demux, bool late)
{
    demux->skipping = false;
    demux->late = late;
    demux->begun_us = cds_port_now_us();
    restart(demux, 1);
    drop_line(demux);
}

/* What stands at `from` begins no packet: the search goes on behind its first byte. The bytes up to
 * the next 0xFF are no part of a packet. */
static void refute(struct host_demux *demux)
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

/* Something is lost behind all that was taken. The bytes of a packet that has begun are searched
 * for a stop only; a packet that waits for the bridge is not concerned. */
NOINLINE void host_demux_gap(struct host_demux *demux)
{
    demux->counters.gaps++;
    demux->stale = is_open(demux);
    if (is_open(demux) && !demux->whole)
        refute(demux);
    demux->lost = true;
    demux->skipping = true;
}

static void refute_counted(struct host_demux *demux)
{
    demux->counters.malformed++;
    demux->suspect = true;
    refute(demux);
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

/* Drops the good packet at `from`; what stands behind it is searched on. */
static void drop_late(struct host_demux *demux)
{
    demux->counters.late++;
    demux->whole = false;
    demux->from = demux->end;
    demux->seen = (uint16_t)(demux->from + 1);
    demux->end = 0;
    if (demux->from >= demux->count)
        restart(demux, 0);
    else if (demux->bytes[demux->from] != CDS_HEADER)
        refute(demux);
}

/* The checksum was the last byte: all of the packet adds up to 0xFF. */
static void judge(struct host_demux *demux)
{
    uint32_t now_us = cds_port_now_us();

    if (demux->sum != UINT8_MAX) {
        refute_counted(demux);
        return;
    }
    if (demux->stale || demux->late ||
        (demux->searched_again && now_us - demux->begun_us >= HOST_SILENCE_US)) {
        drop_late(demux);
        return;
    }
    demux->counters.packets++;
    demux->whole_us = now_us;
    demux->whole = true;
}

/* Examines the next byte. */
static void examine(struct host_demux *demux)
{
    uint8_t byte = demux->bytes[demux->seen];
    uint16_t at = (uint16_t)(demux->seen++ - demux->from);

    demux->sum = (uint8_t)(demux->sum + byte);
    if (at == 1 && byte != CDS_HEADER) {
        bool lone = demux->count == 2; // nothing but 0xFF came: this byte stands outside

        if (lone) {
            restart(demux, 0);
            take_text(demux, byte);
        } else {
            refute(demux);
        }
    } else if (at == CDS_AT_ID) {
        demux->sum = byte;
        if (byte == CDS_HEADER) // R27: still header; the last two of them count
            demux->from++;
    } else if (at == CDS_AT_LENGTH) {
        demux->end = (uint16_t)(demux->seen + byte);
        if (byte < CDS_LENGTH_MIN || byte > CDS_LENGTH_MAX)
            refute_counted(demux);
        else if (demux->stale && demux->end > demux->count)
            refute(demux); // its end will not come
    }
}

/* LENGTH is known: adds up as many of the bytes that it counts as stand there already. */
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
        judge(demux);
    return count;
}

/* The same, of those that are in the ring. The bulk of what the host says, at 160 cycles a byte and
 * more: here cycles count. */
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
    demux->input->tail = tail; // behind the bytes
    demux->old = demux->old > count ? (uint8_t)(demux->old - count) : 0;
    demux->sum = sum;
    demux->count = demux->seen = (uint16_t)(demux->count + count);
    if (demux->count == demux->end)
        judge(demux);
    return count;
}

/* Takes a byte out of the input ring; *late: it came too long ago for a packet. */
static uint8_t next_byte(struct host_demux *demux, bool *late)
{
    uint8_t byte = input_peek(demux->input, 0);

    input_drop(demux->input, 1);
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

/* All that came was taken: for how long has the host been silent? */
static void listen(struct host_demux *demux)
{
    if (!is_open(demux) && !demux->skipping && !demux->suspect)
        return;
    if (cds_port_now_us() - demux->heard_us < HOST_SILENCE_US)
        return;
    demux->skipping = false;
    if (demux->suspect)
        drop_line(demux);
    demux->suspect = false;
    if (is_open(demux)) {
        if (demux->count > 1) // a lone 0xFF is no packet
            demux->counters.silent++;
        demux->stale = true;
        refute(demux);
    }
}

/* Behind a packet that waits for its turn: Ctrl-X must not wait with it. */
static bool text_follows(const struct host_demux *demux)
{
    return demux->count == demux->end && cds_ring_count(demux->input) &&
           input_peek(demux->input, 0) != CDS_HEADER;
}

static void take_following(struct host_demux *demux)
{
    bool late;
    uint8_t byte = next_byte(demux, &late);

    if (byte == STOP)
        drop_late(
            demux); // or a release that was said before the stop would be carried out after it
    take_text(demux, byte);
}

static void work(struct host_demux *demux)
{
    uint8_t left = demux->stale ? STALE_PER_POLL : BYTES_PER_POLL;

    while (!demux->whole || text_follows(demux)) {
        uint8_t done = 1;

        if (demux->whole)
            take_following(demux);
        else if (demux->seen < demux->count && demux->end)
            done = examine_counted(demux);
        else if (demux->seen < demux->count)
            examine(demux);
        else if (demux->stale)
            refute(demux); // no end of a packet will come: before another byte is taken
        else if (cds_ring_count(demux->input) == 0)
            break;
        else if (demux->end)
            done = take_counted(demux);
        else
            take_byte(demux);
        if (done >= left)
            break;
        left = (uint8_t)(left - done);
    }
}

/* One mark is enough where nothing was heard since the last: each costs the console a line. */
static bool mark_lost(struct cds_ring *text)
{
    if (cds_ring_count(text) &&
        text->bytes[(text->head - 1u) & (CDS_RING_SIZE - 1)] == HOST_MARK_LOST)
        return true;
    return cds_ring_put(text, HOST_MARK_LOST);
}

/* When did the host say something last, and how long has the packet waited for the bridge? Behind a
 * packet that has waited for too long, all that came meanwhile is too old for a packet. */
static void watch_time(struct host_demux *demux)
{
    uint8_t head = demux->input->head;

    if (head != demux->head) {
        demux->head = head;
        demux->heard_us = cds_port_now_us();
    }
    if (demux->whole && cds_port_now_us() - demux->whole_us >= HOST_SILENCE_US) {
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
        mark_lost(demux->text)) { // the line's end may be lost, too
        demux->lost = false;
        demux->typing = false;
    }
    work(demux);
    if (tail != demux->input->tail)
        return demux->end && !demux->whole;
    if (!demux->whole && demux->seen == demux->count)
        listen(demux);
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
    demux->whole = false;
    if (demux->count && other[0] != CDS_HEADER)
        refute(demux); // what was within a broken packet is no text
    return packet;
}

bool host_demux_idle(const struct host_demux *demux)
{
    return !demux->whole && !is_open(demux) && !demux->lost && !demux->skipping &&
           cds_ring_count(demux->input) == 0;
}
