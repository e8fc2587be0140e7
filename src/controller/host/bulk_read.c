/* SYNC READ and BULK READ; see gather.h. */
#include "host/bulk_read.h"

#include <string.h>

#include "host/status_packet.h"
#include "compiler.h" // NOINLINE, OPTIMIZER_BARRIER()

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
    if (left > DATA_MAX)
        return false;
    for (; left >= BULK_ITEM; left = (uint8_t)(left - BULK_ITEM)) {
        if (item[1] > CDS_ID_MAX)
            return false;
        item += BULK_ITEM;
        servos++;
    }
    gather->left = servos;
    return left == 0 && servos;
}

/* Makes a READ of the next servo, there being one. Its result: CDS_OK if it is to be sent;
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
    cds_packet_begin(&read->packet, id, CDS_READ);
    cds_packet_put(&read->packet, address);
    cds_packet_put(&read->packet, count);
    cds_packet_end(&read->packet);
    read->id = id;
    read->reply_parameters = count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
    read->result = CDS_OK;
    if (id == gather->device_id) {
        read->result = CDS_PENDING;
        memcpy(read->reply, read->packet.bytes, CDS_PACKET_SIZE(2));
    } else if (id > CDS_ID_MAX) {
        read->result = CDS_BAD_ARGUMENT;
    }
}

/* Of a SYNC READ, and of a servo that failed. Apart: a BULK READ that goes well shall not save
 * registers for it. */
NOINLINE static void keep(struct gather *gather, const struct cds_request *read)
{
    uint8_t each = gather->each;
    bool good = read->result == CDS_OK && read->length == each;

    if (!good)
        device_note_failure(gather->device, read->id);
    if (gather->bulk)
        return;
    if (good) {
        memcpy(gather->to, read->reply, each);
    } else {
        memset(gather->to, MISSING, each);
        gather->error = GATHER_ERROR_FAILED;
    }
    gather->to += each;
}

/* What has come of the READ that has ended; not yet, if the host has no room. */
static void hand_over(struct gather *gather)
{
    const struct cds_request *read = gather->spare;

    if (!gather->bulk || read->result != CDS_OK)
        keep(gather, read);
    else if (!answer_at_once(gather->output, read->id, read->error, read->reply, read->length))
        return;
    gather->other = GATHER_SPENT;
}

/* There is nothing to hand over: the READ after the one that is asked is built. */
static void prepare(struct gather *gather)
{
    const struct cds_request *asked = gather->asked;
    bool waits = asked->result == CDS_PENDING && asked->id != gather->device_id;

    gather->other = waits ? GATHER_WAITS : GATHER_READY;
    if (gather->left > 1)
        build(gather, gather->spare);
}

/* The servo asked has ended. In a BULK READ the others would wait in vain for one that failed. */
static void go_on(struct gather *gather)
{
    struct cds_request *ended = gather->asked, *next = gather->spare;

    gather->asked = next;
    gather->spare = ended;
    gather->other = GATHER_ENDED;
    gather->left--;
    if (gather->bulk && ended->result != CDS_OK)
        gather->left = 0;
    if (gather->left && next->result == CDS_OK)
        cds_bus_submit(gather->bus, next); // next->result says why, if it is refused
    hand_over(gather);                     // while the next one is asked
}

/* If the host has not taken the reply before this one, gather_poll() goes on. */
static void on_end(struct cds_request *ended)
{
    struct gather *gather = ended->context;

    if (gather->other == GATHER_WAITS)
        go_on(gather);
}

void gather_open(struct gather *gather, struct cds_bus *bus, struct device *device,
                 struct cds_ring *output)
{
    OPTIMIZER_BARRIER(gather);
    *gather = (struct gather){.bus = bus, .device = device, .output = output};
    for (uint8_t i = 0; i < 2; i++) {
        gather->read[i].packet.bytes = gather->packets[i];
        gather->read[i].packet.capacity = sizeof gather->packets[i];
        gather->read[i].reply = gather->replies[i];
        gather->read[i].reply_capacity = sizeof gather->replies[i];
        gather->read[i].on_end = on_end;
        gather->read[i].context = gather;
    }
}

bool gather_begin(struct gather *gather, uint8_t device_id, uint8_t *packet)
{
    bool sense = true;

    OPTIMIZER_BARRIER(gather);
    gather->device_id = device_id;
    gather->asked = gather->read;
    gather->spare = gather->read + 1;
    gather->other = GATHER_SPENT;
    if (packet[CDS_AT_INSTRUCTION] == GATHER_SYNC_READ)
        begin_sync(gather, packet);
    else
        sense = begin_bulk(gather, packet);
    if (sense && gather->left) {
        build(gather, gather->asked);
        if (gather->asked->result == CDS_OK)
            cds_bus_submit(gather->bus, gather->asked);
    }
    device_forget_failures(gather->device); // while the first servo is asked
    return sense;
}

/* The device's own answer is no longer than a servo's. */
static void obey(struct gather *gather, struct cds_request *read)
{
    struct device *device = gather->device;

    if (read->reply_parameters == 0) {
        read->error = CDS_ERROR_RANGE;
        read->length = 0;
    } else if (device_obey(device, read->reply)) {
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
    else if (asked->result == CDS_BUSY) // an operation held the bus
        cds_bus_submit(gather->bus, asked);
    if (asked->result != CDS_PENDING)
        go_on(gather);
}

enum gather_turn gather_poll(struct gather *gather)
{
    switch (gather->other) {
    case GATHER_ENDED: hand_over(gather); break;
    case GATHER_SPENT: prepare(gather); break;
    default:
        if (!gather->left)
            return gather->bulk ? GATHER_DONE : GATHER_ANSWER;
        look_after(gather);
    }
    return GATHER_MORE;
}
