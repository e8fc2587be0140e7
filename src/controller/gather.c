/* SYNC READ and BULK READ; see gather.h. */
#include "gather.h"

#include <string.h>

#include "answer.h"
#include "opaque.h" // CDS_APART

#define PACKET_MAX (CDS_LENGTH_MAX + 4)
#define DATA_MAX   (CDS_LENGTH_MAX - CDS_LENGTH_MIN)
#define MISSING    UINT8_MAX // each byte of a servo that failed
#define BULK_ITEM  3         // length, ID, address

bool gather_knows(uint8_t device_id, uint8_t id, uint8_t instruction)
{
    bool to_all = id == CDS_BROADCAST_ID;

    return (instruction == GATHER_SYNC_READ && (to_all || id == device_id)) ||
           (instruction == GATHER_BULK_READ && to_all);
}

uint8_t gather_reply_due(const uint8_t *packet)
{
    uint8_t instruction = packet[CDS_AT_INSTRUCTION];
    uint8_t count = packet[CDS_AT_PARAMETERS + 1];

    if (packet[CDS_AT_ID] == CDS_BROADCAST_ID)
        return instruction == CDS_PING ? 0 : CDS_REPLY_NONE;
    if (instruction != CDS_READ || packet[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2)
        return 0;
    return count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
}

static void begin_sync(struct gather *gather, uint8_t *packet)
{
    uint8_t parameters = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t size;

    gather->to = packet;
    gather->bulk = false;
    gather->error = CDS_ERROR_RANGE;
    gather->length = 0;
    gather->left = 0;
    if (parameters < 3)
        return;
    gather->address = packet[CDS_AT_PARAMETERS];
    gather->each = packet[CDS_AT_PARAMETERS + 1];
    parameters = (uint8_t)(parameters - 2);
    size = (uint16_t)(gather->each * parameters);
    if (size == 0 || size > DATA_MAX)
        return;
    gather->error = 0;
    gather->left = parameters;
    gather->length = (uint8_t)size;
    /* The IDs give way to the data, which grow faster than IDs are used up: from the other end. */
    gather->next =
        memmove(packet + PACKET_MAX - parameters, packet + CDS_AT_PARAMETERS + 2, parameters);
}

static bool begin_bulk(struct gather *gather, const uint8_t *packet)
{
    uint8_t left = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 1);
    const uint8_t *item = packet + CDS_AT_PARAMETERS + 1;
    uint8_t servos = 0;

    gather->bulk = true;
    gather->next = item;
    for (; left >= BULK_ITEM && left <= DATA_MAX; left = (uint8_t)(left - BULK_ITEM)) {
        if (item[1] > CDS_ID_MAX)
            return false;
        item += BULK_ITEM;
        servos++;
    }
    gather->left = servos;
    return left == 0 && servos;
}

static struct cds_request *other_of(struct gather *gather)
{
    return gather->asked == gather->read ? &gather->read[1] : gather->read;
}

/* Makes a READ of the next servo, there being one. Its result: CDS_OK if it may be sent;
 * CDS_PENDING if the device itself is asked, and nothing is sent. */
static void build(struct gather *gather, struct cds_request *read)
{
    const uint8_t *next = gather->next;
    uint8_t id = next[0], address = gather->address, count = gather->each;

    gather->next = next + 1;
    if (gather->bulk) {
        gather->next = next + BULK_ITEM;
        id = next[1];
        address = next[2];
        count = next[0];
    }
    cds_packet_build_read_(&read->packet, id, address, count);
    read->id = id;
    read->reply_parameters = count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
    read->repeats = gather->bus->repeats;
    read->return_delay_us = gather->bus->return_delay_us;
    read->result = CDS_OK;
    if (id == gather->device_id)
        read->result = CDS_PENDING;
    else if (id > CDS_ID_MAX)
        read->result = CDS_BAD_ARGUMENT;
    else
        read->result = cds_bus_judge_(gather->bus, read);
}

/* Sends it, so that its first byte is out as soon as may be. It was judged when it was built; if
 * others wait, it is judged again in its turn. */
