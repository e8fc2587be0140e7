/* SPDX-License-Identifier: MIT */
#include "oracle.h"

#include <string.h>

enum { HEADER = 0xFF, ALL = 0xFE, ID_MAX = 0xFD, REFUSALS = 0x5A, NO_SUCH_ERROR = 0x80 };
enum { LONGEST = 60 }; // highest LENGTH of a packet while no reply is awaited

static bool sum_is_right(const uint8_t *packet, unsigned size)
{
    unsigned sum = 0;
    for (unsigned i = 2; i < size; i++) {
        sum += packet[i];
    }
    return (sum & 0xFF) == 0xFF;
}

static bool is_reply(const struct oracle_asked *asked, const uint8_t *packet, int parameters)
{
    uint8_t to = asked->packet[2], from = packet[2], error = packet[4];
    bool id_fits = to == ALL ? from <= ID_MAX : from == to;
    bool refusal = parameters == 0 && (error & REFUSALS);
    return id_fits && !(error & NO_SUCH_ERROR) && (parameters == asked->due || refusal);
}

struct search {
    const struct oracle_span *span;
    struct oracle_result *result;
    unsigned examined; // highest index of the bytes that were examined
    bool replied, damaged;
};

static bool expects_reply(const struct oracle_span *span)
{
    return span->asked && span->asked->due >= 0;
}

/* Returns true if the reply was still awaited when the newest byte was examined. */
static bool awaits_reply(const struct search *search)
{
    return expects_reply(search->span) && !search->replied &&
           search->examined < search->span->in_time;
}

static void examine(struct search *search, unsigned index)
{
    search->examined = index > search->examined ? index : search->examined;
}

/* Counts a good packet that is not the reply. */
static void count_unexpected(struct search *search, uint8_t id)
{
    const struct oracle_span *span = search->span;
    bool over = expects_reply(span) && !awaits_reply(search);
    uint8_t last_id = over ? span->asked->packet[2] : span->last_id;
    bool answered = over ? search->replied : span->last_ok;
    if (last_id != id && last_id != ALL) {
        search->result->unexpected_packets++;
    } else if (answered) {
        search->result->duplicate_replies++;
    } else {
        search->result->stale_replies++;
    }
}

static void take(struct search *search, const uint8_t *packet, unsigned length)
{
    struct oracle_result *result = search->result;
    result->id = packet[2];
    result->error = packet[4];
    result->length = length - 2;
    memcpy(result->data, packet + 5, length - 2);
    result->taken = search->examined + 1;
    search->replied = true;
}

/* Returns how many bytes of a header the bytes begin with: 0 to 2. */
static unsigned header(const uint8_t *bytes, unsigned count)
{
    unsigned begun = 0;
    while (begun < 2 && begun < count && bytes[begun] == HEADER) {
        begun++;
    }
    return begun;
}

/* Searches undamaged bytes for packets. `first`: index of the first byte in the span. */
static void predict_undamaged(struct search *search, const uint8_t *bytes, unsigned count,
                              unsigned first)
{
    for (unsigned at = 0; at < count;) {
        const uint8_t *packet = bytes + at;
        unsigned begun = header(packet, count - at);
        if (begun < 2 && at + begun < count) {
            search->result->noise_bytes++;
            at += begun + 1;
            continue;
        }
        if (at + 2 < count && packet[2] == HEADER) {
            at++;
            continue;
        }
        if (at + 3 >= count) {
            return;
        }
        examine(search, first + at + 3);
        unsigned length = packet[3], size = 4 + length;
        unsigned longest = awaits_reply(search) ? (unsigned)search->span->asked->due + 2 : LONGEST;
        bool possible = length >= 2 && length <= longest;
        if (possible && at + size > count) {
            return; // the packet is not complete yet
        }
        if (possible) {
            examine(search, first + at + size - 1);
        }
        if (!possible || !sum_is_right(packet, size)) {
            search->result->malformed++;
            search->damaged |= awaits_reply(search);
            at++;
            continue;
        }
        if (awaits_reply(search) && is_reply(search->span->asked, packet, (int)length - 2)) {
            take(search, packet, length);
        } else {
            count_unexpected(search, packet[2]);
        }
        at += size;
    }
}

