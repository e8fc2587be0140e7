/* Many servos at once; see group.h. */
#include "cds55xx/group.h"

#include "cds55xx/servo.h" // cds_servo_reg_write(), cds_servo_action()

enum cds_result cds_group_sync_begin(struct cds_request *request, uint8_t address, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY; // its packet is to be sent as it is
    return cds_packet_sync_begin(&request->packet, address, length);
}

void cds_group_sync_add(struct cds_request *request, uint8_t id, const uint8_t *data)
{
    if (request->result != CDS_PENDING)
        cds_packet_sync_add(&request->packet, id, data);
}

#define GOAL_SIZE 4 // bytes from GOAL_POSITION to MOVING_SPEED

/* Both words low byte first (R28). */
static void put_goal(uint8_t data[GOAL_SIZE], uint16_t position, uint16_t speed)
{
    data[0] = (uint8_t)position;
    data[1] = (uint8_t)(position >> 8);
    data[2] = (uint8_t)speed;
    data[3] = (uint8_t)(speed >> 8);
}

void cds_group_sync_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed)
{
    uint8_t data[GOAL_SIZE];

    put_goal(data, position, speed);
    cds_group_sync_add(request, id, data);
    if ((position > CDS_VALUE_MAX || speed > CDS_VALUE_MAX) && request->result != CDS_PENDING)
        request->packet.size = CDS_PACKET_REFUSED;
}

enum cds_result cds_group_sync_send(struct cds_bus *bus, struct cds_request *request)
{
    enum cds_result result;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_end(&request->packet);
    if (result != CDS_OK)
        return result;
    request->reply_parameters = CDS_REPLY_NONE;
    request->repeats = 0;
    return cds_bus_submit(bus, request);
}

/* A registered move: what it is doing. Each phase sends, then waits for the outcome. */
enum move_phase {
    ARM,     // REG WRITE to goals[next]
    DISARM,  // register 0x2C = 0 of goals[next], which was armed
    TRIGGER, // ACTION to all
};
#define SENT 0x80 // added to the phase: the exchange is in flight

void cds_group_move_begin(struct cds_group_move *move, struct cds_bus *bus,
                          struct cds_request *request, struct cds_goal *goals, uint8_t count)
{
    *move = (struct cds_group_move){
        .bus = bus,
        .request = request,
        .goals = goals,
        .count = count,
        .phase = ARM,
        .result = count ? CDS_PENDING : CDS_BAD_ARGUMENT,
    };
    for (uint8_t i = 0; i < count; i++) {
        goals[i].result = CDS_PENDING;
        goals[i].error = 0;
    }
}

static enum cds_result arm(struct cds_group_move *move, const struct cds_goal *goal)
{
    uint8_t data[GOAL_SIZE];

    if (goal->id > CDS_ID_MAX)
        return CDS_BAD_ARGUMENT;
    put_goal(data, goal->position, goal->speed);
    return cds_servo_reg_write(move->bus, move->request, goal->id, CDS_REG_GOAL_POSITION, data,
                               sizeof data);
}

static enum cds_result send(struct cds_group_move *move)
{
    switch (move->phase) { // in the last one there is no goals[next] any more
    case ARM: return arm(move, &move->goals[move->next]);
    case DISARM:
        return cds_servo_write_byte(move->bus, move->request, move->goals[move->next].id,
                                    CDS_REG_REGISTERED_INSTRUCTION, 0);
    default: return cds_servo_action(move->bus, move->request, CDS_BROADCAST_ID);
    }
}

/* Goals below `next` are, or may be, armed: disarm the last of them, or end. */
static void step_back(struct cds_group_move *move)
{
    if (move->next == 0) {
        move->result = move->reason;
        return;
    }
    move->next--;
    move->phase = DISARM;
}

/* goals[next] was asked to register its move. One that did not answer well may have done it all
 * the same, so it is disarmed too. */
static void armed(struct cds_group_move *move, uint8_t result, uint8_t error)
{
    struct cds_goal *goal = &move->goals[move->next];

    goal->error = error;
    goal->result = result;
    if (result == CDS_OK && error & CDS_ERRORS_OF_PACKET)
        goal->result = CDS_REFUSED;
    if (goal->result == CDS_OK) {
        move->next++;
        move->phase = move->next == move->count ? TRIGGER : ARM;
        return;
    }
    move->reason = goal->result;
    if (goal->result == CDS_TIMEOUT || goal->result == CDS_CORRUPT)
        move->next++;
    step_back(move);
}

static void exchange_ended(struct cds_group_move *move)
{
    const struct cds_request *request = move->request;
    uint8_t phase = move->phase & (uint8_t)~SENT;

    move->phase = phase;
    if (phase == ARM)
        armed(move, request->result, request->error);
    else if (phase == DISARM)
        step_back(move);
    else
        move->result = request->result;
}

enum cds_result cds_group_move_poll(struct cds_group_move *move)
{
    enum cds_result result;

    if (move->phase & SENT && move->request->result != CDS_PENDING)
        exchange_ended(move);
    if (move->result != CDS_PENDING || move->phase & SENT)
        return (enum cds_result)move->result;
    result = send(move);
    if (result == CDS_OK) {
        move->phase |= SENT;
    } else if (result != CDS_BUSY) { // an argument: nothing was sent to this servo
        move->goals[move->next].result = (uint8_t)result;
        move->reason = (uint8_t)result;
        step_back(move);
    }
    return (enum cds_result)move->result;
}
