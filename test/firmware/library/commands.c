/* SPDX-License-Identifier: MIT */
/* Runs every call of the library that sends an instruction, one after the other, on servos 1 to 6
 * with factory values; also values out of range and absent servos. Prints the result of each or, if
 * it is CDS_OK, 256 times the error bits of the reply; then the counters of the bus. Resets all
 * servos at the end. */
#include <cds55xx/cycle.h>
#include <cds55xx/feedback.h>
#include <cds55xx/sync_write.h>
#include <cds55xx/registered_move.h>
#include <cds55xx/group_read.h>
#include <cds55xx/identity.h>
#include <cds55xx/scan.h>
#include <cds55xx/servo.h>
#include <cds55xx/setup.h>
#include <cds55xx/servo_units.h>
#include <cds55xx/queue.h>
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

#define SERVOS  6
#define NOBODY  77
#define PERIODS 25

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static uint8_t reply[26]; // what "no_room" asks for does not fit
static struct cds_request request = CDS_REQUEST(packet, reply);
static struct cds_queue bus_queue;
static const struct cds_register_profile *const servo = &cds_profile_cds55xx;

static void ended(const char *name, enum cds_result result)
{
    say(name, result != CDS_OK ? (uint32_t)result : request.error * 256ul);
}

static void must(const char *name, enum cds_result submitted)
{
    ended(name, cds_blocking_for(&bus, &request, submitted));
}

/* --- one servo -----------------------------------------------------------------------------------
 */

static uint8_t calls;

static void count_call(struct cds_request *ended_request)
{
    (void)ended_request;
    calls++;
}

/* Three requests submitted at once: the one with priority overtakes the one that waits, one is
 * cancelled. */
static void queue(void)
{
    static uint8_t packets[3][CDS_PACKET_SIZE(3)];
    static struct cds_request waiting[3] = {CDS_REQUEST_WITHOUT_DATA(packets[0]),
                                            CDS_REQUEST_WITHOUT_DATA(packets[1]),
                                            CDS_REQUEST_WITHOUT_DATA(packets[2])};

    for (uint8_t i = 0; i < 3; i++)
        waiting[i].on_end = count_call;
    waiting[2].priority = CDS_PRIORITY_HIGH;
    cds_servo_ping(&bus, &request, 1);
    cds_servo_ping(&bus, &waiting[0], 2);
    cds_servo_ping(&bus, &waiting[1], 3);
    cds_servo_write_byte(&bus, &waiting[2], CDS_BROADCAST_ID, CDS_REG_LED, 1);
    say("cancel", cds_bus_cancel(&bus, &waiting[0]));
    while (cds_bus_poll(&bus)) {
    }
    say("queued", waiting[1].result == CDS_OK && waiting[2].result == CDS_OK);
    say("calls", calls);
}

static void one_servo(void)
{
    static const uint8_t goal[] = {0x00, 0x01, 0x00, 0x02}; // 256 at speed 512
    uint8_t byte = 0;
    uint16_t word = 0;

    ended("ping", cds_blocking_ping(&bus, &request, 3));
    ended("absent", cds_blocking_ping(&bus, &request, NOBODY));
    must("read", cds_servo_read(&bus, &request, 3, CDS_REG_RESERVED_00, 26));
    cds_request_byte(&request, CDS_REG_ID, &byte);
    cds_request_word(&request, CDS_REG_CCW_ANGLE_LIMIT, &word);
    say("id", byte);
    say("limit", word);
    must("write", cds_servo_write(&bus, &request, 3, CDS_REG_GOAL_POSITION, goal, 4));
    ended("byte", cds_blocking_write_byte(&bus, &request, 3, CDS_REG_TORQUE_ENABLE, 1));
    ended("word", cds_blocking_write_word(&bus, &request, 3, CDS_REG_MOVING_SPEED, 0x155));
    ended("is", cds_blocking_read_byte(&bus, &request, 3, CDS_REG_TORQUE_ENABLE, &byte));
    ended("is", cds_blocking_read_word(&bus, &request, 3, CDS_REG_MOVING_SPEED, &word));
    say("torque", byte);
    say("speed", word);
    ended("refused", cds_blocking_write_byte(&bus, &request, 3, CDS_REG_TORQUE_ENABLE, 2));
    must("no_id", cds_servo_ping(&bus, &request, 255));
    must("no_room", cds_servo_read(&bus, &request, 3, CDS_REG_RESERVED_00, 50));
    must("reg", cds_servo_reg_write(&bus, &request, 4, CDS_REG_GOAL_POSITION, goal, 4));
    must("action", cds_servo_action(&bus, &request, 4));
    must("again", cds_servo_action(&bus, &request, 4)); // nothing is registered
    queue();
}

