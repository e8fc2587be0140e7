/* "pose ... in TIME" by a timed move of the cycle. A cycle that this command starts ends with the
 * move. */
#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/moves.h"

enum phase {
    START, // until a cycle that is ending has ended
    LOOK,  // until the positions of all servos are known
    MOVE,  // until the motion takes the move
    CHECK, // until the move has begun
    END,   // it was refused: until the cycle has ended
} __attribute__((packed));

uint8_t moves_command_begin(struct console *console)
{
    struct robot *robot = console->robot;

    if (moves_is_playing(robot))
        return ERROR_MOTION;
    console->part = robot->cycle && !robot->moves->ends_cycle; // it goes on after the move
    return 0;
}

static bool start(struct console *console)
{
    struct robot *robot = console->robot;

    if (robot->cycle && !console->part && !moves_are_under_way(robot))
        return true;
    console->phase = LOOK;
    if (robot->cycle == NULL)
        console->error = cycle_start(console, console->failsafe->settings->cycle_us);
    return console->error == 0;
}

static bool look(struct console *console)
{
    if (cycle_look(console) == CDS_OK)
        console->phase = MOVE;
    if (console->error)
        console->phase = END;
    return true;
}

/* "servo 3 needs 400 ms" */
void motion_failed(struct console *console, uint8_t joint)
{
    const struct robot *robot = console->robot;
    const struct cds_motion *motion = &robot->moves->motion;
    union printer_value *values = console->printer.values;
    bool is_too_fast = console->error == CDS_LIMIT && motion->shortest_ms;

    values[0].number = robot->group[joint];
    values[1].text = error_text(console->error);
    if (is_too_fast) {
        values[1].number = (uint16_t)motion->shortest_ms;
        values[2].number = (uint16_t)(motion->shortest_ms >> 16);
        console->error = ERROR_TOO_FAST;
    }
    printer_line(&console->printer, is_too_fast ? message_too_fast : message_servo);
}

static bool check(struct console *console)
{
    const struct robot *robot = console->robot;
    const struct cds_motion *motion = &robot->moves->motion;

    if (robot->cycle == NULL && motion->move_result == CDS_PENDING) {
        console->error = ERROR_STOPPED;
        return false;
    }
    if (motion->move_result == CDS_PENDING)
        return true;
    console->error = motion->move_result;
    if (console->error == 0)
        return false;
    console->phase = END;
    motion_failed(console, motion->joint);
    return true;
}

static bool submit(struct console *console, enum cds_result (*move)(struct console *, bool))
{
    enum cds_result result = move(console, !console->part);

    if (result == CDS_BUSY)
        return true;
    console->phase = CHECK;
    console->error = (uint8_t)result;
    return result == CDS_OK;
}

bool moves_command_poll(struct console *console,
                        enum cds_result (*move)(struct console *console, bool ends_cycle))
{
    switch (console->phase) {
    case START: return start(console);
    case LOOK: return look(console);
    case MOVE: return submit(console, move);
    case CHECK: return check(console);
    default: return console->robot->cycle && !console->part;
    }
}

/* The angles of the line are the pose. They stay in its buffer until the move has begun. */
static enum cds_result move_to_angles(struct console *console, bool ends_cycle)
{
    const void *pose = console->line.request->packet.bytes;

    return moves_begin(console->robot,
                       &(struct cds_move){.pose = pose, .time_ms = move_job(console)->ms},
                       ends_cycle);
}

static bool poll(struct console *console)
{
    return moves_command_poll(console, move_to_angles);
}

const CDS_FLASH struct command_action pose_moves = {.begin = moves_command_begin, .poll = poll};