void oracle_predict(const struct oracle_span *span, struct oracle_result *result)
{
    static uint8_t whole[65536];
    struct search search = {.span = span, .result = result};
    unsigned first = 0;
    *result = (struct oracle_result){.id = span->asked ? span->asked->packet[2] : 0};
    for (unsigned i = 0; i <= span->count; i++) {
        if (i < span->count && !span->bytes[i].bad) {
            whole[i - first] = span->bytes[i].byte;
            continue;
        }
        predict_undamaged(&search, whole, i - first, first);
        examine(&search, i);
        search.damaged |= i < span->count && awaits_reply(&search);
        first = i + 1;
    }
    result->result = search.replied || !expects_reply(span) ? CDS_OK
                     : search.damaged                       ? CDS_CORRUPT
                                                            : CDS_TIMEOUT;
}

void oracle_reply(const struct oracle_asked *asked, const struct oracle_byte *bytes, unsigned count,
                  struct oracle_result *result)
{
    struct oracle_span span = {
        .asked = asked, .bytes = bytes, .count = count, .in_time = count, .last_id = HEADER};
    oracle_predict(&span, result);
}

static bool changes_a_servo(uint8_t instruction)
{
    return (instruction >= 3 && instruction <= 6) || instruction == 0x83; // WRITE to RESET
}

bool oracle_commands(const struct oracle_asked *asked, const struct oracle_byte *bytes,
                     unsigned count)
{
    for (unsigned at = 0; at + 5 < count; at++) {
        uint8_t packet[258];
        unsigned size = 4u + bytes[at + 3].byte;
        bool whole = at + size <= count && size >= 6 && size <= sizeof(packet);
        for (unsigned i = 0; whole && i < size; i++) {
            packet[i] = bytes[at + i].byte;
            whole = !bytes[at + i].bad;
        }
        if (whole && packet[0] == HEADER && packet[1] == HEADER && packet[2] != HEADER &&
            sum_is_right(packet, size) && changes_a_servo(packet[4]) &&
            (size != asked->size || memcmp(packet, asked->packet, size) != 0)) {
            return true;
        }
    }
    return false;
}

unsigned oracle_receive(const bool *level, unsigned bits, struct oracle_byte *bytes)
{
    unsigned count = 0;
    for (unsigned at = 0; at < bits;) {
        if (level[at] || (at > 0 && !level[at - 1])) { // a frame begins with a falling edge
            at++;
            continue;
        }
        unsigned frame = 0;
        for (unsigned bit = 0; bit < 10; bit++) {
            frame |= (unsigned)(at + bit >= bits || level[at + bit]) << bit;
        }
        bytes[count++] = (struct oracle_byte){(uint8_t)(frame >> 1), !(frame & 0x200)};
        at += 10;
    }
    return count;
}

void oracle_send(const uint8_t *bytes, unsigned size, bool *level)
{
    for (unsigned bit = 0; bit < size * 10; bit++) {
        unsigned frame = 0x200u | bytes[bit / 10] * 2u;
        level[bit] = frame >> bit % 10 & 1;
    }
}

unsigned oracle_packet(uint8_t *packet, uint8_t id, uint8_t instruction_or_error,
                       const uint8_t *parameters, unsigned count)
{
    unsigned sum = 0;
    packet[0] = packet[1] = HEADER;
    packet[2] = id;
    packet[3] = (uint8_t)(count + 2);
    packet[4] = instruction_or_error;
    if (count) {
        memcpy(packet + 5, parameters, count);
    }
    for (unsigned i = 2; i < 5 + count; i++) {
        sum += packet[i];
    }
    packet[5 + count] = (uint8_t)~sum;
    return 6 + count;
}