/* --- units ---------------------------------------------------------------------------------------
 */

/* One writable register of each unit: the requested value and the value that the register holds. */
static void each_unit(void)
{
    static const struct {
        uint8_t address;
        int32_t value;
    } of[] = {
        {CDS_REG_ALARM_LED, 36},
        {CDS_REG_GOAL_POSITION, 150000},
        {CDS_REG_CW_COMPLIANCE_MARGIN, 880},
        {CDS_REG_MOVING_SPEED, 31000},
        {CDS_REG_MAX_TORQUE, 9000},
        {CDS_REG_MIN_VOLTAGE, 6500},
        {CDS_REG_MAX_TEMPERATURE, 75},
        {CDS_REG_RETURN_DELAY, 10},
        {CDS_REG_BAUD_RATE, 1000000},
    };
    int32_t value;

    for (uint8_t i = 0; i < sizeof of / sizeof of[0]; i++) {
        must("unit", cds_servo_units_write(&bus, &request, 5, servo, of[i].address, of[i].value));
        value = -1;
        cds_blocking_for(&bus, &request, cds_servo_read(&bus, &request, 5, of[i].address, 2));
        cds_servo_units_value(&request, 0, servo, of[i].address, &value);
        say_signed("is", value);
    }
}

static void present(uint8_t id)
{
    int32_t mdeg = -1, mrpm = -1, cpct = -1, mV = -1, celsius = -1;

    must("now", cds_servo_read(&bus, &request, id, CDS_REG_PRESENT_POSITION, 8));
    cds_servo_units_position_mdeg(&request, 0, &mdeg);
    cds_servo_units_speed_mrpm(&request, 2, servo, &mrpm);
    cds_servo_units_load_cpct(&request, 4, &cpct);
    cds_servo_units_voltage_mV(&request, 6, &mV);
    cds_servo_units_temperature_celsius(&request, 7, &celsius);
    say_signed("mdeg", mdeg);
    say_signed("mrpm", mrpm);
    say_signed("cpct", cpct);
    say_signed("mV", mV);
    say_signed("celsius", celsius);
}

static void units(void)
{
    each_unit();
    must("ramps", cds_servo_units_ramps(&bus, &request, 5, servo, 64, 64));
    must("torque", cds_servo_units_torque(&bus, &request, CDS_BROADCAST_ID, true));
    must("move", cds_servo_units_move_mdeg(&bus, &request, 5, servo, 180000, 62000));
    must("limits", cds_servo_units_limits_mdeg(&bus, &request, 6, 0, 0));
    must("turn", cds_servo_units_turn_mrpm(&bus, &request, 6, servo, -20000));
    _delay_ms(800);
    present(6);
    present(5);
    must("stop", cds_servo_units_turn_mrpm(&bus, &request, 6, servo, 0));
    must("limits", cds_servo_units_limits_mdeg(&bus, &request, 6, 0, 300000));
    must("too_far", cds_servo_units_move_mdeg(&bus, &request, 5, servo, 300001, 0));
    must("ax12", cds_servo_units_turn_cpct(&bus, &request, 6, servo, 100));
    must("ax12", cds_servo_units_torque_limit_cpct(&bus, &request, 6, servo, 100));
}

/* --- many servos ---------------------------------------------------------------------------------
 */

static void sync_write(void)
{
    static const uint8_t low[] = {0x90, 0x01, 0xFF, 0x03}; // 400 at 1023

    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    cds_sync_write_add(&request, 1, low);
    cds_sync_write_add_goal(&request, 2, 450, 1023);
    must("sync", cds_sync_write_send(&bus, &request));
}

