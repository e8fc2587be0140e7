/* SYNC READ and BULK READ; see bulk_read.h. */
#include "host/bulk_read.h"

#include <string.h>

#include "host/status_packet.h"
#include "compiler.h" // NOINLINE, OPTIMIZER_BARRIER()

#define PACKET_MAX (CDS_LENGTH_MAX + 4)
#define DATA_MAX   (CDS_LENGTH_MAX - CDS_LENGTH_MIN)
#define MISSING    UINT8_MAX // each byte of a servo that failed
#define BULK_ITEM  3         // length, ID, address

bool bulk_read_handles(uint8_t device_id, uint8_t id, uint8_t instruction)
{
    bool to_all = id == CDS_BROADCAST_ID;

    return (instruction == INSTRUCTION_SYNC_READ && (to_all || id == device_id)) ||
           (instruction == INSTRUCTION_BULK_READ && to_all);
}

uint8_t status_packet_due(const uint8_t *packet)
{
    uint8_t instruction = packet[CDS_AT_INSTRUCTION];
    uint8_t count = packet[CDS_AT_PARAMETERS + 1];

    if (packet[CDS_AT_ID] == CDS_BROADCAST_ID)
        return instruction == CDS_PING ? 0 : CDS_REPLY_NONE;
    if (instruction != CDS_READ || packet[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2)
        return 0;
    return count <= CDS_REPLY_MAX ? count : 0; // beyond it the servo refuses
}

static void begin_sync(struct bulk_read *bulk, uint8_t *packet)
{
    uint8_t parameters = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t size;

    bulk->to = packet;
    bulk->is_bulk = false;
    bulk->error = CDS_ERROR_RANGE;
    bulk->length = 0;
    bulk->left = 0;
    if (parameters < 3)
        return;
    bulk->address = packet[CDS_AT_PARAMETERS];
    bulk->each = packet[CDS_AT_PARAMETERS + 1];
    parameters = (uint8_t)(parameters - 2);
    size = (uint16_t)(bulk->each * parameters);
    if (size == 0 || size > DATA_MAX)
        return;
    bulk->error = 0;
    bulk->left = parameters;
    bulk->length = (uint8_t)size;
    /* The IDs give way to the data, which grow faster than IDs are used up: from the other end. */
    bulk->next =
        memmove(packet + PACKET_MAX - parameters, packet + CDS_AT_PARAMETERS + 2, parameters);
}

static bool begin_bulk(struct bulk_read *bulk, const uint8_t *packet)
{
    uint8_t left = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 1);
    const uint8_t *item = packet + CDS_AT_PARAMETERS + 1;
    uint8_t servos = 0;

    bulk->is_bulk = true;
    bulk->next = item;
    if (left > DATA_MAX)
        return false;
    for (; left >= BULK_ITEM; left = (uint8_t)(left - BULK_ITEM)) {
        if (item[1] > CDS_ID_MAX)
            return false;
        item += BULK_ITEM;
        servos++;
    }
    bulk->left = servos;
    return left == 0 && servos;
}

/* Makes a READ of the next servo, there being one. Its result: CDS_OK if it is to be sent;
 * CDS_PENDING if the device itself is asked, and nothing is sent. */
