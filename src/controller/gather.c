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
        gather->read[i].packet.room = CDS_REPLY_MAX;
    }
}

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

    gather->bulk = true;
    gather->next = item;
    gather->left = 0;
    for (; left >= BULK_ITEM && left <= DATA_MAX; left = (uint8_t)(left - BULK_ITEM)) {
        if (item[1] > CDS_ID_MAX)
            return false;
        item += BULK_ITEM;
        gather->left++;
    }
    return left == 0 && gather->left;
}

/* A READ, put together by hand: what takes long here is missing between two packets of the bus. */
static void build_read(struct cds_request *read, uint8_t id, uint8_t address, uint8_t count)
{
    uint8_t *bytes = read->packet.bytes;

    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = read->id = id;
    *bytes++ = CDS_LENGTH_MIN + 2;
    *bytes++ = CDS_READ;
    *bytes++ = address;
    *bytes++ = count;
    *bytes = (uint8_t) ~(id + CDS_LENGTH_MIN + 2 + CDS_READ + address + count);
    read->packet.size = CDS_PACKET_SIZE(2);
    read->reply_parameters = count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
}

/* Sends the READ of the next servo. */
static void ask(struct gather *gather)
{
    struct cds_request *read = gather->asked == gather->read ? &gather->read[1] : gather->read;
    const uint8_t *next = gather->next;
    enum cds_result result = CDS_BAD_ARGUMENT;

    gather->asked = read;
    if (gather->bulk) {
        gather->next = next + BULK_ITEM;
        build_read(read, next[1], next[2], next[0]);
    } else {
        gather->next = next + 1;
        build_read(read, next[0], gather->address, gather->each);
    }
    read->repeats = gather->bus->repeats;
    if (read->id == gather->device_id) // nothing is sent
        result = CDS_PENDING;
    else if (read->id <= CDS_ID_MAX)
        result = cds_bus_submit(gather->bus, read);
    if (result != CDS_OK)
        read->result = (uint8_t)result;
}

bool gather_begin(struct gather *gather, uint8_t device_id, uint8_t *packet)
{
    gather->device_id = device_id;
    gather->sending = false;
    device_forget_failures(gather->device);
    if (packet[CDS_AT_INSTRUCTION] == GATHER_SYNC_READ)
        begin_sync(gather, packet);
    else if (!begin_bulk(gather, packet))
        return false;
    if (gather->left)
        ask(gather);
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

/* Of a SYNC READ. */
static void keep(struct gather *gather, const struct cds_request *read)
{
    uint8_t each = gather->each;

    if (read->result == CDS_OK && read->length == each) {
        memcpy(gather->to, read->packet.bytes, each);
    } else {
        memset(gather->to, MISSING, each);
        gather->error = GATHER_ERROR_FAILED;
        device_note_failure(gather->device, read->id);
    }
    gather->to += each;
}

static void send_on(struct gather *gather)
{
    gather->sending = !answer_put(&gather->out, gather->output);
}

/* Of a BULK READ. */
static void hand_over(struct gather *gather, const struct cds_request *read)
{
    answer_begin(&gather->out, read->id, read->error, read->packet.bytes, read->length);
    send_on(gather);
}

/* When the servo that is asked has answered, the next one is asked first of all. */
static void go_on(struct gather *gather)
{
    struct cds_request *read = gather->asked;

    if (read->result == CDS_PENDING && read->id == gather->device_id)
        obey(gather, read);
    if (read->result == CDS_PENDING)
        return;
    gather->left--;
    if (!gather->bulk) {
        keep(gather, read);
    } else if (read->result != CDS_OK) {
        device_note_failure(gather->device, read->id);
        gather->left = 0; // the others wait for it in vain
        return;
    }
    if (gather->left)
        ask(gather);
    if (gather->bulk)
        hand_over(gather, read);
}

enum gather_turn gather_poll(struct gather *gather)
{
    if (gather->sending)
        send_on(gather);
    else if (gather->left)
        go_on(gather);
    if (gather->sending || gather->left)
        return GATHER_MORE;
    return gather->bulk ? GATHER_DONE : GATHER_ANSWER;
}

bool gather_talks(const struct gather *gather)
{
    return gather->sending;
}