static void send(struct cds_bus *bus, struct cds_request *read)
{
    struct cds_bus_observer *observer = bus->observer;
    uint16_t return_delay_us = read->return_delay_us;
    enum cds_result result;

    if (read->result != CDS_OK)
        return;
    if (!bus->request)
        bus->observer = NULL;
    result = cds_bus_submit(bus, read);
    bus->observer = observer;
    read->return_delay_us = return_delay_us;
    if (result != CDS_OK)
        read->result = (uint8_t)result;
}

/* Of a SYNC READ, and of a servo that failed. Apart: a BULK READ that goes well shall not save
 * registers for it. */
CDS_APART static void keep(struct gather *gather, const struct cds_request *read)
{
    uint8_t each = gather->each;
    bool good = read->result == CDS_OK && read->length == each;

    if (!good)
        device_note_failure(gather->device, read->id);
    if (gather->bulk)
        return;
    if (good) {
        memcpy(gather->to, read->packet.bytes, each);
    } else {
        memset(gather->to, MISSING, each);
        gather->error = GATHER_ERROR_FAILED;
    }
    gather->to += each;
}

/* What has come of the READ that has ended; not yet, if the host has no room. */
static void hand_over(struct gather *gather)
{
    const struct cds_request *read = other_of(gather);

    if (!gather->bulk || read->result != CDS_OK)
        keep(gather, read);
    else if (!answer_at_once(gather->output, read->id, read->error, read->packet.bytes,
                             read->length))
        return;
    gather->other = GATHER_SPENT;
}

/* The servo asked has ended: the next one is asked before anything else, unless the host has not
 * taken the reply before this one yet. In a BULK READ the others would wait in vain for one that
 * failed. */
static void go_on(struct gather *gather)
{
    struct cds_request *ended = gather->asked, *next = other_of(gather);

    if (gather->other != GATHER_READY)
        return;
    gather->asked = next;
    gather->other = GATHER_ENDED;
    gather->left--;
    if (gather->bulk && ended->result != CDS_OK)
        gather->left = 0;
    if (gather->left)
        send(gather->bus, next);
    hand_over(gather); // while the next one is asked
}

static void on_end(struct cds_request *ended)
{
    go_on(ended->owner);
}

void gather_open(struct gather *gather, struct cds_bus *bus, struct device *device,
                 struct cds_ring *output)
{
    *gather = (struct gather){.bus = bus, .device = device, .output = output};
    for (uint8_t i = 0; i < 2; i++) {
        gather->read[i].packet.bytes = gather->bytes[i];
        gather->read[i].packet.room = CDS_REPLY_MAX;
        gather->read[i].on_end = on_end;
        gather->read[i].owner = gather;
    }
}

bool gather_begin(struct gather *gather, uint8_t device_id, uint8_t *packet)
{
    gather->device_id = device_id;
    gather->asked = gather->read;
    gather->other = GATHER_SPENT;
    device_forget_failures(gather->device);
    if (packet[CDS_AT_INSTRUCTION] == GATHER_SYNC_READ)
        begin_sync(gather, packet);
    else if (!begin_bulk(gather, packet))
        return false;
    if (gather->left) {
        build(gather, gather->asked);
        send(gather->bus, gather->asked);
    }
    return true;
}

/* The device's own answer is no longer than a servo's. */
static void obey(struct gather *gather, struct cds_request *read)
{
    struct device *device = gather->device;

    if (read->reply_parameters == 0) {
        read->error = CDS_ERROR_RANGE;
        read->length = 0;
    } else if (device_obey(device, read->packet.bytes)) {
        read->error = device->error;
        read->length = device->length;
    } else {
        return;
    }
    read->result = CDS_OK;
}

/* The servo asked, unless its end is seen to by the bus. */
static void look_after(struct gather *gather)
{
    struct cds_request *asked = gather->asked;

    if (asked->result == CDS_PENDING && asked->id == gather->device_id)
        obey(gather, asked);
    if (asked->result != CDS_PENDING)
        go_on(gather);
}

enum gather_turn gather_poll(struct gather *gather)
{
    switch (gather->other) {
    case GATHER_ENDED: hand_over(gather); break;
    case GATHER_SPENT:
        if (gather->left > 1)
            build(gather, other_of(gather));
        gather->other = GATHER_READY;
        break;
    default:
        if (!gather->left)
            return gather->bulk ? GATHER_DONE : GATHER_ANSWER;
        look_after(gather);
    }
    return GATHER_MORE;
}
