#include "script/recorder.h"

#include <stdio.h>
#include <string.h>

static void edge(void *owner, uint64_t now, bool level)
{
    (void)now;
    (void)level;
    struct witness *witness = owner;
    witness->edges++;
}

void witness_init(struct witness *witness)
{
    *witness = (struct witness){0};
}

void witness_watch(struct witness *witness, struct net *net)
{
    struct listener *listener = &witness->sig[witness->nets];
    *listener = (struct listener){.owner = witness, .on_level = edge};
    witness->net[witness->nets++] = net;
    net_listen(net, listener);
}

void witness_forget(struct witness *witness)
{
    witness->packets = witness->next[0] = witness->next[1] = 0;
    witness->reply_size = 0;
    witness->reply[0] = 0;
}

void witness_packet(struct witness *witness, const struct transcript *transcript)
{
    if (witness->packets == WITNESS_PACKETS) {
        return;
    }
    struct witness_packet *packet = &witness->packet[witness->packets++];
    packet->in = transcript->of_controller;
    packet->size = transcript->size;
    memcpy(packet->bytes, transcript->bytes, transcript->size);
    memcpy(packet->bad, transcript->bad, transcript->size * sizeof(packet->bad[0]));
}

void witness_reply(struct witness *witness, const char *line)
{
    size_t room = sizeof(witness->reply) - witness->reply_size;
    int size = snprintf(witness->reply + witness->reply_size, room, "%s\n", line);
    if (size > 0 && (size_t)size < room) {
        witness->reply_size += (unsigned)size;
    }
}

static unsigned next_in(const struct witness *witness, bool in)
{
    unsigned next = witness->next[in];
    while (next < witness->packets && witness->packet[next].in != in) {
        next++;
    }
    return next;
}

const struct witness_packet *witness_next(const struct witness *witness, bool in)
{
    unsigned next = next_in(witness, in);
    return next < witness->packets ? &witness->packet[next] : 0;
}

void witness_take(struct witness *witness, bool in)
{
    witness->next[in] = next_in(witness, in) + 1;
}

bool witness_silence(const struct witness *witness, uint64_t edges)
{
    bool high = witness->edges == edges;
    for (unsigned i = 0; i < witness->nets; i++) {
        high = high && witness->net[i]->level;
    }
    return high;
}
