/* Packets and text on the host link; see host.h. */
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

void host_open(struct host *host, struct cds_ring *input, struct cds_ring *text, uint8_t *bytes)
{
    OPTIMIZER_BARRIER(host);
    *host = (struct host){.input = input, .text = text, .bytes = bytes};
}

static bool is_open(const struct host *host)
{
    return host->count != 0;
}

/* False: there is no room for it. */
static bool put(struct host *host, uint8_t byte)
{
    if (host->lost) {
        if (!cds_ring_put(host->text, HOST_MARK_LOST))
            return false;
        host->lost = false;
        host->typing = false;
    }
    return cds_ring_put(host->text, byte);
}

#define STOP 0x18 // Ctrl-X

static bool ends_line(uint8_t byte)
{
    return byte == '\r' || byte == '\n';
}

/* A Ctrl-X that is no part of a good packet. */
static void find_stop(struct host *host, uint8_t byte, bool damaged)
{
    if (byte != STOP)
        return;
    host->stop = true;
    if (damaged)
        host->counters.stops++;
}

static void take_text(struct host *host, uint8_t byte)
{
    find_stop(host, byte, host->suspect);
    if (host->skipping) {
        host->skipping = !ends_line(byte);
    } else if (byte != HOST_MARK_DROPPED && byte != HOST_MARK_LOST) {
        if (!put(host, byte))
            host_gap(host);
        else
            host->typing = !ends_line(byte);
        host->suspect = host->suspect && host->typing;
    }
}

/* What was typed of this line is gone. */
static void drop_line(struct host *host)
{
    if (!host->typing)
        return;
    if (put(host, HOST_MARK_DROPPED))
        host->typing = false;
    else
        host->lost = true; // there is half a line in the ring, which must not be joined
}

/* Nothing stands there, or, if `count` is 1, a 0xFF. */
static void restart(struct host *host, uint16_t count)
{
    host->bytes[0] = CDS_HEADER;
    host->from = host->end = 0;
    host->count = host->seen = count;
    host->stale = host->searched_again = false;
}

/* 0xFF: a packet may begin. */
static void begin(struct host *host, bool late)
{
    host->skipping = false;
    host->late = late;
    host->begun_us = cds_port_now_us();
    restart(host, 1);
    drop_line(host);
}

/* What stands at `from` begins no packet: the search goes on behind its first byte. The bytes up to
 * the next 0xFF are no part of a packet. */
static void refute(struct host *host)
{
    uint16_t from = host->from;

    do {
        find_stop(host, host->bytes[from], true);
        from++;
    } while (from < host->count && host->bytes[from] != CDS_HEADER);
    host->from = from;
    host->seen = (uint16_t)(from + 1);
    host->end = 0;
    if (host->seen >= host->count)
        restart(host, from < host->count);
    else
        host->searched_again = true;
}

/* Something is lost behind all that was taken. The bytes of a packet that has begun are searched
 * for a stop only; a packet that waits for the bridge is not concerned. */
NOINLINE void host_gap(struct host *host)
{
    host->counters.gaps++;
    host->stale = is_open(host);
    if (is_open(host) && !host->whole)
        refute(host);
    host->lost = true;
    host->skipping = true;
}

static void refute_counted(struct host *host)
{
    host->counters.broken++;
    host->suspect = true;
    refute(host);
}

static void move_to_front(struct host *host)
{
    uint16_t from = host->from;

    if (from == 0)
        return;
    memmove(host->bytes, host->bytes + from, (uint16_t)(host->count - from));
    host->count = (uint16_t)(host->count - from);
    host->seen = (uint16_t)(host->seen - from);
    if (host->end)
        host->end = (uint16_t)(host->end - from);
    host->from = 0;
}

/* Drops the good packet at `from`; what stands behind it is searched on. */
static void drop_late(struct host *host)
{
    host->counters.late++;
    host->whole = false;
    host->from = host->end;
    host->seen = (uint16_t)(host->from + 1);
    host->end = 0;
    if (host->from >= host->count)
        restart(host, 0);
    else if (host->bytes[host->from] != CDS_HEADER)
        refute(host);
}

/* The checksum was the last byte: all of the packet adds up to 0xFF. */
static void judge(struct host *host)
{
    uint32_t now_us = cds_port_now_us();

    if (host->sum != UINT8_MAX) {
        refute_counted(host);
        return;
    }
    if (host->stale || host->late ||
        (host->searched_again && now_us - host->begun_us >= HOST_SILENCE_US)) {
        drop_late(host);
        return;
    }
    host->counters.packets++;
    host->whole_us = now_us;
    host->whole = true;
}

/* Examines the next byte. */
static void examine(struct host *host)
{
    uint8_t byte = host->bytes[host->seen];
    uint16_t at = (uint16_t)(host->seen++ - host->from);

    host->sum = (uint8_t)(host->sum + byte);
    if (at == 1 && byte != CDS_HEADER) {
        bool lone = host->count == 2; // nothing but 0xFF came: this byte stands outside

        if (lone) {
            restart(host, 0);
            take_text(host, byte);
        } else {
            refute(host);
        }
    } else if (at == CDS_AT_ID) {
        host->sum = byte;
        if (byte == CDS_HEADER) // R27: still header; the last two of them count
            host->from++;
    } else if (at == CDS_AT_LENGTH) {
        host->end = (uint16_t)(host->seen + byte);
        if (byte < CDS_LENGTH_MIN || byte > CDS_LENGTH_MAX)
            refute_counted(host);
        else if (host->stale && host->end > host->count)
            refute(host); // its end will not come
    }
}

