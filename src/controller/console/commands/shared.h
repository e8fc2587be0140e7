/* SPDX-License-Identifier: MIT */
/* Functions and types that several files of commands use. */
#ifndef CONTROLLER_SHARED_H
#define CONTROLLER_SHARED_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/setup.h"      // struct cds_setup
#include "compiler.h"           // ALWAYS_INLINE
#include "console/console.h"    // struct console, console_job()
#include "robot/motion_start.h" // struct motion_outcome

/* The job of a command that may start the cycle. */
struct move_job {
    uint32_t begun_us; // when the cycle was started
    uint32_t ms;       // time of the move
};

static inline struct move_job *move_job(struct console *console)
{
    return console_job(console);
}

/* True if the line is held low: what is known of servos is old then. */
ALWAYS_INLINE bool servos_line_is_low(const struct cds_servos *servos)
{
    return cds_bus_line(servos->bus) == CDS_BUS_LINE_FAULT;
}

/* In stop.c: true if the servo is known to be at another rate than the bus. */
bool servo_is_at_other_rate(const struct console *console, const struct cds_servo_state *servo);

/* If servo_is_at_other_rate(), puts message_at_rate and its value into the values of message_servo,
 * and returns true. */
ALWAYS_INLINE bool servo_put_rate(struct console *console, const struct cds_servo_state *servo)
{
    if (!servo_is_at_other_rate(console, servo))
        return false;
    console->printer.values[1].text = message_at_rate;
    console->printer.values[2].number = servo->baud_reg;
    return true;
}

/* In controller.c: true if the servo joined the robot after the last stop. A stop that gave up on a
 * line in use has not read all servos. */
bool joined_since_stop(const struct robot *robot, const struct cds_servo_state *servo);

/* In controller.c: the causes of a reset that the banner tells, each behind "; reset by", which
 * has RESET_BY characters: `status` prints only what follows. */
extern const CDS_FLASH char reset_by_brown_out[], reset_by_watchdog[];
#define RESET_BY (sizeof "; reset by" - 1)

/* In cycle.c: range of the period, in ms. */
#define CYCLE_MS_MIN 2
#define CYCLE_MS_MAX 65

/* In cycle.c: starts the cycle of the group. Returns an error, or 0. */
uint8_t cycle_start(struct console *console, uint16_t period_us);

/* In cycle.c, for the poll of a command that has called cycle_start(). Returns CDS_PENDING until
 * each servo has answered once, then CDS_OK. Else it has stored console->error, and the cycle ends.
 */
enum cds_result cycle_known(struct console *console);

/* What stands behind the angles of `pose`. */
enum pose_choice { POSE_AT_DEFAULT, POSE_AT, POSE_IN } __attribute__((packed));

/* In group.c: angle `index` of the line. */
uint16_t pose_angle(const struct console *console, uint8_t index);

/* In group.c: keeps the goals of the group, with the angles of the line and the speed in
 * console->raw, in robot->work.move. Returns an error if an operation is under way, or 0. */
uint8_t pose_keep_goals(struct console *console);

/* In group.c: sends these goals, as `group` says. Returns an error, or 0. */
uint8_t pose_send(struct console *console);

/* In group.c: the poll of a command that has called pose_send(). */
bool pose_sent_poll(struct console *console);

/* In group.c: prints the first servo of `ids` that is online without torque, and how many others
 * are; inhibited servos and those in endless turn do not count. Prints nothing if there is none.
 * `ids` NULL: all servos of the list. Only for chips with room for it. */
void servos_tell_torque(struct console *console, const uint8_t *ids, uint8_t count);

/* In pose_by_servo.c and pose_moves.c: "pose ... in TIME", pose_in of struct command_set. */
extern const CDS_FLASH struct command_action pose_by_servo, pose_moves;

/* In play.c: in mode person, prints the error of the last motion unless a command has printed it.
 * Returns false if it printed nothing. A firmware without motions does not call it. */
bool play_report(struct console *console);

/* In play.c: number `index` of the line, 10 to 200 %. Returns an error or 0. */
uint8_t play_take_percent(const struct console *console, uint8_t index, uint8_t *percent);

/* In motion_command.c: the poll of a command that starts a motion, with console->phase 0 at first.
 * `start` calls a function of motion_start.h, and returns its error. Returns true until the motion
 * has begun or was refused. Then console->error is stored. */
bool motion_command_poll(struct console *console, uint8_t (*start)(struct console *console));

/* In motion_command.c: prints "servo 2 needs 92 ms in step 3", or "servo 2 is the cause". */
void motion_print_cause(struct console *console, const struct motion_outcome *outcome);

/* In motion_command.c, for a profile with command_set.noise: true if the cause of the outcome is
 * not one servo: noise, or no servo answers. */
bool motion_concerns_all(const struct console *console, const struct motion_outcome *outcome);

/* How the last motion has ended, as it was seen at its end: noise or a lost link may be over when
 * `motion` prints it. Storage: command_set.ended_motion. */
