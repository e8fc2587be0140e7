/* What becomes of the exchanges of a bus, counted, and told to whoever watches: for programs that
 * read counters or have an observer. In all others bus.c has nothing in the place of these. */
#include "cds55xx/bus.h"

#include "compiler.h" // NOINLINE

bool cds_bus_is_watched_(const struct cds_bus *bus)
{
    return bus->observer;
}

uint8_t cds_bus_judge_(struct cds_bus *bus, struct cds_request *request)
{
    if (!bus->observer)
        return CDS_OK;
    request->return_delay_us = bus->return_delay_us; // unless the observer knows better
    return (uint8_t)bus->observer->admit(bus->observer, request);
}

NOINLINE void cds_bus_count_(uint16_t *counter)
{
    (*counter)++;
}

void cds_parser_note_stray_(struct cds_parser *parser)
{
    parser->stray++;
}

void cds_bus_note_sent_(struct cds_bus *bus)
{
    bus->counters.sent++;
}

/* What news there is. Of a packet that was not due, only event, ID and error mean anything. */
NOINLINE static void tell(struct cds_bus *bus, uint8_t event, uint8_t id, uint8_t error,
                          uint8_t result)
{
    const struct cds_bus_asked *what = cds_bus_asked_(bus);
    struct cds_bus_news news = {.event = event,
                                .id = id,
                                .error = error,
                                .result = result,
                                .instruction = what->instruction,
                                .address = what->first,
                                .request = bus->request};

    if (bus->observer)
        bus->observer->on_news(bus->observer, &news);
}

NOINLINE void cds_bus_note_end_(struct cds_bus *bus, uint8_t result)
{
    const struct cds_request *request = bus->request;
    uint16_t *counter = &bus->counters.timeouts;

    if (bus->flight != CDS_BUS_TELLS) {
        bus->has_ended = true;
        bus->last_id = bus->asked;
        bus->last_result = result;
    }
    if (result == CDS_OK)
        counter = &bus->counters.ok;
    else if (result == CDS_CORRUPT)
        counter = &bus->counters.corrupt;
    cds_bus_count_(counter);
    tell(bus, CDS_BUS_ENDED, request->id, request->error, result);
}

/* A good packet that was not due: an answer too late, a second one, or whose? */
NOINLINE void cds_bus_note_undue_(struct cds_bus *bus)
{
    uint16_t *counter = &bus->counters.foreign;
    uint8_t event = CDS_BUS_FOREIGN, id = bus->parser.id;

    if (bus->has_ended && (bus->last_id == id || bus->last_id == CDS_BROADCAST_ID)) {
        event = CDS_BUS_LATE;
        counter = &bus->counters.late;
        if (bus->last_result == CDS_OK) {
            event = CDS_BUS_EXTRA;
            counter = &bus->counters.extra;
        }
    }
    cds_bus_count_(counter);
    tell(bus, event, id, bus->parser.error, CDS_PENDING); // nothing has ended
}

/* Brings a total up to date with a count of its last 8 bits. */
static void catch_up(uint16_t *total, uint8_t count)
{
    *total = (uint16_t)(*total + (uint8_t)(count - *total));
}

/* Adds up what the handlers have counted. Of bytes for which there was no room, those that broke
 * the stream, which are `overfull`, the handlers have not. */
static void add_up(const struct cds_link *link, uint8_t overfull, struct cds_counters *counters)
{
    uint8_t both = link->both_errors;

    catch_up(&counters->framing_errors, (uint8_t)(link->framing_errors + both));
    catch_up(&counters->overruns, (uint8_t)(link->overruns + both));
    catch_up(&counters->ring_overflows, (uint8_t)(link->ring_overflows + overfull));
}

void cds_bus_note_break_(struct cds_bus *bus)
{
    if (bus->link.broken == CDS_LINK_FULL)
        bus->overfull++;
    add_up(&bus->link, bus->overfull, &bus->counters);
}

void cds_bus_set_observer(struct cds_bus *bus, struct cds_bus_observer *observer)
{
    if (bus->flight == CDS_BUS_BEGUN)
        cds_bus_expect_(bus); // what has begun keeps what it has begun with
    bus->observer = observer;
}

enum cds_result cds_bus_would_admit(struct cds_bus *bus, uint8_t id, uint8_t address,
                                    const uint8_t *data, uint8_t length)
{
    struct cds_bus_observer *observer = bus->observer;

    return observer ? observer->admit_block(observer, id, address, data, length) : CDS_OK;
}

void cds_bus_counters(const struct cds_bus *bus, struct cds_counters *out)
{
    uint8_t overfull = (uint8_t)(bus->overfull + (bus->link.broken == CDS_LINK_FULL));

    *out = bus->counters;
    add_up(&bus->link, overfull, out);
    out->stray = bus->parser.stray;
    out->echo_errors = cds_link_count(&bus->link.echo_errors);
}