/* LENGTH is known: adds up as many of the bytes that it counts as stand there already. */
static uint8_t examine_counted(struct host *host)
{
    uint16_t to = host->end < host->count ? host->end : host->count;
    const uint8_t *from = host->bytes + host->seen;
    uint8_t sum = host->sum;
    uint8_t count = COUNTED_PER_POLL;

    if (count > to - host->seen)
        count = (uint8_t)(to - host->seen);
    for (uint8_t left = count; left; left--)
        sum = (uint8_t)(sum + *from++);
    host->sum = sum;
    host->seen = (uint16_t)(host->seen + count);
    if (host->seen == host->end)
        judge(host);
    return count;
}

/* The same, of those that are in the ring. The bulk of what the host says, at 160 cycles a byte and
 * more: here cycles count. */
static uint8_t take_counted(struct host *host)
{
    const volatile uint8_t *ring = host->input->bytes;
    uint8_t tail = host->input->tail, sum = host->sum;
    uint8_t count = cds_ring_count(host->input);
    uint8_t *to;

    if (host->end > HOST_PACKET_MAX)
        move_to_front(host);
    if (count > COUNTED_PER_POLL)
        count = COUNTED_PER_POLL;
    if (count > host->end - host->count)
        count = (uint8_t)(host->end - host->count);
    to = host->bytes + host->count;
    for (uint8_t left = count; left; left--) {
        uint8_t byte = ring[tail++ & (CDS_RING_SIZE - 1)];

        *to++ = byte;
        sum = (uint8_t)(sum + byte);
    }
    host->input->tail = tail; // behind the bytes
    host->old = host->old > count ? (uint8_t)(host->old - count) : 0;
    host->sum = sum;
    host->count = host->seen = (uint16_t)(host->count + count);
    if (host->count == host->end)
        judge(host);
    return count;
}

/* Takes a byte out of the input ring; *late: it came too long ago for a packet. */
static uint8_t next_byte(struct host *host, bool *late)
{
    uint8_t byte = input_peek(host->input, 0);

    input_drop(host->input, 1);
    *late = host->old != 0;
    if (*late)
        host->old--;
    return byte;
}

static void take_byte(struct host *host)
{
    bool late;
    uint8_t byte = next_byte(host, &late);

    if (is_open(host)) {
        if (host->count == HOST_PACKET_MAX)
            move_to_front(host);
        host->bytes[host->count++] = byte;
        examine(host);
    } else if (byte == CDS_HEADER) {
        begin(host, late);
    } else {
        take_text(host, byte);
    }
}

/* All that came was taken: for how long has the host been silent? */
static void listen(struct host *host)
{
    if (!is_open(host) && !host->skipping && !host->suspect)
        return;
    if (cds_port_now_us() - host->heard_us < HOST_SILENCE_US)
        return;
    host->skipping = false;
    if (host->suspect)
        drop_line(host);
    host->suspect = false;
    if (is_open(host)) {
        if (host->count > 1) // a lone 0xFF is no packet
            host->counters.silent++;
        host->stale = true;
        refute(host);
    }
}

/* Behind a packet that waits for its turn: Ctrl-X must not wait with it. */
static bool text_follows(const struct host *host)
{
    return host->count == host->end && cds_ring_count(host->input) &&
           input_peek(host->input, 0) != CDS_HEADER;
}

static void take_following(struct host *host)
{
    bool late;
    uint8_t byte = next_byte(host, &late);

    if (byte == STOP)
        drop_late(host); // or a release that was said before the stop would be carried out after it
    take_text(host, byte);
}

static void work(struct host *host)
{
    uint8_t left = host->stale ? STALE_PER_POLL : BYTES_PER_POLL;

    while (!host->whole || text_follows(host)) {
        uint8_t done = 1;

        if (host->whole)
            take_following(host);
        else if (host->seen < host->count && host->end)
            done = examine_counted(host);
        else if (host->seen < host->count)
            examine(host);
        else if (host->stale)
            refute(host); // no end of a packet will come: before another byte is taken
        else if (cds_ring_count(host->input) == 0)
            break;
        else if (host->end)
            done = take_counted(host);
        else
            take_byte(host);
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
static void watch_time(struct host *host)
{
    uint8_t head = host->input->head;

    if (head != host->head) {
        host->head = head;
        host->heard_us = cds_port_now_us();
    }
    if (host->whole && cds_port_now_us() - host->whole_us >= HOST_SILENCE_US) {
        host->old = cds_ring_count(host->input);
        drop_late(host);
    }
}

bool host_poll(struct host *host)
{
    uint8_t tail;

    OPTIMIZER_BARRIER(host);
    tail = host->input->tail;
    watch_time(host);
    if (host->lost && !host->skipping && mark_lost(host->text)) { // the line's end may be lost, too
        host->lost = false;
        host->typing = false;
    }
    work(host);
    if (tail != host->input->tail)
        return host->end && !host->whole;
    if (!host->whole && host->seen == host->count)
        listen(host);
    return false;
}

uint8_t *host_take(struct host *host, uint8_t *other)
{
    uint8_t *packet = host->bytes;
    uint16_t size;

    move_to_front(host);
    size = (uint16_t)(packet[CDS_AT_LENGTH] + CDS_AT_LENGTH + 1);
    host->count = (uint16_t)(host->count - size);
    memcpy(other, packet + size, host->count);
    host->bytes = other;
    host->seen = host->count ? 1 : 0;
    host->end = 0;
    host->whole = false;
    if (host->count && other[0] != CDS_HEADER)
        refute(host); // what was within a broken packet is no text
    return packet;
}

bool host_idle(const struct host *host)
{
    return !host->whole && !is_open(host) && !host->lost && !host->skipping &&
           cds_ring_count(host->input) == 0;
}