struct ended_motion {
    bool is_kept;               // false: a motion is under way, or has not begun
    bool concerns_all;          // motion_concerns_all()
    bool is_by_link;            // after ROBOT_STOPPED: the lost host link has stopped it
    uint8_t error;              // console_remedied()
    uint16_t noise_bytes;       // of the bus, when the motion began
    const CDS_FLASH char *text; // of the error, or of the fault of the line that is the cause
};

/* In motion_command.c: returns the message that tells why the last motion has failed,
 * "servo 2: error 83: a servo does not follow its goals; ...", with its values from `values` on. */
const CDS_FLASH char *motion_failure(struct console *console, union printer_value *values);

/* In motion_command.c: stores outcome->result in console->error, and prints the servo that is the
 * reason, if there is one. */
void motion_take_outcome(struct console *console, const struct motion_outcome *outcome);

/* The job of `play`. */
struct play_job {
    uint16_t repeats; // 0: for ever
    uint8_t percent;
    uint16_t too_fast;           // bit i: step i is too fast, as a start has found
    struct motion_outcome first; // of the first of these starts
};

_Static_assert(sizeof(struct play_job) <= CONSOLE_JOB_SIZE, "the job must fit");

/* In fast_steps.c: `begin` and `tries_again` of struct command_motion_words. */
void fast_steps_begin(struct console *console);
bool fast_steps_try_again(struct console *console);

/* In fast_steps.c: the start is over. A stop may have ended it before it has read a step. */
void fast_steps_end(struct robot *robot);

/* In motion_words.c: motion_words of struct command_set. */
extern const CDS_FLASH struct command_motion_words motion_words;

/* In teach.c: the error for an enum cds_reason. */
uint8_t torque_on_error(uint8_t reason);

/* The job of a command that writes registers. */
struct set_job {
    struct cds_setup setup;
    uint8_t data[4];     // what servo_write() writes
    uint8_t limits[4];   // of `turn` and `move`: the angle limits that the servo has
    uint8_t bound_at;    // of `set`: address of the register that the value contradicts, or 0
    uint16_t bound;      // its value
    uint16_t kept_speed; // of `move` without SPEED: MOVING_SPEED of the servo
    uint16_t goal, from; // of `torque on`: goal and position of a servo without torque
};

_Static_assert(sizeof(struct set_job) <= CONSOLE_JOB_SIZE, "the job must fit");

static inline struct set_job *set_job(struct console *console)
{
    return console_job(console);
}

/* In servo.c: submit a READ or a WRITE to line.id. The WRITE sends `data` of the struct set_job,
 * and sets console->phase to SERVO_WRITE_SENT: your own phases have other values. They return enum
 * cds_result. */
#define SERVO_WRITE_SENT 1
uint8_t servo_read(struct console *console, uint8_t address, uint8_t length);
uint8_t servo_write(struct console *console, uint8_t address, uint8_t length);

/* In servo.c: call it before a write of a goal or a speed. Returns an error if a cycle sets the
 * goal of servo line.id: the next goals of the cycle would replace this one. */
uint8_t servo_cycled(const struct console *console);

/* In register.c: prints "GOAL_POSITION = 150.147deg (512)", at most 44 characters. */
void register_print(struct printer *printer, uint8_t address, uint16_t raw);

/* In register.c: the value of a register of `width` bytes, 1 or 2, whose bytes are at `bytes`. */
uint16_t register_raw_at(const uint8_t *bytes, uint8_t width);

/* In register.c: the REG and number 0 of the line as a register that `set` may write, in *at, and
 * its value, in `data` of the struct set_job. Returns an error or 0. */
uint8_t register_take_value(struct console *console, struct cds_register *at);

/* In servo.c: after console_waits() has returned false for a request to one of several servos.
 * Returns the error of this servo, or 0, and clears both errors of the console. */
uint8_t servo_outcome(struct console *console);

/* In servo.c: prints "servo 3: no reply by the deadline" for line.id. */
void servo_failed(struct console *console, uint8_t error);

/* In setup.c: begins a setup in the struct set_job that writes `data` to line.id. Returns enum
 * cds_result. */
uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length);

/* For the poll of a command with such a setup. Returns true while the setup goes on. When it
 * returns false, it has stored the outcome in console->error and console->servo_error. */
bool setup_waits(struct console *console);

/* In setup.c: true if no good reply came, or if the servo got a damaged packet (`servo_error`), and
 * a try is left. Counts this try in console->part. */
bool setup_has_try(struct console *console, uint8_t result, uint8_t servo_error);

/* In setup.c: begin of `baud`, which takes a list of servos as a whole. */
uint8_t baud_begin(struct console *console);

#define AFTER_SCAN_SUSPECTS 4

/* What the scan has shown of a servo. */
enum after_scan_kind {
    AFTER_SCAN_GOOD,
    AFTER_SCAN_DAMAGED, // damaged replies: it is diagnosed
    AFTER_SCAN_SUSPECT, // bytes without a packet: printed only if the finding is 8 or 18
} __attribute__((packed));

