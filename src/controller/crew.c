/* A roster that grows; see crew.h. */
#include "crew.h"

#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_REG_STATUS_RETURN_LEVEL
#include "cds55xx/packet.h"        // CDS_AT_*
#include "safety/permit.h"         // cds_permit_check()
#include "safety/observe.h"        // cds_servos_admit()
#include "compiler.h"              // NOINLINE

/* Status return levels (R3). */
#define LEVEL_READ 1
#define LEVEL_ALL  2

static struct crew *of(struct cds_bus_observer *observer)
{
    return (struct crew *)observer; // first of its roster, which is first of it
}

bool crew_meet(struct crew *crew, uint8_t id)
{
    struct cds_servos *roster = &crew->roster;

    if (id > CDS_ID_MAX || cds_servos_find(roster, id))
        return true;
    if (cds_servos_add(roster, id, crew->room) != CDS_OK) {
        crew->crowded = true;
        return false;
    }
    if (roster->inhibited)
        cds_servos_hold(roster, &roster->servos[roster->count - 1], CDS_INHIBIT_STOPPED);
    return true;
}

static void meet_blocks(struct crew *crew, const uint8_t *bytes)
{
    const uint8_t *parameters = bytes + CDS_AT_PARAMETERS;
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t block = (uint16_t)(parameters[1] + 1u); // 256 too: the packet may be the host's

    for (uint16_t at = 2; at + block <= count; at = (uint16_t)(at + block))
        crew_meet(crew, parameters[at]);
}

/* After that one must know how the servo answers, or whether. */
static bool changes_settings(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE &&
           bytes[CDS_AT_PARAMETERS] <= CDS_REG_STATUS_RETURN_LEVEL;
}

NOINLINE static void meet_addressed(struct crew *crew, const uint8_t *bytes)
{
    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_WRITE:
    case CDS_REG_WRITE: crew_meet(crew, bytes[CDS_AT_ID]); break;
    case CDS_SYNC_WRITE: meet_blocks(crew, bytes); break;
    default: break;
    }
}

/* Short: this comes with every transaction. */
static enum cds_result admit(struct cds_bus_observer *observer, struct cds_request *request)
{
    struct crew *crew = of(observer);
    const uint8_t *bytes = request->packet.bytes;
    enum cds_result result;

    if (crew->away) {
        request->vetted = 0;
        return cds_permit_check(&crew->roster, bytes);
    }
    if (crew->open || changes_settings(bytes))
        meet_addressed(crew, bytes);
    result = cds_servos_admit(observer, request);
    if (result == CDS_TOO_EARLY)
        crew->early++;
    return result;
}

static enum cds_result admit_block(struct cds_bus_observer *observer, uint8_t id, uint8_t address,
                                   const uint8_t *data, uint8_t length)
{
    struct crew *crew = of(observer);

    if (crew->open)
        crew_meet(crew, id);
    return cds_servos_admit_block(observer, id, address, data, length);
}

/* One that answers though it was set not to is another servo with this ID, or was reset by others.
 */
static void believe(struct crew *crew, uint8_t id, uint8_t level)
{
    struct cds_servo_state *servo = cds_servos_find(&crew->roster, id);

    if (servo && servo->status_return_level < level)
        servo->status_return_level = level & 3u;
}

/* Whoever has sent a packet is there, also if it was not the one that was asked. */
static void on_news(struct cds_bus_observer *observer, const struct cds_bus_news *news)
{
    struct crew *crew = of(observer);
    bool answered;

    if (crew->away)
        return;
    if (!crew->open && !news->error && news->event == CDS_BUS_ENDED) { // short: it comes every time
        cds_servos_on_news(observer, news);
        return;
    }
    answered = news->result == CDS_OK && news->request &&
               news->request->reply_parameters != CDS_REPLY_NONE;
    if (news->error || (crew->open && (news->event != CDS_BUS_ENDED || answered)))
        crew_meet(crew, news->id);
    if (news->event == CDS_BUS_EXTRA || news->event == CDS_BUS_FOREIGN)
        believe(crew, news->id, LEVEL_ALL);
    cds_servos_on_news(observer, news);
    if (answered && news->instruction == CDS_READ)
        believe(crew, news->id, LEVEL_READ); // whatever it says there: it may be of another make
}

void crew_begin(struct crew *crew, struct cds_bus *bus, struct cds_servo_state *servos,
                uint8_t room)
{
    struct cds_bus_observer *observer = &crew->roster.observer;

    cds_servos_begin(&crew->roster, bus, servos, 0);
    observer->admit = admit;
    observer->admit_block = admit_block;
    observer->on_news = on_news;
    crew->room = room;
    crew->crowded = crew->away = crew->open = false;
}
