/* Are the servos well, and do they hold? See wake.h. */
#include "robot/wake.h"

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/servo.h"         // cds_servo_read(), cds_servo_write()

#define FIRST_READ CDS_REG_CW_ANGLE_LIMIT

_Static_assert(FIRST_READ + WAKE_READ_SIZE == CDS_REG_PRESENT_TEMPERATURE + 1, "bytes read");

enum phase {
    LOOK,      // READ
    SET_GOAL,  // WRITE of the position
    READ_BACK, // READ: is it the goal?
    TORQUE_ON, // WRITE
} __attribute__((packed));

static uint8_t byte_of(const struct wake *wake, uint8_t reg)
{
    return wake->reply[reg - FIRST_READ];
}

static uint16_t word_of(const struct wake *wake, uint8_t reg)
{
    return (uint16_t)(byte_of(wake, reg) | byte_of(wake, (uint8_t)(reg + 1)) << 8);
}

static void begin(struct wake *wake, bool holds)
{
    wake->index = wake->phase = wake->tries = 0;
    wake->holds = holds;
    wake->is_submitted = false;
}

void wake_begin(struct wake *wake)
{
    begin(wake, false);
    wake->why = WAKE_WELL;
    wake->request = (struct cds_request){
        .packet = {.bytes = wake->packet, .capacity = sizeof wake->packet},
        .reply = wake->reply,
        .reply_capacity = sizeof wake->reply,
    };
}

void wake_hold(struct wake *wake)
{
    begin(wake, true);
}

static enum cds_result send(struct wake *wake, struct robot *robot)
{
    struct cds_request *request = &wake->request;
    uint8_t id = robot->group[wake->index];

    switch (wake->phase) {
    case SET_GOAL:
        return cds_servo_write(robot->bus, request, id, CDS_REG_GOAL_POSITION,
                               wake->reply + (CDS_REG_PRESENT_POSITION - FIRST_READ), 2);
    case TORQUE_ON: return cds_servo_write_byte(robot->bus, request, id, CDS_REG_TORQUE_ENABLE, 1);
    default: return cds_servo_read(robot->bus, request, id, FIRST_READ, WAKE_READ_SIZE);
    }
}

/* Returns what is wrong with the servo that was read. */
static uint8_t judge(const struct wake *wake)
{
    uint8_t voltage = byte_of(wake, CDS_REG_PRESENT_VOLTAGE);

    if (wake->request.error & CDS_ERRORS_OF_CONDITION)
        return WAKE_ALARM;
    if (voltage < byte_of(wake, CDS_REG_MIN_VOLTAGE) ||
        voltage > byte_of(wake, CDS_REG_MAX_VOLTAGE))
        return WAKE_VOLTAGE;
    return word_of(wake, CDS_REG_CW_ANGLE_LIMIT) || word_of(wake, CDS_REG_CCW_ANGLE_LIMIT)
               ? WAKE_WELL
               : WAKE_MODE;
}

/* True if the goal that was read leaves the servo, which has no torque, where it is. */
static bool is_at_goal(const struct wake *wake)
{
    return (uint16_t)(word_of(wake, CDS_REG_GOAL_POSITION) -
                      word_of(wake, CDS_REG_PRESENT_POSITION) + WAKE_NEAR_STEPS) <=
           2 * WAKE_NEAR_STEPS;
}

/* The servo has answered well: sets the next phase, LOOK for the next servo. Returns an
 * enum wake_reason. */
static uint8_t take(struct wake *wake)
{
    uint8_t phase = wake->phase, why = WAKE_WELL;

    wake->phase = LOOK;
    switch (phase) {
    case LOOK:
        why = judge(wake);
        wake->lowest[wake->index] = word_of(wake, CDS_REG_CW_ANGLE_LIMIT);
        wake->highest[wake->index] = word_of(wake, CDS_REG_CCW_ANGLE_LIMIT);
        if (wake->holds && !byte_of(wake, CDS_REG_TORQUE_ENABLE))
            wake->phase = SET_GOAL;
        break;
    case SET_GOAL: wake->phase = READ_BACK; break;
    case READ_BACK:
        wake->phase = TORQUE_ON;
        if (!is_at_goal(wake)) { // it was turned meanwhile
            wake->phase = SET_GOAL;
            why = ++wake->tries < WAKE_TRIES ? WAKE_WELL : WAKE_REFUSED;
        }
        break;
    default: break;
    }
    return why;
}

static enum cds_result fail(struct wake *wake, const struct robot *robot, uint8_t why)
{
    wake->id = robot->group[wake->index];
    wake->why = why;
    return CDS_REFUSED;
}

/* The transaction has ended. */
static enum cds_result take_end(struct wake *wake, const struct robot *robot)
{
    const struct cds_request *request = &wake->request;
    uint8_t why;

    wake->is_submitted = false;
    if (request->result != CDS_OK)
        return ++wake->tries < WAKE_TRIES ? CDS_PENDING : fail(wake, robot, WAKE_SILENT);
    if (request->error & CDS_ERRORS_OF_PACKET)
        return fail(wake, robot, WAKE_REFUSED);
    why = take(wake);
    if (why != WAKE_WELL)
        return fail(wake, robot, why);
    if (wake->phase != LOOK)
        return CDS_PENDING;
    wake->tries = 0;
    return ++wake->index < robot->group_count ? CDS_PENDING : CDS_OK;
}

enum cds_result wake_poll(struct wake *wake, struct robot *robot)
{
    if (wake->is_submitted)
        return wake->request.result == CDS_PENDING ? CDS_PENDING : take_end(wake, robot);
    if (send(wake, robot) != CDS_OK)
        return fail(wake, robot, WAKE_REFUSED);
    wake->is_submitted = true;
    return CDS_PENDING;
}