/* The job of `scan` and `diagnose`. */
struct after_scan {
    struct cds_stats begun; // counters of the bus when the search began
    uint8_t phase;          // enum after_scan_phase, once the scan is over
    uint8_t index, count, tries;
    uint8_t suspects;                         // count of suspect_ids
    uint16_t noise;                           // bytes without a packet, as the bus has counted them
    uint8_t suspect_ids[AFTER_SCAN_SUSPECTS]; // silent, but bytes without a packet came
    uint8_t ids[ROBOT_SERVOS + AFTER_SCAN_SUSPECTS];
    uint8_t kinds[ROBOT_SERVOS + AFTER_SCAN_SUSPECTS]; // enum after_scan_kind
    uint8_t known;                                     // servos of the list before the search
    uint8_t powered;                                   // servos that have joined with torque on
    uint8_t powered_id;                                // ID of the last of them
    uint16_t other_rate; // rate of a servo found at another rate, as register value plus 1; or 0
};

enum after_scan_phase {
    AFTER_SCAN_BEGIN,
    AFTER_SCAN_ASK,      // the next servo: READ, or diagnosis if its reply was damaged
    AFTER_SCAN_READ,     // waits for the reply
    AFTER_SCAN_DIAGNOSE, // waits for the finding
    AFTER_SCAN_MEND,     // prints how to mend it
} __attribute__((packed));

_Static_assert(sizeof(struct after_scan) <= CONSOLE_JOB_SIZE, "the job must fit");

static inline struct after_scan *after_scan_job(struct console *console)
{
    return console_job(console);
}

/* In after_scan.c: notes the ID that is asked now at the rate of the bus if bytes without a packet
 * have come. Call it while the scan goes on. */
void after_scan_note(struct console *console);

/* In after_scan.c: after_scan of struct command_set. */
bool after_scan(struct console *console);

/* In bus.c: prints "3 found, 254 asked". After a whole scan at the rate of the bus it stores
 * robot->unlisted: the servos found that are not in the list of the robot. */
void scan_sum_up(struct console *console);

/* In stop.c: the begin of `stop`. */
uint8_t stop_begin(struct console *console);

/* In servos.c: `servos`, and `servos forget` of all servos. */
uint8_t servos_begin(struct console *console);
bool servos_poll(struct console *console);

/* True if the servo answered its last state check, or has just come back. */
static inline bool servo_answers(const struct cds_servo_state *servo)
{
    return servo->presence == CDS_PRESENCE_ONLINE || servo->presence == CDS_PRESENCE_RETURNED;
}

/* In bus.c: the state of the line. It is not quiet while there is noise (console_is_noisy()). */
enum cds_bus_line bus_line_state(const struct console *console);

/* In bus.c: prints state and rate of the bus: "bus ok at 1000000bps". */
void bus_print_line(struct console *console);

/* In bus.c: prints what a change of the bus from the rate of register value `old` means for the
 * servos: "the bus changed to this rate; ..." */
void bus_print_change(struct console *console, uint8_t old);

/* In diagnose.c: begins the diagnosis of line.id. Returns an error or 0. Then prints its finding,
 * "servo 5: finding 8: ...". */
uint8_t diagnose_servo(struct console *console);
void diagnose_print_finding(struct console *console);

/* In diagnose.c: text and remedy of each enum cds_finding. */
extern const CDS_FLASH char *const CDS_FLASH diagnose_findings[];

/* What scan, diagnose and new add to the counters of the bus, and the time since the reset. */
struct account {
    uint32_t seconds;
    uint32_t counted_us;       // time up to which `seconds` counts
    struct cds_stats searched; // what all searches have added
};

/* In account.c, for a profile with command_set.account: a search begins, and has ended. */
void account_begin(struct console *console);
void account_end(struct console *console);

/* In account.c: prints since when the counters of the bus, or of a servo, count. */
void account_print_since(struct console *console);

/* In account.c: what searches have added to counter `index`. */
uint16_t account_searched(uint8_t index);

/* In backup.c: begin of `backup`, whose lines are printed as they are for each servo of a list. */
uint8_t backup_begin(struct console *console);

/* In teach.c: begin of `teach`, for one servo of its list. */
uint8_t teach_begin(struct console *console);

/* In teach.c: checks what holds for all servos of `teach`, and fills a list without IDs with the
 * group. Returns an error or 0. */
uint8_t teach_choose(struct console *console);

/* In autostart.c: the poll of `settings autostart`. */
bool autostart_show_or_off_poll(struct console *console);

/* In setting_units.c: what the value of a setting means; NULL: it is a plain number. */
const CDS_FLASH char *setting_meaning(uint8_t setting, uint16_t value);

/* In setup.c: begin of `factory`. */
uint8_t factory_begin(struct console *console);

/* In baud_list.c: baud_list of struct command_set. */
extern const CDS_FLASH struct command_action baud_list;

/* In setting_units.c: true if number 0 of the line is a rate in bit/s for the setting of the line.
 */
bool setting_is_rate(const struct command_line *line);

/* In setting_units.c: setting_number of struct command_set. A rate is also taken in bit/s, a
 * time with a unit of time. */
uint8_t setting_number(struct console *console);

/* The poll of a command that does only such a setup: prints whether the registers were written. */
bool setup_poll(struct console *console);

#endif
