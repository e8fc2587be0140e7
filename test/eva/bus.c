/* Bus: open, then any calls in any order, with any requests that bus.h allows. What handlers share
 * with the bus is volatile, so Eva assumes that they change it between any two reads. */
#include "cds55xx/bus.h"

#include "port.h"

#define BUFFER_SIZE 258u

static struct cds_bus bus;
static uint8_t buffer[BUFFER_SIZE];
static struct cds_request request;

static void submit(void)
{
    uint8_t result = request.result;

    if (result != CDS_PENDING) {
        uint16_t room = any_in(CDS_PACKET_SIZE(0), BUFFER_SIZE);

        for (uint16_t i = 0; i < BUFFER_SIZE; i++)
            buffer[i] = any_byte();
        request.packet.bytes = buffer;
        request.packet.room = room;
        request.packet.size = any_in(0, room);
        request.reply_parameters = any_byte();
        request.any_length = any_bool();
        request.skips_rest = any_bool();
        request.urgent = any_byte();
        request.repeats = any_byte();
    }
    cds_bus_submit(&bus, &request);
}

void eva_bus(void)
{
    //@ dynamic_split bus.flight;
    //@ dynamic_split bus.request == \null;
    cds_bus_open(&bus, 0, any_byte());
    while (any_bool()) {
        switch (any_in(0, 4)) {
        case 0: submit(); break;
        case 1: cds_bus_poll(&bus); break;
        case 2: cds_bus_cancel(&bus, &request); break;
        case 3: cds_bus_set_baud(&bus, any_byte()); break;
        default: cds_bus_open(&bus, 0, any_byte());
        }
    }
}
