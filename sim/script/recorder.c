/* SPDX-License-Identifier: MIT */
#include "script/recorder.h"

#include <stdio.h>
#include <string.h>

static void edge(void *context, uint64_t now, bool level)
{
    (void)now;
    (void)level;
    struct recorder *recorder = context;
    recorder->edges++;
}

void recorder_init(struct recorder *recorder)
{
    *recorder = (struct recorder){0};
}

void recorder_watch(struct recorder *recorder, struct net *net)
{
    struct listener *listener = &recorder->sig[recorder->nets];
    *listener = (struct listener){.context = recorder, .on_level = edge};
    recorder->net[recorder->nets++] = net;
    net_listen(net, listener);
}

void recorder_clear(struct recorder *recorder)
{
    recorder->packets = recorder->next[0] = recorder->next[1] = 0;
    recorder->reply_size = 0;
    recorder->reply[0] = 0;
}

void recorder_add_packet(struct recorder *recorder, const struct transcript *transcript)
{
    if (recorder->packets == RECORDER_PACKETS) {
        return;
    }
    struct recorder_packet *packet = &recorder->packet[recorder->packets++];
    packet->in = transcript->packet_from_controller;
    packet->size = transcript->size;
    memcpy(packet->bytes, transcript->bytes, transcript->size);
    memcpy(packet->bad, transcript->bad, transcript->size * sizeof(packet->bad[0]));
}

void recorder_add_line(struct recorder *recorder, const char *line)
{
    size_t capacity = sizeof(recorder->reply) - recorder->reply_size;
    int size = snprintf(recorder->reply + recorder->reply_size, capacity, "%s\n", line);
    if (size > 0 && (size_t)size < capacity) {
        recorder->reply_size += (unsigned)size;
    }
}

static unsigned next_in(const struct recorder *recorder, bool in)
{
    unsigned next = recorder->next[in];
    while (next < recorder->packets && recorder->packet[next].in != in) {
        next++;
    }
    return next;
}

const struct recorder_packet *recorder_next_packet(const struct recorder *recorder, bool in)
{
    unsigned next = next_in(recorder, in);
    return next < recorder->packets ? &recorder->packet[next] : 0;
}

void recorder_take_packet(struct recorder *recorder, bool in)
{
    recorder->next[in] = next_in(recorder, in) + 1;
}

bool recorder_is_silent(const struct recorder *recorder, uint64_t edges)
{
    bool high = recorder->edges == edges;
    for (unsigned i = 0; i < recorder->nets; i++) {
        high = high && recorder->net[i]->level;
    }
    return high;
}