static void registered_move(void)
{
    static struct cds_goal goals[] = {{.id = 3, .position = 600, .speed = 1023},
                                      {.id = 4, .position = 650, .speed = 1023},
                                      {.id = NOBODY, .position = 512}};
    static struct cds_registered_move move;

    for (uint8_t count = 3; count >= 2; count--) { // called off, then carried out
        struct cds_registered_move_config config = {
            .bus = &bus, .request = &request, .goals = goals, .count = count};

        say("armed", cds_blocking_registered_move(&move, &config));
    }
}

static void feedback(void)
{
    static struct cds_feedback told;
    enum cds_result result;
    uint32_t age_us;

    result = cds_blocking_feedback(&bus, &request, 4, &told);
    age_us = cds_feedback_age_us(&told);
    ended("asked", result);
    say("at", told.position);
    say("moving", told.moving);
    say("fresh", age_us < 100);
}

static void group_read(void)
{
    static const uint8_t ids[] = {1, 2, NOBODY, 3, 4};
    static uint8_t data[5 * 2];
    static struct cds_group_answer answers[5];
    static struct cds_group_read read;
    static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][2];
    static struct cds_request requests[2] = {CDS_REQUEST(packets[0], replies[0]),
                                             CDS_REQUEST(packets[1], replies[1])};

    say("group", cds_blocking_group_read(&read, &(struct cds_group_read_config){
                                                    .bus = &bus,
                                                    .requests = requests,
                                                    .ids = ids,
                                                    .data = data,
                                                    .answers = answers,
                                                    .count = 5,
                                                    .address = CDS_REG_PRESENT_POSITION,
                                                    .length = 2,
                                                }));
    for (uint8_t i = 0; i < 5; i++)
        say("at", answers[i].result ? answers[i].result : data[2 * i] + 256ul * data[2 * i + 1]);
    say("never", cds_group_read_age_us(&answers[2]) == CDS_GROUP_READ_NEVER);
}

static void cycle(void)
{
    static const uint8_t ids[] = {1, 2, 3, 4};
    static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(4)];
    static struct cds_feedback told[4];
    static struct cds_cycle at_250_Hz;
    bool young;

    say("begun",
        cds_cycle_begin(&at_250_Hz, &(struct cds_cycle_config){.bus = &bus,
                                                               .ids = ids,
                                                               .packets = packets,
                                                               .feedback = told,
                                                               .count = 4,
                                                               .period_us = CDS_CYCLE_PERIOD_US}));
    for (uint8_t i = 0; i < 4; i++)
        cds_cycle_goal(&at_250_Hz, i, 500u + i, 0);
    cds_cycle_commit(&at_250_Hz);
    while (at_250_Hz.counters.periods < PERIODS) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&at_250_Hz);
    }
    young = cds_cycle_oldest_us(&at_250_Hz) < 4000;
    cds_cycle_abort(&at_250_Hz);
    while (cds_cycle_poll(&at_250_Hz) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("young", young);
    say("periods", at_250_Hz.counters.periods);
    say("missed", at_250_Hz.counters.missed);
    say("failed", at_250_Hz.counters.failed);
    say("reads", at_250_Hz.counters.reads);
}

static void many_servos(void)
{
    sync_write();
    registered_move();
    _delay_ms(1000);
    feedback();
    group_read();
    cycle();
}

/* --- set-up --------------------------------------------------------------------------------------
 */

static struct cds_scan scan;
static struct cds_scan_found found[SERVOS + 1];

static struct cds_scan_config scan_config = {
    .bus = &bus, .request = &request, .found = found, .found_capacity = SERVOS + 1};

static void scanned(uint16_t abort_after)
{
    cds_scan_begin(&scan, &scan_config);
    while (cds_scan_poll(&scan) == CDS_PENDING) {
        cds_bus_poll(&bus);
        if (scan.asked == abort_after)
            cds_scan_abort(&scan);
    }
    say("scan", scan.steps.result);
    say("asked", scan.asked);
    for (uint8_t i = 0; i < scan.count && i <= SERVOS; i++)
        say("id", (uint32_t)found[i].id * 1000 + found[i].baud_reg);
}

