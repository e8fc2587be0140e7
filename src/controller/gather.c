/* SYNC READ and BULK READ; see gather.h. */
#include "gather.h"

#include <string.h>

#define PACKET_MAX (CDS_LENGTH_MAX + 4)
#define DATA_MAX   (CDS_LENGTH_MAX - CDS_LENGTH_MIN)
#define MISSING    UINT8_MAX // each byte of a servo that failed
#define BULK_ITEM  3         // length, ID, address

void gather_open(struct gather *gather, struct cds_bus *bus, struct device *device,
                 struct cds_ring *output)
{
    *gather = (struct gather){.bus = bus, .device = device, .output = output};
    for (uint8_t i = 0; i < 2; i++) {
        gather->read[i].packet.bytes = gather->bytes[i] + ANSWER_BEFORE;
        gather->read[i].packet.room = CDS_REPLY_ANY;
        gather->read[i].any_length = true;
    }
}

bool gather_knows(const struct device *device, uint8_t id, uint8_t instruction)
{
    bool to_all = id == CDS_BROADCAST_ID;

    return (instruction == GATHER_SYNC_READ && (to_all || id == device_id(device))) ||
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

static bool begin_sync(struct gather *gather, uint8_t *packet)
{
    uint8_t parameters = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t size;

    gather->data = packet;
    gather->bulk = false;
    gather->error = CDS_ERROR_RANGE;
    gather->length = 0;
    gather->count = 0;
    if (parameters < 3)
        return true;
    gather->address = packet[CDS_AT_PARAMETERS];
    gather->each = packet[CDS_AT_PARAMETERS + 1];
    parameters = (uint8_t)(parameters - 2);
    size = (uint16_t)(gather->each * parameters);
    if (size == 0 || size > DATA_MAX)
        return true;
    gather->error = 0;
    gather->count = parameters;
    gather->length = (uint8_t)size;
    /* The IDs give way to the data, which grow faster than IDs are used up: from the other end. */
    gather->list =
        memmove(packet + PACKET_MAX - parameters, packet + CDS_AT_PARAMETERS + 2, parameters);
    return true;
}

static bool begin_bulk(struct gather *gather, const uint8_t *packet)
{
    uint8_t parameters = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN);

    gather->bulk = true;
    gather->list = packet + CDS_AT_PARAMETERS + 1;
    gather->count = (uint8_t)((parameters - 1u) / BULK_ITEM);
    if (parameters < 1 + BULK_ITEM || parameters != 1 + gather->count * BULK_ITEM)
        return false;
    for (uint8_t i = 0; i < gather->count; i++)
        if (gather->list[BULK_ITEM * i + 1] > CDS_ID_MAX)
            return false;
    return true;
}

bool gather_begin(struct gather *gather, uint8_t *packet)
{
    gather->device_id = device_id(gather->device);
    gather->asked = gather->done = 0;
    gather->failed = gather->sending = false;
    device_forget_failures(gather->device);
    if (packet[CDS_AT_INSTRUCTION] == GATHER_SYNC_READ)
        return begin_sync(gather, packet);
    return begin_bulk(gather, packet);
}

static uint8_t id_of(const struct gather *gather, uint8_t index)
{
    return gather->list[gather->bulk ? BULK_ITEM * index + 1 : index];
}

/* A READ, put together by hand: what takes long here is missing between two packets of the bus. */
static void build_read(struct cds_request *read, uint8_t id, uint8_t address, uint8_t count)
{
    uint8_t *bytes = read->packet.bytes;

    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = id;
    *bytes++ = CDS_LENGTH_MIN + 2;
    *bytes++ = CDS_READ;
    *bytes++ = address;
    *bytes++ = count;
    *bytes = (uint8_t) ~(id + CDS_LENGTH_MIN + 2 + CDS_READ + address + count);
    read->packet.size = CDS_PACKET_SIZE(2);
    read->reply_parameters = count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
}

/* Sends the READ of the next servo. The device's own is answered when its turn comes. */
static void ask(struct gather *gather)
{
    uint8_t index = gather->asked++, slot = index & 1, id = id_of(gather, index);
    struct cds_request *read = &gather->read[slot];
    enum cds_result result = CDS_BAD_ARGUMENT;

    if (gather->bulk) {
        const uint8_t *item = &gather->list[BULK_ITEM * index];

        build_read(read, id, item[2], item[0]);
    } else {
        build_read(read, id, gather->address, gather->each);
    }
    gather->local[slot] = id == gather->device_id;
    read->repeats = gather->bus->repeats;
    if (gather->local[slot])
        result = CDS_PENDING;
    else if (id <= CDS_ID_MAX)
        result = cds_bus_submit(gather->bus, read);
    if (result != CDS_OK)
        read->result = (uint8_t)result;
}

/* The device's own answer is no longer than a servo's. */
static void obey(struct gather *gather, struct cds_request *read)
{
    struct device *device = gather->device;

    read->id = gather->device_id;
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

static void note_failure(struct gather *gather)
{
    device_note_failure(gather->device, id_of(gather, gather->done));
    gather->failed = gather->bulk;
}

static void keep(struct gather *gather, const struct cds_request *read)
{
    uint8_t *to = gather->data + gather->done * gather->each;

    if (read->result == CDS_OK && read->length == gather->each) {
        memcpy(to, read->packet.bytes, gather->each);
    } else {
        memset(to, MISSING, gather->each);
        gather->error = GATHER_ERROR_FAILED;
        note_failure(gather);
    }
    gather->done++;
}

static void send_on(struct gather *gather)
{
    gather->sending = !answer_put(&gather->out, gather->output);
    if (!gather->sending)
        gather->done++;
}

static void hand_over(struct gather *gather, const struct cds_request *read)
{
    if (read->result == CDS_OK) {
        answer_begin(&gather->out, read->id, read->error, read->packet.bytes, read->length);
        send_on(gather);
    } else {
        note_failure(gather);
        gather->done++;
    }
}

/* What was asked ahead is waited for, and is nobody's any more. */
static void give_up(struct gather *gather)
{
    if (gather->done == gather->asked) {
        gather->count = gather->done;
    } else {
        uint8_t slot = gather->done & 1;

        if (gather->local[slot])
            gather->read[slot].result = CDS_CANCELLED;
        if (gather->read[slot].result != CDS_PENDING)
            gather->done++;
    }
}

/* The answer of the first one that was asked. */
static void await_next(struct gather *gather)
{
    uint8_t slot = gather->done & 1;
    struct cds_request *read = &gather->read[slot];

    if (gather->sending) {
        send_on(gather);
    } else if (read->result == CDS_PENDING) {
        if (gather->local[slot])
            obey(gather, read);
    } else if (gather->bulk) {
        hand_over(gather, read);
    } else {
        keep(gather, read);
    }
}

/* The next one is asked as soon as there is a place: not when the bus has become free already. */
static void go_on(struct gather *gather)
{
    if (gather->asked > gather->done)
        await_next(gather);
    if (!gather->failed && gather->asked < gather->count && gather->asked < gather->done + 2)
        ask(gather);
}

enum gather_turn gather_poll(struct gather *gather)
{
    if (gather->failed)
        give_up(gather);
    else if (gather->done < gather->count)
        go_on(gather);
    if (gather->done < gather->count)
        return GATHER_MORE;
    return gather->bulk ? GATHER_DONE : GATHER_ANSWER;
}

bool gather_talks(const struct gather *gather)
{
    return gather->sending;
}