static void build(struct bulk_read *bulk, struct cds_request *read)
{
    const uint8_t *next = bulk->next;
    uint8_t id = next[0], address = bulk->address, count = bulk->each;

    bulk->next = next + 1;
    if (bulk->is_bulk) {
        bulk->next = next + BULK_ITEM;
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
    if (id == bulk->device_id) {
        read->result = CDS_PENDING;
        memcpy(read->reply, read->packet.bytes, CDS_PACKET_SIZE(2));
    } else if (id > CDS_ID_MAX) {
        read->result = CDS_BAD_ARGUMENT;
    }
}

/* Of a SYNC READ, and of a servo that failed. Apart: a BULK READ that goes well shall not save
 * registers for it. */
NOINLINE static void keep(struct bulk_read *bulk, const struct cds_request *read)
{
    uint8_t each = bulk->each;
    bool good = read->result == CDS_OK && read->length == each;

    if (!good)
        device_note_failure(bulk->device, read->id);
    if (bulk->is_bulk)
        return;
    if (good) {
        memcpy(bulk->to, read->reply, each);
    } else {
        memset(bulk->to, MISSING, each);
        bulk->error = BULK_READ_ERROR_FAILED;
    }
    bulk->to += each;
}

/* What has come of the READ that has ended; not yet, if the host has no room. */
static void hand_over(struct bulk_read *bulk)
{
    const struct cds_request *read = bulk->spare;

    if (!bulk->is_bulk || read->result != CDS_OK)
        keep(bulk, read);
    else if (!status_packet_put_whole(bulk->output, read->id, read->error, read->reply,
                                      read->length))
        return;
    bulk->other = BULK_READ_SPENT;
}

/* There is nothing to hand over: the READ after the one that is asked is built. */
static void prepare(struct bulk_read *bulk)
{
    const struct cds_request *asked = bulk->asked;
    bool waits = asked->result == CDS_PENDING && asked->id != bulk->device_id;

    bulk->other = waits ? BULK_READ_WAITS : BULK_READ_READY;
    if (bulk->left > 1)
        build(bulk, bulk->spare);
}

/* The servo asked has ended. In a BULK READ the others would wait in vain for one that failed. */
static void go_on(struct bulk_read *bulk)
{
    struct cds_request *ended = bulk->asked, *next = bulk->spare;

    bulk->asked = next;
    bulk->spare = ended;
    bulk->other = BULK_READ_ENDED;
    bulk->left--;
    if (bulk->is_bulk && ended->result != CDS_OK)
        bulk->left = 0;
    if (bulk->left && next->result == CDS_OK)
        cds_bus_submit(bulk->bus, next); // next->result says why, if it is refused
    hand_over(bulk);                     // while the next one is asked
}

/* If the host has not taken the reply before this one, bulk_read_poll() goes on. */
static void on_end(struct cds_request *ended)
{
    struct bulk_read *bulk = ended->context;

    if (bulk->other == BULK_READ_WAITS)
        go_on(bulk);
}

void bulk_read_open(struct bulk_read *bulk, struct cds_bus *bus, struct device *device,
                    struct cds_ring *output)
{
    OPTIMIZER_BARRIER(bulk);
    *bulk = (struct bulk_read){.bus = bus, .device = device, .output = output};
    for (uint8_t i = 0; i < 2; i++) {
        bulk->read[i].packet.bytes = bulk->packets[i];
        bulk->read[i].packet.capacity = sizeof bulk->packets[i];
        bulk->read[i].reply = bulk->replies[i];
        bulk->read[i].reply_capacity = sizeof bulk->replies[i];
        bulk->read[i].on_end = on_end;
        bulk->read[i].context = bulk;
    }
}

bool bulk_read_begin(struct bulk_read *bulk, uint8_t device_id, uint8_t *packet)
{
    bool sense = true;

    OPTIMIZER_BARRIER(bulk);
    bulk->device_id = device_id;
    bulk->asked = bulk->read;
    bulk->spare = bulk->read + 1;
    bulk->other = BULK_READ_SPENT;
    if (packet[CDS_AT_INSTRUCTION] == INSTRUCTION_SYNC_READ)
        begin_sync(bulk, packet);
    else
        sense = begin_bulk(bulk, packet);
    if (sense && bulk->left) {
        build(bulk, bulk->asked);
        if (bulk->asked->result == CDS_OK)
            cds_bus_submit(bulk->bus, bulk->asked);
    }
    device_forget_failures(bulk->device); // while the first servo is asked
    return sense;
}

/* The device's own answer is no longer than a servo's. */
static void obey(struct bulk_read *bulk, struct cds_request *read)
{
    struct device *device = bulk->device;

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
static void look_after(struct bulk_read *bulk)
{
    struct cds_request *asked = bulk->asked;

    if (asked->result == CDS_PENDING && asked->id == bulk->device_id)
        obey(bulk, asked);
    else if (asked->result == CDS_BUSY) // an operation held the bus
        cds_bus_submit(bulk->bus, asked);
    if (asked->result != CDS_PENDING)
        go_on(bulk);
}

enum bulk_read_turn bulk_read_poll(struct bulk_read *bulk)
{
    switch (bulk->other) {
    case BULK_READ_ENDED: hand_over(bulk); break;
    case BULK_READ_SPENT: prepare(bulk); break;
    default:
        if (!bulk->left)
            return bulk->is_bulk ? BULK_READ_DONE : BULK_READ_ANSWER;
        look_after(bulk);
    }
    return BULK_READ_MORE;
}