static void at_own_rate(void)
{
    scan_config.first_id = 0;
    scan_config.last_id = CDS_ID_MAX;
    scan_config.baud_regs = &bus.baud_reg;
    scan_config.baud_count = 1;
    scanned(UINT16_MAX);
    scan_config.baud_regs = NULL;
    scan_config.baud_count = 0;
}

static void scans(void)
{
    at_own_rate();
    scan_config.last_id = 7;
    scan_config.reads_details = true;
    scanned(UINT16_MAX);
    for (uint8_t i = 0; i < scan.count && i <= SERVOS; i++)
        say("own", found[i].details ? found[i].details
                                    : (uint32_t)found[i].model * 1000 + found[i].own_baud_reg);
    scan_config.first_id = scan_config.last_id = 3;
    scan_config.tries_every_rate = true;
    scan_config.reads_details = false;
    scanned(3);
    scan_config.tries_every_rate = false;
}

static struct cds_identity identity;

static void settled(const char *name)
{
    while (cds_identity_poll(&identity) == CDS_PENDING)
        cds_bus_poll(&bus);
    say(name, identity.state);
    say("result", identity.steps.result);
}

static void change(const char *name, uint8_t what, uint8_t id, uint8_t value)
{
    cds_identity_begin(&identity, &(struct cds_identity_config){
                                      .bus = &bus,
                                      .request = &request,
                                      .change = what,
                                      .id = id,
                                      .new_id = value,
                                      .new_baud_reg = value,
                                  });
    settled(name);
}

static void identities(void)
{
    change("to_9", CDS_IDENTITY_ID, 6, 9);
    change("to_5", CDS_IDENTITY_ID, 9, 5); // taken
    change("lost", CDS_IDENTITY_ID, NOBODY, 78);
    cds_identity_look_again(&identity);
    settled("look");
    change("slow", CDS_IDENTITY_BAUD, 9, 3);
    say("baud", bus.baud_reg);
    at_own_rate();
    change("fast", CDS_IDENTITY_BAUD, 9, CDS_BAUD_1M);
    say("baud", bus.baud_reg);
    change("to_6", CDS_IDENTITY_ID, 9, 6);
    change("reset", CDS_IDENTITY_RESET, 6, 0); // 1 is taken
    change("reset", CDS_IDENTITY_RESET, 1, 0);
}

static struct cds_setup setting;

static void set_up(const char *name, const struct cds_setup_config *config)
{
    say(name, cds_blocking_setup(&setting, config));
    say("written", setting.is_written);
}

static void set_delay(const char *name, uint16_t delay_us)
{
    set_up(name, &(struct cds_setup_config){.bus = &bus,
                                            .request = &request,
                                            .id = 2,
                                            .setting = CDS_SETUP_RETURN_DELAY,
                                            .return_delay_us = delay_us});
}

static void settings(void)
{
    static const uint8_t punch[] = {0x60, 0x00};
    struct cds_setup_config config = {.bus = &bus,
                                      .request = &request,
                                      .id = 2,
                                      .address = CDS_REG_PUNCH,
                                      .length = 2,
                                      .data = punch};

    for (uint8_t i = 0; i < 2; i++) // it differs; it does not
        set_up("punch", &config);
    set_delay("delay", 20);
    config.setting = CDS_SETUP_LOCK;
    set_up("lock", &config);
    set_delay("locked", 40);
}

/* --- all of it -----------------------------------------------------------------------------------
 */

static void say_counters(void)
{
    struct cds_stats count;

    cds_bus_stats(&bus, &count);
    say("sent", count.sent);
    say("repeated", count.retried);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("refuted", count.malformed);
    say("foreign", count.unexpected_packets);
    say("framing", count.framing_errors);
    say("overruns", count.overruns);
    say("overflow", count.ring_overflows);
    say("echo", count.echo_errors);
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_queue_attach(&bus_queue, &bus);
    cds_bus_set_return_delay(&bus, 100);
    one_servo();
    units();
    many_servos();
    cds_queue_set_retries(&bus_queue, 2); // so that who is not there is asked three times
    ended("absent", cds_blocking_ping(&bus, &request, NOBODY));
    cds_queue_set_retries(&bus_queue, 0);
    scans();
    identities();
    settings();
    say_counters();
    change("all", CDS_IDENTITY_RESET_ALL, 0, 0);
    say_end();
}
